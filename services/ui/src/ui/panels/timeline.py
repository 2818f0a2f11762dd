"""A mission's timeline: what was done and why, newest first; filtered, scrubbed, with the picture of each moment."""

from collections.abc import Callable, Sequence

from nicegui import ui as nicegui_ui
from nicegui.element import Element
from nicegui.events import ValueChangeEventArguments

from contracts.mission import Mission, MissionEvent
from ui import timeline_lines
from ui.desk import Desk
from ui.i18n import _
from ui.panels.widgets import ChipRow, box

LINES_MAX = 150


class Timeline:
    """Follows the mission under way, unless one of the history is opened."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._show_what = timeline_lines.Show.ALL
        self._events: tuple[MissionEvent, ...] = ()
        self._rows: dict[tuple[str, int], Element] = {}
        self._opened: Mission | None = None
        self._opened_events: tuple[MissionEvent, ...] = ()
        self._picked: tuple[str, int] | None = None
        with box("timeline"):
            with box("row between opened") as self._opened_row:
                self._opened_name = nicegui_ui.label().classes("headline")
                nicegui_ui.button(_("Back to now"), on_click=self.follow, color=None).props("flat dense no-caps")
            with box("row filters").props(f'role=group aria-label="{_("Show")}"'):
                self._filters = {show: self._filter(show) for show in timeline_lines.Show}
            self._slider = (
                nicegui_ui.slider(min=0, max=1, step=1, value=0, on_change=self._scrubbed)
                .props(f'aria-label="{_("Moment")}" dense')
                .classes("scrub")
            )
            self._moment = box("moment")
            self._empty = nicegui_ui.label(_("Nothing has happened yet.")).classes("empty")
            self._list = (
                nicegui_ui.element("ol")
                .classes("events")
                .props(f'aria-label="{_("Timeline, newest first")}" role=log aria-live=polite tabindex=0')
            )
        self._opened_row.set_visibility(False)
        self._moment.set_visibility(False)
        self._press_filter()

    # which mission

    def open(self, mission: Mission, events: Sequence[MissionEvent]) -> None:
        self._opened, self._opened_events = mission, tuple(events)
        self._opened_name.set_text(f"“{mission.command}”")
        self._opened_row.set_visibility(True)
        self._clear_moment()
        self.show()

    def follow(self) -> None:
        self._opened, self._opened_events = None, ()
        self._opened_row.set_visibility(False)
        self._clear_moment()
        self.show()

    # filter and scrub

    def _filter(self, show: timeline_lines.Show) -> Element:
        def clicked() -> None:
            self._show_what = show
            self._press_filter()
            self.show()

        button = nicegui_ui.element("button").classes("filter").props("type=button").on("click", clicked)
        button.add_slot("default", _(show.value))
        return button

    def _press_filter(self) -> None:
        for show, button in self._filters.items():
            button.props["aria-pressed"] = "true" if show is self._show_what else "false"

    def _scrubbed(self, event: ValueChangeEventArguments[float | None]) -> None:
        """To the newest end means: follow along."""
        index = int(event.value or 0)
        if index < len(self._events) - (1 if self._picked is None else 0):
            self._pick(self._events[index])

    def _picker(self, event: MissionEvent) -> Callable[[], None]:
        def clicked() -> None:
            self._pick(event)

        return clicked

    def _pick(self, event: MissionEvent) -> None:
        """Shows the moment: its picture, the crop that was voted on, its words."""
        key = (event.mission_id, event.id)
        if key == self._picked:
            return
        self._picked = key
        line = timeline_lines.line(event, self._started_s())
        self._moment.clear()
        with self._moment:
            if self._desk.event_pictures.has(*key):
                nicegui_ui.element("img").props(f"src=album/{event.mission_id}/{event.id}").props(
                    f'alt="{_("What the camera saw then")}"'
                )
            if line.crop is not None:
                nicegui_ui.element("img").props(f"src=crops/{event.mission_id}/{line.crop}").classes("crop").props(
                    f'alt="{_("The picture that was judged")}"'
                )
            with box("saying"):
                with box("row between"):
                    nicegui_ui.label(f"{line.time} {line.phase}").classes("event-phase")
                    nicegui_ui.button(_("Close"), on_click=self._clear_moment, color=None).props("flat dense no-caps")
                nicegui_ui.label(line.text).classes("event-text")
                ChipRow("votes").show(line.votes)
        self._moment.set_visibility(True)
        if event in self._events:
            self._slider.set_value(self._events.index(event))

    def _clear_moment(self) -> None:
        self._picked = None
        self._moment.clear()
        self._moment.set_visibility(False)

    # lines

    def _started_s(self) -> float:
        status = self._desk.facts.mission
        mission = self._opened or (status.mission if status is not None else None)
        if mission is not None:
            return mission.started_s
        return self._events[0].stamp_s if self._events else 0.0

    def show(self) -> None:
        source = self._opened_events if self._opened is not None else self._desk.facts.events
        events = tuple(event for event in source if timeline_lines.shown(event, self._show_what))[-LINES_MAX:]
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
        self._slider.set_visibility(len(events) > 1)
        self._slider.props["max"] = max(1, len(events) - 1)
        if self._picked is None:
            self._slider.set_value(max(0, len(events) - 1))

    def _row(self, event: MissionEvent) -> Element:
        line = timeline_lines.line(event, self._started_s())
        with self._list:
            row = nicegui_ui.element("li").classes(f"event tone-{line.tone}")
        with row:
            nicegui_ui.label(line.time).classes("event-time")
            with box("event-body"):
                nicegui_ui.label(line.phase).classes("event-phase")
                words = nicegui_ui.element("button").classes("event-text").props("type=button")
                words.on("click", self._picker(event))
                with words:
                    nicegui_ui.label(line.text)
                if line.votes:
                    ChipRow("votes").show(line.votes)
        return row
