"""The annotated camera; its pictures are pulled by the browser itself (assets/ui.js)."""

from nicegui import ui as nicegui_ui

from ui.panels.parts import ChipRow, box, section
from ui.view import View


class Live:
    def __init__(self) -> None:
        with section("Camera", "live", title="Camera"):
            with box("screen"):
                nicegui_ui.element("img").props('data-atom=live data-old=true alt="What the robot sees"')
                box("screen-note").props("data-atom=live-note role=status")
            self._votes = ChipRow("votes")

    def show(self, view: View) -> None:
        self._votes.show(view.votes)
