"""`python -m demo`: up, down, and the demo itself, with a live timeline on the terminal."""

import signal
import time
from contextlib import ExitStack
from pathlib import Path
from types import FrameType
from typing import Annotated, Any, NoReturn

import httpx
import typer
from rich.console import Console
from rich.markup import escape

from contracts.mission import MissionEvent
from demo.mapping import tour
from demo.mission_watch import start_mission, watch
from demo.ready import wait_until_ready
from demo.report import write_report
from demo.scenario import wanted_in
from demo.stack import Ports, Stack, StackError
from sim.home import Home

app = typer.Typer(add_completion=False, help="The whole mesh with a simulated robot, on this machine.")
console = Console(highlight=False)

OUT = Path("out/demo")
PortBase = Annotated[int, typer.Option(help="ports are this + 1..7 and + 80 (the page)", min=1024, max=65000)]
Seed = Annotated[int, typer.Option(help="of the generated home")]
Command = Annotated[str, typer.Option(help="what to say to the robot")]
WithTour = Annotated[bool, typer.Option("--tour/--no-tour", help="start with the memory of a mapping tour")]
WithSpeech = Annotated[
    bool, typer.Option("--speech/--no-speech", help="start the speech service: the page hears and speaks")
]


@app.command()
def run(
    command: Command = "find the red bottle",
    seed: Seed = 0,
    port_base: PortBase = 8000,
    once: Annotated[bool, typer.Option(help="exit when done: 0 only if ground truth agrees")] = False,
    with_tour: WithTour = True,
    with_speech: WithSpeech = False,
    mission_timeout_s: Annotated[float, typer.Option(help="give up watching after this time")] = 1200.0,
) -> None:
    """Starts everything, sends the command, tells what happens, scores it against ground truth."""
    stack = _stack(port_base, seed, command, with_speech=with_speech)
    told: dict[str, Any] = {}
    try:
        process = _start(stack, with_tour=with_tour)
        try:
            _say("mission", f'"{command}"')
            mission = start_mission(stack.ports, command)
            watched = watch(stack.ports, mission, on_event=_timeline(time.time()), timeout_s=mission_timeout_s)
            told = write_report(OUT, stack.ports, watched, command=command, seed=seed)
            _summary(told)
            if not once:
                _say(
                    "up",
                    f"the page: {stack.ports.url('ui')}   "
                    f"stop: curl -X POST {stack.ports.url('robot_bridge')}/emergency-stop",
                )
                _say("up", "Ctrl-C ends everything")
                signal.pause()
        finally:
            _say("down", "ending every process")
            stack.stop(process)
    except (StackError, httpx.HTTPError) as error:
        _fail(str(error))
    raise typer.Exit(0 if told.get("correct") else 1)


@app.command()
def up(
    seed: Seed = 0,
    port_base: PortBase = 8000,
    command: Command = "find the red bottle",
    with_tour: WithTour = True,
    with_speech: WithSpeech = False,
) -> None:
    """Starts everything and returns; `down` ends it. The home holds what the command names."""
    stack = _stack(port_base, seed, command, with_speech=with_speech)
    try:
        _start(stack, with_tour=with_tour)
    except StackError as error:
        stack.stop()
        _fail(str(error))
    _say("up", f"the page: {stack.ports.url('ui')}   logs: {stack.logs}   end with: make down PORT_BASE={port_base}")


@app.command()
def down(port_base: PortBase = 8000) -> None:
    """Ends what `up` started."""
    stack = Stack(Ports(port_base), _folder(port_base), Path(), 0)
    if not stack.running():
        _fail(f"nothing runs on port base {port_base}")
    stack.stop()
    _say("down", "every process has ended")


def _folder(port_base: int) -> Path:
    return (OUT / str(port_base)).resolve()


def _stack(port_base: int, seed: int, command: str, *, with_speech: bool) -> Stack:
    """A stack with a freshly generated home, an empty memory and an empty history."""
    folder = _folder(port_base)
    stack = Stack(Ports(port_base), folder, folder / "home.json", seed, speech=with_speech)
    if stack.running():
        _fail(f"a mesh already runs on port base {port_base}: make down PORT_BASE={port_base}")
    folder.mkdir(parents=True, exist_ok=True)
    stack.forget()
    Home.generate(seed, wanted=wanted_in(command)).save(stack.home)
    return stack


def _start(stack: Stack, *, with_tour: bool) -> Any:
    _say(
        "start",
        f"home of seed {stack.seed}, ports {stack.ports.base + 1}..{stack.ports.base + 80}, logs in {stack.logs}",
    )
    process = stack.start()
    with ExitStack() as unless_started:
        unless_started.callback(stack.stop, process)
        seconds = wait_until_ready(
            stack,
            timeout_s=240.0,
            on_ready=lambda part, s: _say("ready", f"{part} after {s:.1f} s"),
            alive=lambda: process.poll() is None,
        )
        _say("ready", f"every service is ready after {seconds:.1f} s")
        if with_tour:
            _tour(stack)
        unless_started.pop_all()
    return process


def _tour(stack: Stack) -> None:
    _say(
        "mapping",
        "a tour of the home fills the memory: the robot is placed at each pose, frames go through the detector",
    )
    started = time.monotonic()
    with console.status("looking") as status:
        frames, stored = tour(
            Home.load(stack.home),
            seed=stack.seed,
            ports=stack.ports,
            on_frame=lambda n: status.update(f"{n} frames looked at"),
        )
    _say("mapping", f"{frames} frames, {stored} observations, {time.monotonic() - started:.0f} s")


def _timeline(started_s: float) -> Any:
    def show(event: MissionEvent) -> None:
        elapsed_s = event.stamp_s - started_s
        console.print(
            f"[dim]{max(0.0, elapsed_s):6.1f} s[/]  [cyan]{event.state:<15}[/] {escape(event.text)}", soft_wrap=True
        )

    return show


def _summary(told: dict[str, Any]) -> None:
    rows = {f"vote: {vote['voter']}": f"{vote['verdict']:<7} {vote['reason']}" for vote in told["votes"]}
    rows |= {key: str(told[key]) for key in ("outcome", "reason", "seconds", "metres")}
    rows |= {key: _metres(told[key]) for key in ("measured_distance_m", "true_distance_m", "nearest_possible_m")}
    rows["real_time_factor"] = f"{told['real_time_factor']:.3f}" if told["real_time_factor"] else "unknown"
    rows["correct"] = "yes: ground truth agrees" if told["correct"] else "no"
    for name, value in rows.items():
        console.print(f"  {name:<20} {escape(value)}", soft_wrap=True)
    _say("files", f"{OUT}/mission.json, frame.jpg, map.png, events.json")


def _metres(distance_m: float | None) -> str:
    return "unknown" if distance_m is None else f"{distance_m:.2f}"


def _say(what: str, text: str) -> None:
    console.print(f"[bold]{what:<8}[/] {text}", soft_wrap=True)


def _fail(text: str) -> NoReturn:
    console.print(f"[bold red]failed[/]   {text}", soft_wrap=True)
    raise typer.Exit(1)


def _interrupted(number: int, frame: FrameType | None) -> NoReturn:
    raise KeyboardInterrupt


if __name__ == "__main__":
    for ending in (signal.SIGINT, signal.SIGTERM):  # a shell's background jobs start with SIGINT ignored
        signal.signal(ending, _interrupted)
    app()
