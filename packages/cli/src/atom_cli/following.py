"""A mission followed on a terminal until it ends."""

import time
from collections.abc import Callable

from rich.console import Console
from rich.markup import escape

from atom_cli.services import AwayError, Services
from contracts.mission import Mission, MissionStatus

POLL_S = 0.4


def watched(console: Console, services: Services, mission: Mission) -> Mission:
    """Tells each event as it comes, below them what it is at; returns the mission when it has ended."""
    with console.status("…") as line:  # says nothing where the output is not a terminal
        return _told(console, services, mission, lambda text: line.update(escape(text)))


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
