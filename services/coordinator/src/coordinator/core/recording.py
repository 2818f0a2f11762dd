"""A mission as data: its settings, where it began, and every event with its time and what was decided on it.

One JSON object a line: first a `Header`, then a `Step` each. Because `step` is pure, feeding the events again gives the
same decisions; an event that changed nothing and asked for nothing is left out, which changes nothing either.
"""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, get_args

from pydantic import TypeAdapter

from contracts.mission import MissionState
from coordinator.core.actions import Action, Say
from coordinator.core.events import Event
from coordinator.core.mission import Mission, RobotSnapshot
from coordinator.core.rules import Rules
from coordinator.core.step import step

FORM = 5
"""Of what is written. Raise it when a recorded name or field changes: other forms are refused, not translated."""


@dataclass(frozen=True, slots=True)
class Header:
    form: int
    mission_id: str
    begun_s: float
    rules: Rules
    robot: RobotSnapshot
    calls: int


@dataclass(frozen=True, slots=True)
class Step:
    """One event at one time, what was done about it, and the state afterwards."""

    now_s: float
    event: Event
    actions: tuple[Action, ...]
    state: MissionState


@dataclass(frozen=True, slots=True)
class Recording:
    header: Header
    steps: tuple[Step, ...]


@dataclass(frozen=True, slots=True)
class Replayed:
    """A recorded step beside what the core decides on it now."""

    recorded: Step
    before: Mission
    after: Mission
    actions: tuple[Action, ...]

    @property
    def same(self) -> bool:
        """As written down, whatever words a line of the timeline has: what is decided are types."""
        decided, recorded = ([_decided(a) for a in some] for some in (self.actions, self.recorded.actions))
        return decided == recorded and self.after.state is self.recorded.state


class MalformedRecordingError(ValueError):
    """Not a recording, or one of another form."""


def header_of(mission: Mission, mission_id: str, now_s: float) -> Header:
    """Of a mission about to begin: `mission` is what the core holds before its `MissionStarted`."""
    return Header(FORM, mission_id, now_s, mission.rules, mission.robot, mission.calls)


def replay(recording: Recording) -> Iterator[Replayed]:
    """Every step again, through the core as it is now."""
    header = recording.header
    mission = Mission(rules=header.rules, robot=header.robot, calls=header.calls)
    for recorded in recording.steps:
        before = mission
        mission, actions = step(before, recorded.event, recorded.now_s)
        yield Replayed(recorded, before, mission, actions)


def header_line(header: Header) -> str:
    return _HEADER.dump_json(header).decode()


def step_line(recorded: Step) -> str:
    plain = {
        "now_s": recorded.now_s,
        "event": _named(recorded.event),
        "actions": [_named(action) for action in recorded.actions],
        "state": recorded.state.value,
    }
    return _PLAIN.dump_json(plain).decode()


def read(lines: Iterable[str]) -> Recording:
    """Raises `MalformedRecordingError`."""
    rows = iter(lines)
    try:
        header = _PLAIN.validate_json(next(rows))
        if header["form"] != FORM:
            raise MalformedRecordingError(
                f"a recording of form {header['form']}, and only form {FORM} can be decided again; "
                "the mission's report and timeline open as before"
            )
        plain = (_PLAIN.validate_json(row) for row in rows if row.strip())
        return Recording(_HEADER.validate_python(header), tuple(_step(one) for one in plain))
    except StopIteration:
        raise MalformedRecordingError("it is empty") from None
    except (KeyError, TypeError) as error:
        raise MalformedRecordingError(f"an unknown event, action or field: {error}") from error
    except ValueError as error:
        raise MalformedRecordingError(str(error)[:300]) from error


def _step(plain: dict[str, Any]) -> Step:
    return Step(
        now_s=float(plain["now_s"]),
        event=_unnamed(plain["event"]),
        actions=tuple(_unnamed(action) for action in plain["actions"]),
        state=MissionState(plain["state"]),
    )


def _named(value: Any) -> dict[str, Any]:
    name = type(value).__name__
    return {"is": name, **_KINDS[name].dump_python(value, mode="json")}


def _decided(action: Action) -> dict[str, Any]:
    """Without words, and to the ninth digit: how a number was computed is no decision."""
    named = _named(action) | ({"text": "", "data": None} if isinstance(action, Say) else {})
    return json.loads(_PLAIN.dump_json(named), parse_float=lambda digits: round(float(digits), 9))


def _unnamed(plain: dict[str, Any]) -> Any:
    return _KINDS[plain["is"]].validate_python({name: value for name, value in plain.items() if name != "is"})


_HEADER = TypeAdapter(Header)
_PLAIN = TypeAdapter(dict[str, Any])
KINDS: tuple[type[Any], ...] = (*get_args(Event), *get_args(Action))
_KINDS: dict[str, TypeAdapter[Any]] = {kind.__name__: TypeAdapter(kind) for kind in KINDS}
