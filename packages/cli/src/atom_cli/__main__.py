"""`atom`: find, ask, do, listen, stop, pause, cancel, resume, status, history, memory, backup, restore, keys.

Exit codes: `atom --help`.
"""

import contextlib
import os
import signal
import tempfile
import time
from collections.abc import Callable, Generator
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Final, NoReturn, TypeVar

import httpx
import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from atom_cli import archive, doing, keys, listening, serving
from atom_cli import backup as copies
from atom_cli.following import told_ending, watched
from atom_cli.options import Host, PortBase
from atom_cli.services import OBEYED_S, AwayError, ServiceError, Services
from atom_cli.wording import ago, command_of, robot_lines
from contracts.backup import BackupService
from contracts.mission import Heard, Mission
from contracts.reading import Mood
from vocabulary.moods import read
from vocabulary.orders import order_in

T = TypeVar("T")

EXIT_REFUSED: Final = 3
EXIT_AWAY: Final = 4

HELP: Final = (
    "The robot from a terminal. Exit codes: 0 done (found) · 10 not found · 11 unsure · 12 cancelled · "
    "13 aborted · 1 not confirmed, or nobody spoke · 2 wrong usage · "
    "3 refused (no key, a wrong one, not now, or a bad back-up) · "
    "4 a service is away or not ready · 130 interrupted (the mission goes on)."
)
app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    help=HELP,
)
app.add_typer(keys.app, name="keys")
console = Console(highlight=False)
transport: httpx.BaseTransport | None = None
"""Set by tests; none = the network."""


Only = Annotated[list[BackupService] | None, typer.Option(help="this one's alone; several: said again")]


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"atom {version('atom-cli')}")
        raise typer.Exit


@app.callback(help=HELP)
def atom(
    _: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="say which version this is, and end")
    ] = False,
) -> None:
    """Nothing by itself: the commands do."""


@app.command()
def find(
    what: Annotated[str, typer.Argument(help='e.g. "red bottle", or a whole command: "bring me the teddy bear"')],
    host: Host = "127.0.0.1",
    port_base: PortBase = 8000,
) -> None:
    """Looks for something and tells how it goes, to the end. "stop", "wait" and "go on" act at once."""
    order = order_in(what)
    if order is None and read(what).mood in {Mood.QUESTION, Mood.COUNT}:
        ask(what, host, port_base)
        return
    with _services(host, port_base) as services:
        if order is not None and order.mood is not Mood.RESUME:
            mission = _or_exit(lambda: _obeyed(services, what, order.mood))
        else:
            mission = _or_exit(lambda: services.start(command_of(what)))
        if isinstance(mission, Heard):
            console.print(f"[bold]{mission.mood.value}[/]  {escape(mission.text)}", soft_wrap=True)
            return
        _follow(services, mission)


def _follow(services: Services, mission: Mission) -> NoReturn:
    """To its end, which is the exit code."""
    waiting = " (queued)" if mission.queue_position is not None else ""
    console.print(f"[bold]mission[/]  {escape(mission.command)}{waiting}  [dim]{mission.id}[/]", soft_wrap=True)
    try:
        ended = _or_exit(lambda: watched(console, services, mission))
    except KeyboardInterrupt:
        console.print("The mission goes on. `atom stop` stops the robot.")
        raise typer.Exit(130) from None
    raise typer.Exit(told_ending(console, ended))


@app.command(name="ask")
def ask(
    question: Annotated[str, typer.Argument(help='e.g. "how many bottles have you seen?"')],
    host: Host = "127.0.0.1",
    port_base: PortBase = 8000,
) -> None:
    """Asks what is known; nothing moves."""
    with _services(host, port_base) as services:
        answer = _or_exit(lambda: services.ask(question))
    console.print(escape(answer.answer), soft_wrap=True)
    if answer.notes:
        console.print(f"[dim]{escape(answer.notes)}[/]", soft_wrap=True)


@app.command()
def listen(
    file: Annotated[
        Path | None, typer.Option("--file", help="a WAV instead of the microphone (pip install 'atom-cli[listen]')")
    ] = None,
    send: Annotated[bool, typer.Option("--send", help="do not ask before it is sent")] = False,
    host: Host = "127.0.0.1",
    port_base: PortBase = 8000,
) -> None:
    """Listens once, says what it heard, and sends it when you agree. An order to stop acts at once."""
    sound = listening.sound_of(file, console)
    with _services(host, port_base) as services:
        transcript = _or_exit(lambda: listening.heard_by(services, sound))
        if transcript.stop:
            _or_exit(services.stop)
        listening.told(console, transcript)
        if transcript.stop:
            console.print("[bold red]stopped[/]. `atom resume` permits motion again.")
            return
        if transcript.no_speech:
            console.print("Nobody spoke.")
            raise typer.Exit(listening.EXIT_NOTHING_MEANT)
        understood = _or_exit(lambda: services.understand((transcript.hot_text, transcript.text)))
    find(listening.meant(console, understood, send=send).command, host, port_base)


