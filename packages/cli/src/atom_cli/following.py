"""A mission followed on a terminal until it ends."""

import time
from collections.abc import Callable
from typing import Final

from rich.console import Console
from rich.markup import escape

from atom_cli.services import AwayError, Services
from contracts.mission import Mission, MissionStatus, Outcome

POLL_S = 0.4
EXIT: Final = {
    Outcome.FOUND: 0,
    Outcome.DOCKED: 0,
    Outcome.DONE: 0,
    Outcome.NOT_FOUND: 10,
    Outcome.UNSURE: 11,
    Outcome.CANCELED: 12,
    Outcome.ABORTED: 13,
    Outcome.INTERRUPTED: 13,
}
TONES: Final = {0: "bold green", 10: "bold yellow", 11: "bold yellow"}


def watched(console: Console, services: Services, mission: Mission) -> Mission:
    """Tells each event as it comes, below them what it is at; returns the mission when it has ended."""
    with console.status("…") as line:  # says nothing where the output is not a terminal
        return _told(console, services, mission, lambda text: line.update(escape(text)))


def told_ending(console: Console, ended: Mission) -> int:
    """Tells the report; the exit code of how it ended."""
    assert ended.outcome is not None, "only an ended mission is told"
    code = EXIT[ended.outcome]
    text = ended.report.text if ended.report is not None else ended.reason
    console.print(f"[{TONES.get(code, 'bold red')}]{ended.outcome.value:<8}[/] {escape(text)}", soft_wrap=True)
    for vote in ended.votes:
        console.print(f"  {vote.voter:<9} {vote.verdict.value:<8} {escape(vote.reason)}", soft_wrap=True)
    return code


def _told(console: Console, services: Services, mission: Mission, at: Callable[[str], None]) -> Mission:
    after, silent = -1, 0
    while True:
        ended = mission.outcome is not None
        try:
            for event in services.events(mission.id, after=after):
                after = event.id
                at_s = max(0.0, event.stamp_s - mission.started_s)
                console.print(
                    f"[dim]{at_s:6.1f} s[/]  [cyan]{event.state.value:<15}[/] {escape(event.text)}", soft_wrap=True
                )
            if ended:
                return mission
            time.sleep(POLL_S)
            mission = services.mission(mission.id)
            at(progress_of(mission, services.status()))
            silent = 0
        except AwayError:
            at("the coordinator does not answer")
            silent += 1
            if silent > 30:
                raise
            time.sleep(POLL_S)


def progress_of(mission: Mission, now: MissionStatus) -> str:
    """Phase, seconds and what is next, for as long as the mission runs."""
    if mission.queue_position is not None:
        return f"queued, {mission.queue_position} before it"
    if now.mission is None or now.mission.id != mission.id:
        return mission.state.value
    what = f"waiting for {now.waiting_for}" if now.waiting_for else now.progress or mission.reason
    paused = "paused, " if mission.paused else ""
    return f"{max(0.0, now.stamp_s - mission.started_s):.0f} s  {paused}{mission.state.value}  {what}"
