"""STOP, always on screen; and, in another place and after a question, RESUME."""

from nicegui import ui as nicegui_ui

from ui.acts import Acts
from ui.panels.parts import box, heading
from ui.texts import t
from ui.view import View


class StopButton:
    """Handled in the browser (assets/stop.js), so that it works while the page's own connection is down."""

    def __init__(self) -> None:
        with box() as self._place:
            with (
                nicegui_ui.element("button")
                .classes("stop")
                .props(f'type=button data-atom=stop aria-label="{t("Emergency stop")}" aria-keyshortcuts=Escape')
            ):
                self._word = nicegui_ui.label(t("STOP"))
                nicegui_ui.label(t("Esc")).classes("key").props("aria-hidden=true")
            box("stop-result").props("data-atom=stop-result role=alert")

    def show(self, *, stopped: bool) -> None:
        """It says so when the robot is stopped; pressed again it stops once more."""
        self._word.set_text(t("STOPPED") if stopped else t("STOP"))
        self._place.classes(replace="stopped-now" if stopped else "")


class Stopped:
    """Says that the robot is stopped and by whom, in the place of the command box."""

    def __init__(self, acts: Acts, operator: str, button: StopButton) -> None:
        self._acts = acts
        self._button = button
        self._operator = operator
        self._dialog = nicegui_ui.dialog().props(f'transition-duration=0 aria-label="{t("Resume?")}"')
        with self._dialog, nicegui_ui.card().classes("question"):
            heading(t("Let the robot move again?"))
            nicegui_ui.label(
                t("Look at the robot first. Resuming only permits motion: nothing moves until somebody asks for it.")
            )
            with box("row end"):
                nicegui_ui.button(t("Keep stopped"), on_click=self._dialog.close, color=None).props(
                    "flat no-caps autofocus"
                )
                nicegui_ui.button(t("Resume"), on_click=self._reset).props("unelevated no-caps").classes("go")
        self._root = (
            nicegui_ui.element("section")
            .classes("card stopped")
            .props(f'data-atom=stopped aria-label="{t("The robot is stopped")}"')
        )
        with self._root:
            self._ask = nicegui_ui.button(t("Resume …"), on_click=self._dialog.open, color=None)
            self._ask.props(f'outline no-caps aria-label="{t("Resume after the emergency stop")}"').classes("resume")
            with box("saying"):
                nicegui_ui.label(t("The robot is stopped and stays stopped.")).classes("headline")
                self._detail = nicegui_ui.label().classes("reason")
            self._refusal = nicegui_ui.label().classes("refusal").props("role=alert")
        self._root.set_visibility(False)

    async def _reset(self) -> None:
        self._dialog.close()
        told = await self._acts.reset(by=self._operator)
        self._refusal.set_text("" if told.ok else told.text)

    def show(self, view: View) -> None:
        self._root.set_visibility(view.stopped)
        self._button.show(stopped=view.stopped)
        self._detail.set_text(view.stop_detail)
        if not view.stopped:
            self._refusal.set_text("")
