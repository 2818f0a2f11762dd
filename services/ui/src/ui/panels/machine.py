"""The robot as a machine: dock, sensors, and the services behind the page."""

from collections.abc import Awaitable, Callable

from nicegui import ui as nicegui_ui

from ui.desk import Desk, Told
from ui.panels.parts import ChipRow, box, heading, section
from ui.view import View


class Machine:
    def __init__(self, desk: Desk) -> None:
        with section("Robot and services", "machine"):
            with box("group"):
                heading("Services")
                self._services = ChipRow()
            with box("group"):
                heading("Sensors")
                self._sensors = ChipRow()
                self._no_sensors = nicegui_ui.label("No news from the robot.").classes("empty")
            with box("row dock"):
                self._dock = self._act("Dock", desk.dock, "Docking …")
                self._undock = self._act("Undock", desk.undock, "Leaving the dock …")
                self._answer = nicegui_ui.label().classes("answer").props("role=status")

    def _act(self, text: str, act: Callable[[], Awaitable[Told]], doing: str) -> nicegui_ui.button:
        async def clicked() -> None:
            self._answer.classes(replace="answer")
            self._answer.set_text(doing)
            told = await act()
            self._answer.classes(replace=f"answer {'good' if told.ok else 'refused'}")
            self._answer.set_text(told.text)

        return nicegui_ui.button(text, on_click=clicked, color=None).props("outline no-caps").classes("act")

    def show(self, view: View) -> None:
        self._services.show(view.services)
        self._sensors.show(view.sensors)
        self._no_sensors.set_visibility(not view.sensors)
        self._dock.set_enabled(view.can_dock)
        self._undock.set_enabled(view.can_undock)
