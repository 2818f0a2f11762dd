"""The mission's timeline: what was done and why, newest first."""

from nicegui import ui as nicegui_ui
from nicegui.element import Element

from contracts.mission import MissionEvent
from ui import view as words
from ui.desk import Desk
from ui.panels.parts import ChipRow, box, section

LINES_MAX = 150


class Timeline:
    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._events: tuple[MissionEvent, ...] = ()
        self._rows: dict[tuple[str, int], Element] = {}
        with section("Timeline", "timeline", title="Timeline"):
            self._empty = nicegui_ui.label("Nothing has happened yet.").classes("empty")
            self._list = (
                nicegui_ui.element("ol")
                .classes("events")
                .props('aria-label="Newest first" role=log aria-live=polite tabindex=0')
            )

    def show(self) -> None:
        events = self._desk.situation.events[-LINES_MAX:]
        if events == self._events:
            return
        self._events = events
        keys = {(event.mission_id, event.id) for event in events}
        for key in [key for key in self._rows if key not in keys]:
            self._rows.pop(key).delete()
        for index, event in enumerate(reversed(events)):
            key = (event.mission_id, event.id)
            if key not in self._rows:
                self._rows[key] = self._row(event)
                self._rows[key].move(target_index=index)
        self._empty.set_visibility(not events)

    def _row(self, event: MissionEvent) -> Element:
        status = self._desk.situation.mission
        mission = status.mission if status is not None else None
        started_s = mission.started_s if mission is not None else self._events[0].stamp_s
        line = words.line(event, started_s)
        with self._list:
            row = nicegui_ui.element("li").classes(f"event tone-{line.tone}")
        with row:
            nicegui_ui.label(line.time).classes("event-time")
            with box("event-body"):
                nicegui_ui.label(line.phase).classes("event-phase")
                nicegui_ui.label(line.text).classes("event-text")
                if line.votes:
                    ChipRow("votes").show(line.votes)
        return row
