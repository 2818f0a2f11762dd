"""Saying what to find, and pausing or ending the search."""

from collections.abc import Awaitable, Callable

from nicegui import ui as nicegui_ui

from ui.desk import COMMAND_MAX, Desk, Told
from ui.panels.parts import ChipRow, box, section
from ui.view import View


class Command:
    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._root = section("Command", "command")
        with self._root:
            with box("row"):
                self._input = (
                    nicegui_ui.input(placeholder="find the red bottle")
                    .props(f"outlined dense maxlength={COMMAND_MAX} autocomplete=off enterkeyhint=send autofocus")
                    .props('aria-label="What to find"')
                    .classes("say")
                    .on("keydown.enter", self._send)
                )
                self._button = nicegui_ui.button("Find", on_click=self._send).props("unelevated no-caps")
                self._button.classes("send")
            with box("row between"):
                self._facts = ChipRow()
                with box("row"):
                    self._pause = self._act("Pause", desk.pause)
                    self._resume = self._act("Go on", desk.resume)
                    self._cancel = self._act("Cancel", desk.cancel)
            self._answer = nicegui_ui.label().classes("answer").props("role=status aria-live=assertive")

    def _act(self, text: str, act: Callable[[], Awaitable[Told]]) -> nicegui_ui.button:
        async def clicked() -> None:
            self._tell(await act())

        button = nicegui_ui.button(text, on_click=clicked, color=None).props(
            f'outline no-caps aria-label="{text} the mission"'
        )
        return button.classes("act")

    async def _send(self) -> None:
        self._button.props("loading")
        told = await self._desk.command(str(self._input.value or ""))
        self._button.props(remove="loading")
        self._tell(told)
        if told.ok:
            self._input.set_value("")

    def _tell(self, told: Told) -> None:
        self._answer.set_text(told.text if told.ok else f"Refused: {told.text}")
        self._answer.classes(replace=f"answer {'good' if told.ok else 'refused'}")

    def show(self, view: View) -> None:
        self._root.set_visibility(not view.stopped)
        self._facts.show(view.mission_facts)
        self._pause.set_visibility(not view.can_resume)
        self._pause.set_enabled(view.can_pause)
        self._resume.set_visibility(view.can_resume)
        self._cancel.set_enabled(view.can_cancel)
