"""The exploration in the Robot tab: mode, what the model may still be asked, discoveries."""

from nicegui import ui as nicegui_ui

from ui.exploration_view import ExplorationView
from ui.i18n import _
from ui.panels.widgets import ChipRow, box, heading


class ExplorationPanel:
    """Hidden while nothing was explored."""

    def __init__(self) -> None:
        self._root = box("group", "exploration")
        with self._root:
            heading(_("Exploration"))
            self._chips = ChipRow("states")
            self._why = nicegui_ui.label().classes("empty")
            self._found = nicegui_ui.label().style("white-space: pre-line").props('role=status aria-live="polite"')
        self._root.set_visibility(False)

    def show(self, view: ExplorationView) -> None:
        self._root.set_visibility(bool(view.chips))
        self._chips.show(view.chips)
        self._why.set_text(view.why)
        self._found.set_text("\n".join((_("Discovered:"), *view.discoveries)) if view.discoveries else "")