@app.command()
def stop(host: Host = "127.0.0.1", port_base: PortBase = 8000) -> None:
    """Stops the robot at once, whatever else is running."""
    with _services(host, port_base) as services:
        reply = _or_exit(services.stop)
    after = "" if reply.first_zero_ms is None else f", first zero velocity after {reply.first_zero_ms:.1f} ms"
    console.print(f"[bold red]stopped[/]{after}. `atom resume` permits motion again.")


@app.command()
def resume(
    host: Host = "127.0.0.1",
    port_base: PortBase = 8000,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="do not ask")] = False,
) -> None:
    """Permits motion again after a stop. Nothing moves until something asks for it."""
    if not yes:
        typer.confirm("Look at the robot first. Let it move again?", abort=True)
    with _services(host, port_base) as services:
        _or_exit(services.resume)
    console.print("Motion is permitted again.")


@app.command()
def status(host: Host = "127.0.0.1", port_base: PortBase = 8000) -> None:
    """What the robot is at, and who is missing. Exit code 4 when a service is, else 3 when one refuses to tell."""
    codes = {0}
    table = Table(show_header=False, box=None, padding=(0, 2, 0, 0))
    with _services(host, port_base) as services:
        try:
            now = services.status()
            mission = now.mission
            running = mission is not None and mission.outcome is None
            said = f"{now.state.value}: {now.progress or (mission.reason if mission else '')}" if running else "idle"
            table.add_row("mission", escape(f"“{mission.command}” {said}" if mission and running else said))
            table.add_row("queue", str(len(now.queue)))
        except ServiceError as error:
            codes.add(_code(error))
            table.add_row("mission", f"[red]{escape(str(error))}[/]")
        try:
            for name, value in robot_lines(services.robot()):
                table.add_row(name, escape(value))
        except ServiceError as error:
            codes.add(_code(error))
            table.add_row("robot", f"[red]{escape(str(error))}[/]")
        for service in ("coordinator", "inference", "memory", "robot_bridge"):
            lack = services.ready(service)
            codes.add(EXIT_AWAY if lack else 0)
            table.add_row(service, f"[red]{escape(lack)}[/]" if lack else "[green]ready[/]")
    console.print(table)
    if code := max(codes):
        raise typer.Exit(code)


@app.command()
def memory(
    label: Annotated[str | None, typer.Argument(help="only this kind of thing, e.g. bottle")] = None,
    host: Host = "127.0.0.1",
    port_base: PortBase = 8000,
) -> None:
    """What is remembered: things with their place, age and belief, then kinds."""
    with _services(host, port_base) as services:
        things, labels = _or_exit(lambda: (services.objects(label), services.labels()))
    table = Table("thing", "state", "belief", "seen", "place", box=None, padding=(0, 2, 0, 0))
    for one in sorted(things, key=lambda one: -one.belief):
        place = f"{one.position.x:.2f} / {one.position.y:.2f} m"
        table.add_row(
            escape(one.description), one.state.value, f"{100 * one.belief:.0f} %", ago(one.last_seen_s), place
        )
    console.print(table if things else "No thing is remembered with a place.")
    kinds = ", ".join(f"{one.label} ({one.views})" for one in labels if label in {None, one.label})
    console.print(f"[bold]views[/]  {escape(kinds or 'none')}", soft_wrap=True)


@app.command()
def backup(
    file: Annotated[Path, typer.Argument(help="the archive to write, e.g. atom-backup.tar", dir_okay=False)],
    only: Only = None,
    force: Annotated[bool, typer.Option("--force", help="replace a file that is there")] = False,
    host: Host = "127.0.0.1",
    port_base: PortBase = 8000,
) -> None:
    """Writes what is remembered, what was explored and the history of missions into one file; the robot goes on."""
    if file.exists() and not force:
        raise typer.BadParameter(f"{file} is there already; --force replaces it", param_hint="FILE")
    with _services(host, port_base) as services, _saying():
        manifest = copies.back_up(services, file, _wanted(only), time.time())
    for one in manifest.databases:
        console.print(f"{one.service.value:<12} {one.size_bytes / 1e6:.1f} MB, schema {one.revision}")
    console.print(f"written to {escape(str(file))}; it shows what your home looks like: keep it as you keep a key")


