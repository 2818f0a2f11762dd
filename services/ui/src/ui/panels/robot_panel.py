"""The robot as a machine: dock, sensors, and the services behind the page."""

from collections.abc import Awaitable, Callable

from nicegui import ui as nicegui_ui

from ui.i18n import t
from ui.operator_actions import Acts, Told
from ui.page_model import View
from ui.panels.widgets import ChipRow, box, heading, told_classes


class Machine:
    def __init__(self, acts: Acts) -> None:
        with box("machine"):
            with box("row"):
                self._dock = self._act(t("Dock"), acts.dock, t("Docking …"))
                self._undock = self._act(t("Undock"), acts.undock, t("Leaving the dock …"))
                self._act(t("Celebrate"), acts.celebrate, t("Six notes and a green spin …"))
            self._answer = nicegui_ui.label().classes("answer").props("role=status")
            with box("group"):
                heading(t("Services"))
                self._services = ChipRow("states")
            with box("group"):
                heading(t("Sensors"))
                self._sensors = ChipRow("states")
                self._no_sensors = nicegui_ui.label(t("No news from the robot.")).classes("empty")
            with box("group"):
                heading(t("Keys"))
                nicegui_ui.label(
                    t("Esc stops the robot, always. W A S D or the arrow keys drive it while “Drive by hand” is on.")
                )

    def _act(self, text: str, act: Callable[[], Awaitable[Told]], doing: str) -> nicegui_ui.button:
        async def clicked() -> None:
            self._answer.classes(replace="answer")
            self._answer.set_text(doing)
            told = await act()
            self._answer.classes(replace=told_classes(told))
            self._answer.set_text(told.text)

        return nicegui_ui.button(text, on_click=clicked, color=None).props("outline no-caps").classes("act")

    def show(self, view: View) -> None:
        self._services.show(view.services)
        self._sensors.show(view.sensors)
        self._no_sensors.set_visibility(not view.sensors)
        self._dock.set_enabled(view.can_dock)
        self._undock.set_enabled(view.can_undock)
