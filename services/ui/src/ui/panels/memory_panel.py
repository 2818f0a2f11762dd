"""What is remembered: things with their place, age and belief; searching, forgetting, carrying elsewhere."""

from collections.abc import Awaitable, Callable, Coroutine
from typing import TypeVar

from nicegui import ui as nicegui_ui

from contracts.memory import LabelCount, ObjectState, RememberedObject
from ui.desk import Desk
from ui.i18n import N_, _
from ui.operator_actions import ActionResult, OperatorActions
from ui.page_model import ago
from ui.panels.widgets import Rows, box, heading, result_classes

STATES = {
    ObjectState.PRESENT: N_("present"),
    ObjectState.DOUBTFUL: N_("uncertain"),
    ObjectState.LOST: N_("gone"),
    ObjectState.MOVED: N_("moved"),
}
ROWS_MAX = 80
T = TypeVar("T")
Doing = Callable[[T], Coroutine[object, object, None]]


class MemoryPanel:
    def __init__(self, desk: Desk, actions: OperatorActions) -> None:
        self._desk = desk
        self._actions = actions
        with box("memory"):
            self._search = (
                nicegui_ui.input(placeholder=_("search: bottle, red, gone, kitchen …"), on_change=self.show)
                .props(f'outlined dense clearable aria-label="{_("Search the memory")}"')
                .classes("say search")
            )
            self._answer = nicegui_ui.label().classes("answer").props("role=status")
            self._things = Rows[RememberedObject](
                nicegui_ui.element("ul").classes("things").props(f'aria-label="{_("Remembered things")}"'),
                key=lambda one: one.id,
                make=lambda: ThingRow(desk, look=self._look, forget=self._forget_thing),
            )
            self._empty = nicegui_ui.label(_("Memory is empty.")).classes("empty")
            heading(_("Kinds"), "h3")
            self._kinds = Rows[LabelCount](
                nicegui_ui.element("ul").classes("things").props(f'aria-label="{_("Remembered kinds")}"'),
                key=lambda count: count.label,
                make=lambda: KindRow(desk, forget=self._forget_kind),
            )
            with box("row transfer"):
                nicegui_ui.link(_("Export"), "memory/export").props("download").classes("act-link")
                with nicegui_ui.element("label").classes("act-link import"):
                    nicegui_ui.label(_("Import a file"))
                    nicegui_ui.element("input").props("type=file data-atom=import accept=.json,.jsonl,.ndjson")
            box("answer").props("data-atom=import-note role=status")
        self._dialog = nicegui_ui.dialog().props(f'transition-duration=0 aria-label="{_("Forget?")}"')
        with self._dialog, nicegui_ui.card().classes("question"):
            self._question = nicegui_ui.label().classes("headline")
            with box("row end"):
                nicegui_ui.button(_("Keep"), on_click=lambda: self._dialog.submit(False), color=None).props(
                    "flat no-caps autofocus"
                )
                nicegui_ui.button(_("Forget"), on_click=lambda: self._dialog.submit(True)).props(
                    "unelevated no-caps"
                ).classes("go")

    def show(self) -> None:
        """What changed since; ages are told anew each time."""
        remembered = self._desk.facts.remembered
        words = str(self._search.value or "").strip().lower()
        names = self._desk.facts.rooms.names
        objects = [one for one in remembered.objects if _matches(words, one, names.get(one.room_id or 0, ""))]
        labels = [one for one in remembered.labels if not words or words in one.label]
        self._things.show(sorted(objects, key=lambda one: (-one.belief, one.description, one.id))[:ROWS_MAX])
        self._kinds.show(labels[:ROWS_MAX])
        self._empty.set_text(
            _("No answer from memory yet.")
            if not self._desk.memory_heard
            else _("No match in memory.")
            if words
            else _("Memory is empty.")
        )
        self._empty.set_visibility(not objects and not labels)

    async def _look(self, one: RememberedObject) -> None:
        self._tell(await self._actions.look(one.position.x, one.position.y))

    async def _forget_thing(self, one: RememberedObject) -> None:
        question = _("Forget the {what}? It cannot be undone.", what=one.description)
        await self._forget(question, lambda: self._actions.forget_object(one.id))

    async def _forget_kind(self, count: LabelCount) -> None:
        question = _("Forget every {what}? It cannot be undone.", what=count.label)
        await self._forget(question, lambda: self._actions.forget_label(count.label))

    async def _forget(self, question: str, forget: Callable[[], Awaitable[ActionResult]]) -> None:
        self._question.set_text(question)
        if await self._dialog:
            self._tell(await forget())
            self.show()

    def _tell(self, result: ActionResult) -> None:
        self._answer.set_text(result.text)
        self._answer.classes(replace=result_classes(result))


