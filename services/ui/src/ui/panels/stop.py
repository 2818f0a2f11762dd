"""STOP, always on screen; and, in another place and after a question, RESUME."""

from functools import cache
from html import escape
from pathlib import Path
from typing import Final

from nicegui import ui as nicegui_ui

from ui.i18n import _
from ui.operator_actions import OperatorActions
from ui.page_model import PageModel
from ui.panels.widgets import box, heading
from ui.plain import remedy

ASSETS: Final = Path(__file__).parents[1] / "assets"


@cache
def stop_html(robot_bridge_url: str) -> str:
    """STOP as a plain form with its style and script written in, so that no file that fails to load can take it away.

    Without a script it is the form that stops; with one (assets/stop.js) it is watched, and says when it cannot work.
    """
    otherwise, name = escape(remedy(robot_bridge_url)), escape(_("Emergency stop"))
    unwatched = _(
        "The page's script does not run: nothing monitors this STOP. Press it; a new page says whether it worked."
    )
    without = _("JavaScript is off. Only STOP works without it.")
    return f"""
<style>{(ASSETS / "stop.css").read_text(encoding="utf-8")}</style>
<section class="stop-place" data-atom="stop-place" data-remedy="{otherwise}" aria-label="{name}">
  <form method="post" action="stop?how=form">
    <button class="stop" type="submit" data-atom="stop" aria-label="{name}" aria-keyshortcuts="Escape">
      <span data-atom="stop-word">{escape(_("STOP"))}</span>
      <span class="key" aria-hidden="true">{escape(_("Esc"))}</span>
    </button>
  </form>
  <div class="stop-says">
    <div class="stop-dead" data-atom="stop-dead" role="alert">{escape(unwatched)} {otherwise}</div>
    <div data-atom="stop-result" role="alert"></div>
    <div data-atom="page-lost" role="status"></div>
    <div data-atom="page-missing" role="status"></div>
  </div>
</section>
<noscript>
  <style>#esm-fallback {{ display: none !important; }}</style>
  <p style="margin: 84px 16px; text-align: center">{escape(without)}</p>
</noscript>
<script>{(ASSETS / "stop.js").read_text(encoding="utf-8")}</script>
"""


class StoppedPanel:
    """Says that the robot is stopped and by whom, in the place of the command box."""

    def __init__(self, actions: OperatorActions, operator: str) -> None:
        self._actions = actions
        self._operator = operator
        self._dialog = nicegui_ui.dialog().props(f'transition-duration=0 aria-label="{_("Resume?")}"')
        with self._dialog, nicegui_ui.card().classes("question"):
            heading(_("Let the robot move again?"))
            nicegui_ui.label(_("Look at the robot first. It will not move until you give a command."))
            with box("row end"):
                nicegui_ui.button(_("Keep stopped"), on_click=self._dialog.close, color=None).props(
                    "flat no-caps autofocus"
                )
                nicegui_ui.button(_("Resume"), on_click=self._reset).props("unelevated no-caps").classes("go")
        self._root = (
            nicegui_ui.element("section")
            .classes("card stopped")
            .props(f'data-atom=stopped aria-label="{_("The robot is stopped")}"')
        )
        with self._root:
            self._ask = nicegui_ui.button(_("Resume …"), on_click=self._dialog.open, color=None)
            self._ask.props(f'outline no-caps aria-label="{_("Resume after the emergency stop")}"').classes("resume")
            with box("saying"):
                nicegui_ui.label(_("The robot is stopped and stays stopped.")).classes("headline")
                self._detail = nicegui_ui.label().classes("reason")
            self._refusal = nicegui_ui.label().classes("refusal").props("role=alert")
        self._root.set_visibility(False)

    async def _reset(self) -> None:
        self._dialog.close()
        result = await self._actions.reset(by=self._operator)
        self._refusal.set_text("" if result.ok else result.text)

    def show(self, view: PageModel) -> None:
        self._root.set_visibility(view.stopped)
        self._detail.set_text(view.stop_detail)
        if not view.stopped:
            self._refusal.set_text("")
