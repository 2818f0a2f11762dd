"""What is remembered: things with their place, age and belief; searching, forgetting, carrying elsewhere."""

from collections.abc import Awaitable, Callable, Coroutine

from nicegui import ui as nicegui_ui

from contracts.memory import LabelCount, ObjectState, RememberedObject
from ui.acts import Acts, Told
from ui.desk import Desk
from ui.panels.parts import box, heading, told_classes
from ui.situation import Remembered
from ui.texts import mark, t
from ui.view import ago

STATES = {
    ObjectState.PRESENT: mark("there"),
    ObjectState.DOUBTFUL: mark("doubtful"),
    ObjectState.LOST: mark("gone"),
    ObjectState.MOVED: mark("moved"),
}
ROWS_MAX = 80
Doing = Callable[[], Coroutine[object, object, None]]


class MemoryPanel:
    def __init__(self, desk: Desk, acts: Acts) -> None:
        self._desk = desk
        self._acts = acts
        self._shown: tuple[Remembered, str] | None = None
        with box("memory"):
            self._search = (
                nicegui_ui.input(placeholder=t("search: bottle, red, gone …"), on_change=self.show)
                .props(f'outlined dense clearable aria-label="{t("Search the memory")}"')
                .classes("say search")
            )
            self._answer = nicegui_ui.label().classes("answer").props("role=status")
            self._list = nicegui_ui.element("ul").classes("things").props(f'aria-label="{t("Remembered things")}"')
            self._empty = nicegui_ui.label(t("Nothing is remembered yet.")).classes("empty")
            heading(t("Kinds"), "h3")
            self._kinds = nicegui_ui.element("ul").classes("things").props(f'aria-label="{t("Remembered kinds")}"')
            with box("row transfer"):
                nicegui_ui.link(t("Export"), "/memory/export").props("download").classes("act-link")
                with nicegui_ui.element("label").classes("act-link import"):
                    nicegui_ui.label(t("Import a file"))
                    nicegui_ui.element("input").props("type=file data-atom=import accept=.json,.jsonl,.ndjson")
            box("answer").props("data-atom=import-note role=status")
        self._dialog = nicegui_ui.dialog().props(f'transition-duration=0 aria-label="{t("Forget?")}"')
        with self._dialog, nicegui_ui.card().classes("question"):
            self._question = nicegui_ui.label().classes("headline")
            with box("row end"):
                nicegui_ui.button(t("Keep"), on_click=lambda: self._dialog.submit(False), color=None).props(
                    "flat no-caps autofocus"
                )
                nicegui_ui.button(t("Forget"), on_click=lambda: self._dialog.submit(True)).props(
                    "unelevated no-caps"
                ).classes("go")

    def show(self) -> None:
        """Draws again when memory or the search has changed."""
        remembered = self._desk.situation.remembered
        words = str(self._search.value or "").strip().lower()
        if self._shown is not None and self._shown[0] is remembered and self._shown[1] == words:
            return
        self._shown = (remembered, words)
        objects = [one for one in remembered.objects if _matches(words, one)]
        labels = [one for one in remembered.labels if not words or words in one.label]
        self._list.clear()
        with self._list:
            for one in sorted(objects, key=lambda one: (-one.belief, one.description))[:ROWS_MAX]:
                self._thing(one)
        self._kinds.clear()
        with self._kinds:
            for count in labels[:ROWS_MAX]:
                self._kind(count)
        self._empty.set_text(t("Nothing like that is remembered.") if words else t("Nothing is remembered yet."))
        self._empty.set_visibility(not objects and not labels)

    def _thing(self, one: RememberedObject) -> None:
        now_s = self._desk.clock.now_s()
        with nicegui_ui.element("li").classes(f"item state-{one.state.value}"):
            box("belief").style(f"--belief:{one.belief:.2f}").props("aria-hidden=true")
            with box("saying"):
                nicegui_ui.label(one.description).classes("headline")
                nicegui_ui.label(
                    t(
                        "{state}, belief {percent:.0f} %, seen {ago}, at {x:.1f} / {y:.1f} m",
                        state=t(STATES[one.state]),
                        percent=100.0 * one.belief,
                        ago=ago(now_s - one.last_seen_s),
                        x=one.position.x,
                        y=one.position.y,
                    )
                ).classes("reason")
            with box("row"):
                self._button(t("Look"), t("Look at {what}", what=one.description), self._looker(one))
                self._button(
                    t("Forget"),
                    t("Forget {what}", what=one.description),
                    self._forgetter(
                        t("Forget the {what}? It cannot be undone.", what=one.description),
                        lambda: self._acts.forget_object(one.id),
                    ),
                )

    def _kind(self, count: LabelCount) -> None:
        now_s = self._desk.clock.now_s()
        with nicegui_ui.element("li").classes("item"):
            with box("saying"):
                nicegui_ui.label(count.label).classes("headline")
                nicegui_ui.label(
                    t(
                        "{n} views, best {best:.2f}, seen {ago}",
                        n=count.views,
                        best=count.best_confidence,
                        ago=ago(now_s - count.last_seen_s),
                    )
                ).classes("reason")
            self._button(
                t("Forget"),
                t("Forget every {what}", what=count.label),
                self._forgetter(
                    t("Forget every {what}? It cannot be undone.", what=count.label),
                    lambda: self._acts.forget_label(count.label),
                ),
            )

    def _button(self, text: str, label: str, doing: Doing) -> None:
        button = nicegui_ui.button(text, on_click=doing, color=None).props("outline dense no-caps").classes("act")
        button.props["aria-label"] = label

    def _looker(self, one: RememberedObject) -> Doing:
        async def clicked() -> None:
            self._tell(await self._acts.look(one.position.x, one.position.y))

        return clicked

    def _forgetter(self, question: str, forget: Callable[[], Awaitable[Told]]) -> Doing:
        async def clicked() -> None:
            self._question.set_text(question)
            if await self._dialog:
                self._tell(await forget())
                self.show()

        return clicked

    def _tell(self, told: Told) -> None:
        self._answer.set_text(told.text)
        self._answer.classes(replace=told_classes(told))


def _matches(words: str, one: RememberedObject) -> bool:
    """Every word is in its description, label or state."""
    text = f"{one.description} {one.label} {one.colour or ''} {t(STATES[one.state])}".lower()
    return all(word in text for word in words.split())
