"""The robot as a machine: dock, sensors, and the services behind the page."""

from collections.abc import Awaitable, Callable
from typing import Final

from nicegui import ui as nicegui_ui

from contracts.actions import Action, DockAction, ExploreAction, LookAroundAction
from ui.exploration_view import ExplorationView
from ui.i18n import _
from ui.library_actions import LibraryActions
from ui.operator_actions import ActionResult, OperatorActions
from ui.page_model import PageModel
from ui.panels.exploration_panel import ExplorationPanel
from ui.panels.widgets import ChipRow, box, heading, result_classes

EXPLORE_MIN: Final = (2, 5)
"""For how many minutes a press may have the robot explore."""


class RobotPanel:
    def __init__(self, actions: OperatorActions, library: LibraryActions) -> None:
        self._library = library
        with box("machine"):
            with box("row"):
                self._dock = self._act(_("Dock"), actions.dock, _("Docking …"))
                self._undock = self._act(_("Undock"), actions.undock, _("Leaving the dock …"))
                self._act(_("Celebrate"), actions.celebrate, _("Celebrating …"))
            with box("row"):
                self._begin(_("Go home"), DockAction())
                self._begin(_("Look around"), LookAroundAction())
                self._begin(_("Explore"), ExploreAction())
                for minutes in EXPLORE_MIN:
                    self._begin(_("Explore for {n} min", n=minutes), ExploreAction(duration_s=60.0 * minutes))
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

    def _begin(self, text: str, action: Action) -> None:
        self._act(text, lambda: self._library.begin(action), _("Asking …"))

    def show(self, view: PageModel, exploration: ExplorationView) -> None:
        self._exploration.show(exploration)
        self._services.show(view.services)
        self._sensors.show(view.sensors)
        self._no_sensors.set_visibility(not view.sensors)
        self._dock.set_enabled(view.can_dock)
        self._undock.set_enabled(view.can_undock)
