"""The annotated camera, drawn by the browser (assets/camera.js), and driving by hand over it (assets/drive.js)."""

from collections.abc import Sequence

from nicegui import ui as nicegui_ui

from ui.i18n import _
from ui.page_model import Chip
from ui.panels.widgets import ChipRow, box, heading, section


class CameraPanel:
    def __init__(self) -> None:
        with section(_("Camera"), "live"):
            with box("row between card-head"):
                heading(_("Camera"))
                nicegui_ui.element("button").classes("drive-switch").props(
                    'type=button data-atom=drive-switch aria-pressed=false aria-keyshortcuts="w a s d"'
                ).add_slot("default", _("Drive by hand"))
            with box("screen"):
                nicegui_ui.element("canvas").props("data-atom=live data-old=true role=img width=500 height=500").props(
                    f'aria-label="{_("What the robot sees")}"'
                )
                box("screen-note").props("data-atom=live-note role=status")
                with (
                    box("stick")
                    .props("data-atom=stick hidden role=application tabindex=0")
                    .props(f'aria-label="{_("Joystick: drag it, or hold the arrow keys or W A S D")}"')
                ):
                    box("knob").props("data-atom=knob")
                box("drive-note").props("data-atom=drive-note role=status")
            self._votes = ChipRow("votes")

    def show(self, votes: Sequence[Chip]) -> None:
        self._votes.show(votes)
