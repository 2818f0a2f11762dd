"""STOP, always on screen; and, in another place and after a question, RESUME."""

from nicegui import ui as nicegui_ui

from ui.desk import Desk
from ui.panels.parts import box, heading
from ui.view import View


def stop_button() -> None:
    """Handled in the browser (assets/ui.js), so that it works while the page's own connection is down."""
    with (
        nicegui_ui.element("button")
        .classes("stop")
        .props('type=button data-atom=stop aria-label="Emergency stop" aria-keyshortcuts=Escape')
    ):
        nicegui_ui.label("STOP")
        nicegui_ui.label("Esc").classes("key").props("aria-hidden=true")
    box("stop-result").props("data-atom=stop-result role=alert")


class Stopped:
    """Says that the robot is stopped and by whom, in the place of the command box."""

    def __init__(self, desk: Desk, operator: str) -> None:
        self._desk = desk
        self._operator = operator
        self._dialog = nicegui_ui.dialog().props('aria-label="Resume?"')
        with self._dialog, nicegui_ui.card().classes("question"):
            heading("Let the robot move again?")
            nicegui_ui.label(
                "Look at the robot first. Resuming only permits motion: nothing moves until a command or a button asks."
            )
            with box("row end"):
                nicegui_ui.button("Keep stopped", on_click=self._dialog.close, color=None).props(
                    "flat no-caps autofocus"
                )
                nicegui_ui.button("Resume", on_click=self._reset).props("unelevated no-caps").classes("go")
        self._root = nicegui_ui.element("section").classes("card stopped").props('aria-label="The robot is stopped"')
        with self._root:
            self._ask = nicegui_ui.button("Resume …", on_click=self._dialog.open, color=None)
            self._ask.props('outline no-caps aria-label="Resume after the emergency stop"').classes("resume")
            with box("saying"):
                nicegui_ui.label("The robot is stopped and stays stopped.").classes("headline")
                self._detail = nicegui_ui.label().classes("reason")
            self._refusal = nicegui_ui.label().classes("refusal").props("role=alert")
        self._root.set_visibility(False)

    async def _reset(self) -> None:
        self._dialog.close()
        told = await self._desk.reset(by=self._operator)
        self._refusal.set_text("" if told.ok else told.text)

    def show(self, view: View) -> None:
        self._root.set_visibility(view.stopped)
        self._detail.set_text(view.stop_detail)
        if not view.stopped:
            self._refusal.set_text("")
