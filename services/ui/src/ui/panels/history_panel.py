"""Missions that were: how each ended and on what, opened in the timeline from the coordinator's records."""

import datetime
from collections.abc import Callable, Coroutine

from nicegui import ui as nicegui_ui

from contracts.mission import Candidate, Mission
from mesh.errors import MeshError
from ui import timeline_lines
from ui.desk import Desk
from ui.i18n import _
from ui.operator_actions import in_words
from ui.panels.timeline import Timeline
from ui.panels.widgets import ChipRow, Rows, box


class HistoryPanel:
    def __init__(self, desk: Desk, timeline: Timeline, open_timeline: Callable[[], None]) -> None:
        self._desk = desk
        self._timeline = timeline
        self._open_timeline = open_timeline
        with box("history"):
            self._note = nicegui_ui.label(_("No mission yet.")).classes("empty").props("role=status")
            self._rows = Rows[Mission](
                nicegui_ui.element("ol").classes("missions").props(f'aria-label="{_("Missions, newest first")}"'),
                key=lambda mission: mission.id,
                make=lambda: PastRow(self._fill),
            )

    async def show(self) -> None:
        """Asks the coordinator; called when the tab is opened and while it is."""
        try:
            missions = tuple(await self._desk.history())
        except MeshError as error:
            self._note.set_text(in_words(error))
            self._note.set_visibility(True)
            return
        self._note.set_text(_("No mission yet."))
        self._note.set_visibility(not missions)
        self._rows.show(missions)

    def _fill(self, mission: Mission) -> None:
        with box("past"):
            with box("row between"):
                nicegui_ui.label(f"“{mission.command}”").classes("headline")
                nicegui_ui.label(_when(mission.started_s)).classes("event-time")
            ChipRow().show(timeline_lines.ending_chips(mission))
            report = mission.report
            nicegui_ui.label(report.text if report is not None else mission.reason).classes("reason")
            if report is not None:
                for candidate in (*((report.found,) if report.found is not None else ()), *report.candidates):
                    self._candidate(mission, candidate)
            nicegui_ui.button(_("Replay"), on_click=self._opener(mission), color=None).props(
                "outline dense no-caps"
            ).classes("act").props["aria-label"] = _("Open the timeline of {command}", command=mission.command)

    def _candidate(self, mission: Mission, candidate: Candidate) -> None:
        with box("row candidate"):
            if candidate.picture is not None:
                nicegui_ui.element("img").classes("crop").props(f"src=crops/{mission.id}/{candidate.picture}").props[
                    "alt"
                ] = candidate.text
            with box("saying"):
                nicegui_ui.label(candidate.text).classes("event-text")
                ChipRow("votes").show(timeline_lines.vote_chips(candidate.votes))

    def _opener(self, mission: Mission) -> Callable[[], Coroutine[object, object, None]]:
        async def clicked() -> None:
            try:
                events = await self._desk.missions.events(mission.id)
            except MeshError as error:
                nicegui_ui.notify(in_words(error), type="warning")
                return
            self._timeline.open(mission, events)
            self._open_timeline()

        return clicked


class PastRow:
    """Written anew when its mission has changed; one that has ended never does."""

    def __init__(self, fill: Callable[[Mission], None]) -> None:
        self._fill = fill
        self._shown: Mission | None = None
        self.root = nicegui_ui.element("li")

    def show(self, mission: Mission, /) -> None:
        if mission == self._shown:
            return
        self._shown = mission
        self.root.clear()
        with self.root:
            self._fill(mission)


def _when(stamp_s: float) -> str:
    return datetime.datetime.fromtimestamp(stamp_s).strftime("%H:%M")