def _matches(words: str, one: RememberedObject, room: str) -> bool:
    """Every word is in its description, label or state, or in the name of the room it stands in."""
    text = f"{one.description} {one.label} {one.colour or ''} {_(STATES[one.state])} {room}".lower()
    return all(word in text for word in words.split())


class ThingRow:
    def __init__(self, desk: Desk, *, look: Doing[RememberedObject], forget: Doing[RememberedObject]) -> None:
        self._desk = desk
        self._one: RememberedObject | None = None
        self.root = nicegui_ui.element("li").classes("item")
        with self.root:
            self._picture = box("thumb").props("aria-hidden=true")
            self._belief = box("belief").props("aria-hidden=true")
            with box("saying"):
                self._name = nicegui_ui.label().classes("headline")
                self._facts = nicegui_ui.label().classes("reason")
            with box("row"):
                self._look = small_button(_("Look"), lambda: look(self._shown()))
                self._forget = small_button(_("Forget"), lambda: forget(self._shown()))

    def _shown(self) -> RememberedObject:
        assert self._one is not None, "a row is shown before it can be pressed"
        return self._one

    def show(self, one: RememberedObject, /) -> None:
        if one != self._one:
            self._one = one
            self.root.classes(replace=f"item state-{one.state.value}")
            self._belief.style(f"--belief:{one.belief:.2f}")
            self._name.set_text(one.description)
            self._look.props["aria-label"] = _("Look at {what}", what=one.description)
            self._forget.props["aria-label"] = _("Forget {what}", what=one.description)
        seen_s = self._desk.thumbnails.version(one.id)
        if seen_s is not None:
            self._picture.style(f"background-image:url(things/{one.id}?v={seen_s})")
        room = self._desk.facts.rooms.names.get(one.room_id or 0)
        where = _(", room: {room}", room=room) if room is not None else ""
        self._facts.set_text(
            _(
                "{state}, {percent:.0f} % sure, last seen {ago} at {x:.1f} / {y:.1f} m{where}",
                state=_(STATES[one.state]),
                percent=100.0 * one.belief,
                ago=ago(self._desk.clock.now_s() - one.last_seen_s),
                x=one.position.x,
                y=one.position.y,
                where=where,
            )
        )


class KindRow:
    def __init__(self, desk: Desk, *, forget: Doing[LabelCount]) -> None:
        self._desk = desk
        self._count: LabelCount | None = None
        self.root = nicegui_ui.element("li").classes("item")
        with self.root:
            with box("saying"):
                self._name = nicegui_ui.label().classes("headline")
                self._facts = nicegui_ui.label().classes("reason")
            self._forget = small_button(_("Forget"), lambda: forget(self._shown()))

    def _shown(self) -> LabelCount:
        assert self._count is not None, "a row is shown before it can be pressed"
        return self._count

    def show(self, count: LabelCount, /) -> None:
        self._count = count
        self._name.set_text(count.label)
        self._forget.props["aria-label"] = _("Forget every {what}", what=count.label)
        views = _("1 view") if count.views == 1 else _("{n} views", n=count.views)
        self._facts.set_text(
            _(
                "{views}, best score {best:.2f}, last seen {ago}",
                views=views,
                best=count.best_confidence,
                ago=ago(self._desk.clock.now_s() - count.last_seen_s),
            )
        )


def small_button(text: str, doing: Callable[[], Coroutine[object, object, None]]) -> nicegui_ui.button:
    return nicegui_ui.button(text, on_click=doing, color=None).props("outline dense no-caps").classes("act")
