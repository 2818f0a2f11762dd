"""`atom do ACTION --...`: a command for each declared action, made from it; `pause`, `cancel`, `history`."""

import inspect
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Annotated, Any, Final, Protocol, TypeVar

import typer
from pydantic import ValidationError
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from atom_cli.options import Host, PortBase
from atom_cli.services import OBEYED_S, ServiceError, Services
from atom_cli.wording import ago
from contracts.actions import (
    ACTION,
    SPECS,
    Action,
    ActionName,
    ActionReply,
    ActionSpec,
    CancelAction,
    PauseAction,
    tool_schema,
)
from contracts.mission import Mission

T = TypeVar("T")
TYPES: Final[dict[object, Any]] = {"number": float, "string": str, "array": list[str]}
LEFT_OUT: Final = inspect.Parameter.empty


class OrExit(Protocol):
    def __call__(self, ask: Callable[[], T]) -> T: ...


@dataclass(frozen=True, slots=True)
class Terminal:
    """What the commands are given by `atom`: where to print, whom to ask, and how a mission is followed to its end."""

    console: Console
    services: Callable[[str, int], AbstractContextManager[Services]]
    or_exit: OrExit
    follow: Callable[[Services, Mission], None]
    """Raises `typer.Exit` with the code of its outcome."""


def add_to(app: typer.Typer, terminal: Terminal) -> None:
    doing = typer.Typer(
        no_args_is_help=True, help="Does one declared action (docs/actions.md); what moves is followed."
    )
    for name, spec in SPECS.items():
        doing.command(name=name.value.replace("_", "-"), help=_help(spec))(_command(terminal, name))
    app.add_typer(doing, name="do")
    app.command(help=SPECS[ActionName.PAUSE].sentence + " `atom do resume` lets it go on.")(
        _ordering(terminal, PauseAction)
    )
    app.command(help=SPECS[ActionName.CANCEL].sentence)(_ordering(terminal, CancelAction))
    app.command(help="The newest missions, how each ended and why.")(_history(terminal))


def _help(spec: ActionSpec) -> str:
    ends = f" Ends as: {', '.join(end.value for end in spec.ends)}." if spec.ends else ""
    return f"{spec.sentence}{ends}"


def _command(terminal: Terminal, name: ActionName) -> Callable[..., None]:
    """A function whose signature is the declaration: the terminal's options are made of that."""

    def run(*, host: str, port_base: int, **said: Any) -> None:
        action = _checked(name, {key: value for key, value in said.items() if value not in (None, [])})
        with terminal.services(host, port_base) as services:
            reply = _stopped(terminal, services, action) if name is ActionName.STOP else None
            reply = reply or terminal.or_exit(lambda: services.do(action))
            _told(terminal, services, reply, follow=SPECS[name].moves)

    parameters = [*_options(name), *_common()]
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {one.name: one.annotation for one in parameters}
    run.__name__ = name.value
    return run


def _options(name: ActionName) -> list[inspect.Parameter]:
    schema: dict[str, Any] = tool_schema(name).parameters  # as a model is given them
    found: list[inspect.Parameter] = []
    for key, argument in schema["properties"].items():
        needed = key in schema["required"]
        bounds = [f"{word} {argument[of]:g}" for word, of in (("from", "minimum"), ("to", "maximum")) if of in argument]
        told = "; ".join([argument["description"], *([" ".join(bounds)] if bounds else [])])
        again = "; several: said again" * (argument["type"] == "array")
        option = typer.Option(f"--{key.replace('_', '-')}", help=told + again)
        kind = TYPES[argument["type"]]
        annotation = Annotated[kind if needed else kind | None, option]
        found.append(_parameter(key, annotation, LEFT_OUT if needed else None))
    return found


def _common() -> list[inspect.Parameter]:
    return [_parameter("host", Host, "127.0.0.1"), _parameter("port_base", PortBase, 8000)]


def _parameter(name: str, annotation: Any, default: Any) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, annotation=annotation, default=default)


def _checked(name: ActionName, said: dict[str, Any]) -> Action:
    """Raises `typer.BadParameter`, before anything is sent."""
    try:
        return ACTION.validate_python({"action": name, **said})
    except ValidationError as error:
        first = error.errors()[0]
        where = " ".join(f"--{str(part).replace('_', '-')}" for part in first["loc"][1:] if isinstance(part, str))
        raise typer.BadParameter(first["msg"].removeprefix("Value error, "), param_hint=where or None) from None


def _stopped(terminal: Terminal, services: Services, action: Action) -> ActionReply | None:
    """None: it was not confirmed in time, and became the emergency stop."""
    try:
        reply = services.do(action, timeout_s=OBEYED_S)
    except ServiceError:
        reply = None
    if reply is not None and reply.heard is not None and reply.heard.still:
        return reply
    terminal.or_exit(services.stop)
    text = "the emergency stop is set; `atom resume` permits motion again"
    return ActionReply(action=ActionName.STOP, text=text)


def _told(terminal: Terminal, services: Services, reply: ActionReply, *, follow: bool) -> None:
    if not follow or reply.mission is None:
        terminal.console.print(escape(reply.text), soft_wrap=True)
        if reply.answer is not None and reply.answer.notes:
            terminal.console.print(f"[dim]{escape(reply.answer.notes)}[/]", soft_wrap=True)
        return
    terminal.follow(services, reply.mission)


def _ordering(terminal: Terminal, order: type[PauseAction] | type[CancelAction]) -> Callable[..., None]:
    def run(mission_id: str | None = None, host: str = "127.0.0.1", port_base: int = 8000) -> None:
        action = _checked(order.model_fields["action"].default, {"mission_id": mission_id} if mission_id else {})
        with terminal.services(host, port_base) as services:
            reply = terminal.or_exit(lambda: services.do(action))
        terminal.console.print(escape(reply.text), soft_wrap=True)

    which = Annotated[str | None, typer.Argument(metavar="[MISSION]", help="its id; none = the one that runs")]
    run.__annotations__ = {"mission_id": which, "host": Host, "port_base": PortBase}
    run.__name__ = str(order.model_fields["action"].default.value)
    return run


def _history(terminal: Terminal) -> Callable[..., None]:
    limit_of = Annotated[int, typer.Option(min=1, max=200, help="so many, the newest first")]

    def run(limit: int = 20, host: str = "127.0.0.1", port_base: int = 8000) -> None:
        with terminal.services(host, port_base) as services:
            missions = terminal.or_exit(lambda: services.missions(limit))
        table = Table("when", "asked", "ended", "why", box=None, padding=(0, 2, 0, 0))
        for one in missions:
            word = (
                one.outcome.value if one.outcome is not None else "queued" if one.queue_position is not None else "runs"
            )
            text = one.report.text if one.report is not None else one.reason
            table.add_row(_when(one), escape(one.command), word, escape(text))
        terminal.console.print(table if missions else "No mission is known.")

    run.__annotations__ = {"limit": limit_of, "host": Host, "port_base": PortBase}
    run.__name__ = "history"
    return run


def _when(mission: Mission) -> str:
    stamp_s = mission.ended_s if mission.ended_s is not None else mission.started_s
    return ago(min(stamp_s, time.time()))