@app.command()
def restore(
    file: Annotated[Path, typer.Argument(help="an archive that `atom backup` wrote", exists=True, dir_okay=False)],
    only: Only = None,
    check: Annotated[bool, typer.Option("--check", help="check it, and change nothing")] = False,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="do not ask")] = False,
    host: Host = "127.0.0.1",
    port_base: PortBase = 8000,
) -> None:
    """Replaces what is remembered, explored, and the history of missions by a back-up's. Not while a mission runs."""
    with tempfile.TemporaryDirectory(prefix="atom-restore-") as folder, _saying():
        manifest, files = archive.unpack(file, Path(folder))
        wanted = _wanted(only) if only else tuple(one for one in copies.EVERY if one in files)
        if lacking := [one.value for one in wanted if one not in files]:
            raise archive.ArchiveError(f"it holds nothing of {' and '.join(lacking)}")
        made = time.strftime("%Y-%m-%d %H:%M", time.localtime(manifest.made_s))
        if not check and not yes:
            names = " and ".join(one.value for one in wanted)
            typer.confirm(f"Replace all that {names} hold now by what was so on {made}?", abort=True)
        with _services(host, port_base) as services:
            replies = copies.restore(services, files, wanted, dry_run=check)
    for service, reply in replies.items():
        rows = ", ".join(f"{count} {table}" for table, count in reply.rows.items())
        kept = f"; what was there before: {reply.kept_as}" if reply.kept_as else ""
        console.print(f"{service.value:<12} {escape(rows)}{escape(kept)}", soft_wrap=True)
    console.print("It is sound; nothing was changed." if check else f"Restored as it was on {made}.")


def _wanted(only: list[BackupService] | None) -> tuple[BackupService, ...]:
    return tuple(one for one in copies.EVERY if not only or one in only)


@contextlib.contextmanager
def _saying() -> Generator[None]:
    """Troubles of a back-up as a sentence and an exit code."""
    try:
        yield
    except ServiceError as error:
        _fail(error)
    except copies.HalfwayError as error:
        names = " and ".join(one.value for one in error.put_back)
        console.print(
            f"[bold red]failed[/]   {escape(str(error.cause) or 'interrupted')}."
            + f" {names} {'has again what it' if len(error.put_back) == 1 else 'have again what they'} had before."
            * bool(names)
            + f" {error.failed.value} may have taken it, or still will: look." * error.unknown,
            soft_wrap=True,
        )
        raise typer.Exit(_code(error.cause) if isinstance(error.cause, ServiceError) else 130) from None
    except (archive.ArchiveError, copies.MissionOnError, copies.NotPutBackError, OSError) as error:
        console.print(f"[bold red]failed[/]   {escape(str(error))}", soft_wrap=True)
        raise typer.Exit(EXIT_REFUSED) from None


def _services(host: str, port_base: int) -> Services:
    return Services(host, port_base, key=_key(), transport=transport)


def _key() -> str:
    """Of whoever asks: ATOM_KEY, or what ATOM_KEY_FILE holds; never an argument, which every process list shows."""
    file = os.environ.get("ATOM_KEY_FILE", "")
    try:
        key = (os.environ.get("ATOM_KEY") or (Path(file).read_text(encoding="utf-8") if file else "")).strip()
    except (OSError, UnicodeDecodeError) as error:  # said, and gone on without: a stop needs no key
        console.print(f"ATOM_KEY_FILE: {escape(str(error))}", soft_wrap=True)
        return ""
    if key.isascii() and key.isprintable():
        return key
    console.print("ATOM_KEY holds letters that no key has: it is not used")
    return ""


def _obeyed(services: Services, what: str, mood: Mood) -> Mission | Heard:
    """An order. A stop that the coordinator does not confirm becomes the emergency stop."""
    if mood is not Mood.EMERGENCY:
        with contextlib.suppress(ServiceError):
            heard = services.start(what, timeout_s=OBEYED_S)
            if not isinstance(heard, Heard) or heard.still or mood is Mood.PAUSE:
                return heard
    services.stop()
    return Heard(mood=Mood.EMERGENCY, text="the emergency stop is set; `atom resume` permits motion again", still=True)


def _or_exit(ask: Callable[[], T]) -> T:
    try:
        return ask()
    except ServiceError as error:
        _fail(error)


def _fail(error: ServiceError) -> NoReturn:
    console.print(f"[bold red]failed[/]   {escape(str(error))}", soft_wrap=True)
    raise typer.Exit(_code(error))


def _code(error: ServiceError) -> int:
    return EXIT_AWAY if isinstance(error, AwayError) else EXIT_REFUSED


doing.add_to(app, doing.Terminal(console, _services, _or_exit, _follow))
serving.add_to(app, _key)


def main() -> None:
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    app()


if __name__ == "__main__":
    main()
