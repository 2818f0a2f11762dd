"""The top of the page: what the robot is at and why, its battery and dock, and who is missing."""

from nicegui import ui as nicegui_ui

from contracts.access import Principal
from ui.i18n import _
from ui.page_model import PageModel
from ui.panels.widgets import ChipRow, box, heading


class Header:
    def __init__(self, logged_in: Principal | None) -> None:
        with nicegui_ui.element("header").classes("top"):
            with box("brand"):
                box("mark").props("aria-hidden=true")
                heading("ATOM", "h1")
            self._phase = nicegui_ui.label().classes("phase").props(f'role=status aria-label="{_("Mission state")}"')
            with box("saying"):
                self._headline = nicegui_ui.label().classes("headline")
                self._reason = nicegui_ui.label().classes("reason").props("aria-live=polite")
            self._away = nicegui_ui.label().classes("away").props("role=status")
            self._facts = ChipRow("facts")
            if logged_in is not None:
                with nicegui_ui.element("form").classes("who").props("method=post action=logout"):
                    nicegui_ui.label(f"{logged_in.name} ({logged_in.role})")
                    nicegui_ui.button(_("Log out")).props("type=submit flat dense no-caps")

    def show(self, view: PageModel) -> None:
        self._phase.set_text(view.phase)
        self._phase.classes(replace=f"phase tone-{view.phase_tone}")
        self._headline.set_text(view.headline)
        self._reason.set_text(view.reason)
        self._facts.show(view.robot_facts)
        self._away.set_text(view.away)
        self._away.set_visibility(view.away != "")
