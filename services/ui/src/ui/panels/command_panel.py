"""Saying what to find, asking what is known, and pausing or ending the search."""

from collections.abc import Awaitable, Callable, Sequence

from nicegui import ui as nicegui_ui
from nicegui.element import Element
from nicegui.events import GenericEventArguments

from contracts.asking import Answer
from ui.i18n import _
from ui.latest_facts import Remembered
from ui.operator_actions import COMMAND_MAX, ActionResult, OperatorActions
from ui.page_model import PageModel
from ui.panels.speech_panel import SpeechPanel, microphone_button, read_aloud
from ui.panels.widgets import ChipRow, box, result_classes, section
from ui.suggestions import is_question, suggestions

WHAT_IS_SAID = "() => emit(window.atom.said())"
"""A press takes along what the box shows then: until the page is connected, keys and presses arrive in any order."""


class CommandPanel:
    def __init__(self, actions: OperatorActions, *, with_speech: bool) -> None:
        """`with_speech`: there is a service that hears and speaks, and it may be spoken to from here."""
        self._actions = actions
        self._with_speech = with_speech
        self._remembered: Remembered | None = None
        self._queued: tuple[tuple[str, str], ...] = ()
        self._begun = self._running = False
        self._root = section(_("Command"), "command")
        with self._root:
            with box("row say-row"):
                self._input = (
                    nicegui_ui.input(placeholder=_("find the red bottle"))
                    .props(f"outlined dense maxlength={COMMAND_MAX} autocomplete=off enterkeyhint=send autofocus")
                    .props(f'aria-label="{_("What to find")}" data-atom-say')
                    .classes("say")
                    .on("keydown.enter", self._entered, js_handler=WHAT_IS_SAID)
                )
                self._suggestions = nicegui_ui.element("datalist").props(f"id={self._input.html_id}-datalist")
                if with_speech:
                    microphone_button()
                self._find = nicegui_ui.button(_("Find")).props("unelevated no-caps data-atom=find").classes("send")
                self._find.on("click", self._entered, js_handler=WHAT_IS_SAID)
                self._ask = nicegui_ui.button(_("Ask"), color=None).props("outline no-caps").classes("act ask")
                self._ask.on("click", self._question, js_handler=WHAT_IS_SAID)
            with box("row between"):
                self._facts = ChipRow()
                with box("row"):
                    self._pause = self._act(_("Pause"), _("Pause the mission"), actions.pause)
                    self._resume = self._act(_("Continue"), _("Continue the mission"), actions.resume)
                    self._cancel = self._act(_("Cancel"), _("Cancel the mission"), actions.cancel)
            if with_speech:
                SpeechPanel()
            self._answer = nicegui_ui.label().classes("answer").props("role=status aria-live=assertive")
            self._queue = nicegui_ui.element("ol").classes("queue").props(f'aria-label="{_("Queue")}"')

    def _act(self, text: str, label: str, act: Callable[[], Awaitable[ActionResult]]) -> nicegui_ui.button:
        async def clicked() -> None:
            self._tell(await act())

        button = nicegui_ui.button(text, on_click=clicked, color=None)
        return button.props(f'outline no-caps aria-label="{label}"').classes("act")

    async def _entered(self, press: GenericEventArguments) -> None:
        await (self._question(press) if is_question(_said(press)) else self._command(press))

    async def _command(self, press: GenericEventArguments) -> None:
        self._find.props("loading")
        result = await self._actions.command(_said(press))
        self._find.props(remove="loading")
        self._tell(result, begun=result.ok)
        if result.ok:
            self._input.set_value("")

    async def _question(self, press: GenericEventArguments) -> None:
        self._ask.props("loading")
        answer = await self._actions.ask(_said(press))
        self._ask.props(remove="loading")
        if isinstance(answer, ActionResult):
            self._tell(answer)
            return
        self._tell(ActionResult(True, _in_words(answer)))

    def _tell(self, result: ActionResult, *, begun: bool = False) -> None:
        """`begun`: it says what a mission looks for, and goes when that is over."""
        self._begun = begun
        self._answer.set_text(result.text if result.ok else _("Refused: {why}", why=result.text))
        self._answer.classes(replace=result_classes(result))
        if self._with_speech and result.text:
            read_aloud(result.text)

    def show(self, view: PageModel, remembered: Remembered) -> None:
        self._root.set_visibility(not view.stopped)
        self._facts.show(view.mission_facts)
        self._pause.set_visibility(not view.can_resume)
        self._pause.set_enabled(view.can_pause)
        self._resume.set_visibility(view.can_resume)
        self._cancel.set_enabled(view.can_cancel)
        if self._begun and self._running and not view.can_cancel:
            self._tell(ActionResult(True, ""))
        self._running = view.can_cancel
        if remembered is not self._remembered:
            self._remembered = remembered
            self._suggest(suggestions(remembered))
        if view.queue != self._queued:
            self._queued = view.queue
            self._show_queue(view.queue)

    def _suggest(self, texts: Sequence[str]) -> None:
        self._suggestions.clear()
        with self._suggestions:
            for text in texts:
                nicegui_ui.element("option").props["value"] = text

    def _show_queue(self, queue: Sequence[tuple[str, str]]) -> None:
        self._queue.clear()
        with self._queue:
            for mission_id, command in queue:
                with nicegui_ui.element("li").classes("row between"):
                    nicegui_ui.label(_("next: {command}", command=command))
                    self._take_out(mission_id, command)

    def _take_out(self, mission_id: str, command: str) -> Element:
        async def clicked() -> None:
            self._tell(await self._actions.take_from_queue(mission_id))

        button = nicegui_ui.button(_("Remove"), on_click=clicked, color=None).props("flat dense no-caps")
        button.props["aria-label"] = _("Remove {command} from the queue", command=command)
        return button


def _said(press: GenericEventArguments) -> str:
    return press.args if isinstance(press.args, str) else ""


def _in_words(answer: Answer) -> str:
    return f"{answer.answer} ({answer.notes})" if answer.notes else answer.answer
