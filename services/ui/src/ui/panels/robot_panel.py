"""The robot as a machine: dock, sensors, and the services behind the page."""

from collections.abc import Awaitable, Callable

from nicegui import ui as nicegui_ui

from ui.exploration_view import ExplorationView
from ui.i18n import _
from ui.operator_actions import ActionResult, OperatorActions
from ui.page_model import PageModel
from ui.panels.exploration_panel import ExplorationPanel
from ui.panels.widgets import ChipRow, box, heading, result_classes


class RobotPanel:
    def __init__(self, actions: OperatorActions) -> None:
        with box("machine"):
            with box("row"):
                self._dock = self._act(_("Dock"), actions.dock, _("Docking …"))
                self._undock = self._act(_("Undock"), actions.undock, _("Leaving the dock …"))
                self._act(_("Celebrate"), actions.celebrate, _("Celebrating …"))
            self._answer = nicegui_ui.label().classes("answer").props("role=status")
            self._exploration = ExplorationPanel()
            with box("group"):
                heading(_("Services"))
                self._services = ChipRow("states")
            with box("group"):
                heading(_("Sensors"))
                self._sensors = ChipRow("states")
                self._no_sensors = nicegui_ui.label(_("No data from the robot.")).classes("empty")
            with box("group"):
                heading(_("Keys"))
                nicegui_ui.label(
                    _("Esc always stops the robot. W A S D or the arrow keys drive it while “Drive by hand” is on.")
                )

    def _act(self, text: str, act: Callable[[], Awaitable[ActionResult]], doing: str) -> nicegui_ui.button:
        async def clicked() -> None:
            self._answer.classes(replace="answer")
            self._answer.set_text(doing)
            result = await act()
            self._answer.classes(replace=result_classes(result))
            self._answer.set_text(result.text)

        return nicegui_ui.button(text, on_click=clicked, color=None).props("outline no-caps").classes("act")

    def show(self, view: PageModel, exploration: ExplorationView) -> None:
        self._exploration.show(exploration)
        self._services.show(view.services)
        self._sensors.show(view.sensors)
        self._no_sensors.set_visibility(not view.sensors)
        self._dock.set_enabled(view.can_dock)
        self._undock.set_enabled(view.can_undock)
