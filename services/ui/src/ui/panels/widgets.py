"""Small things several parts of the page are made of."""

from collections.abc import Callable, Hashable, Sequence
from typing import Generic, Protocol, TypeVar

from nicegui import ui as nicegui_ui
from nicegui.element import Element

from ui.operator_actions import ActionResult
from ui.page_model import Chip

T = TypeVar("T")
Shown_contra = TypeVar("Shown_contra", contravariant=True)


def section(name: str, *classes: str, title: str = "") -> Element:
    """A card with a name for screen readers, and a heading where `title` is given."""
    card = nicegui_ui.element("section").classes(f"card {' '.join(classes)}").props(f'aria-label="{name}"')
    if title:
        with card:
            heading(title)
    return card


def heading(text: str, tag: str = "h2") -> None:
    nicegui_ui.html(text, tag=tag, sanitize=False)


def box(*classes: str) -> Element:
    return nicegui_ui.element("div").classes(" ".join(classes))


def result_classes(result: ActionResult) -> str:
    return f"answer {'good' if result.ok else 'refused'}"


class ChipRow:
    """Facts in a row; what is there already is changed in place."""

    def __init__(self, *classes: str) -> None:
        self._row = box("chips", *classes)
        self._shown: list[ChipView] = []

    def show(self, chips: Sequence[Chip]) -> None:
        for view, chip in zip(self._shown, chips, strict=False):
            view.show(chip)
        with self._row:
            self._shown += [ChipView(chip) for chip in chips[len(self._shown) :]]
        for view in self._shown[len(chips) :]:
            view.delete()
        del self._shown[len(chips) :]


class ChipView:
    def __init__(self, chip: Chip) -> None:
        self._root = box("chip")
        with self._root:
            self._label = nicegui_ui.label(chip.label).classes("chip-label")
            self._value = nicegui_ui.label(chip.value).classes("chip-value")
        self._title = ""
        self.show(chip)

    def show(self, chip: Chip) -> None:
        self._label.set_text(chip.label)
        self._value.set_text(chip.value)
        self._root.classes(replace=f"chip tone-{chip.tone}")
        if chip.title != self._title:
            self._title = chip.title
            self._root.props["title"] = chip.title

    def delete(self) -> None:
        self._root.delete()


class Row(Protocol[Shown_contra]):
    root: Element

    def show(self, item: Shown_contra, /) -> None: ...


class Rows(Generic[T]):
    """A list whose rows stay while what they show changes: a button under a finger, or with the focus, stays too."""

    def __init__(self, root: Element, *, key: Callable[[T], Hashable], make: Callable[[], Row[T]]) -> None:
        self._root = root
        self._key = key
        self._make = make
        self._rows: dict[Hashable, Row[T]] = {}

    def show(self, items: Sequence[T]) -> None:
        wanted = {self._key(item) for item in items}
        for key in [key for key in self._rows if key not in wanted]:
            self._rows.pop(key).root.delete()
        for index, item in enumerate(items):
            row = self._rows.get(self._key(item))
            if row is None:
                with self._root:
                    row = self._rows[self._key(item)] = self._make()
            row.show(item)
            if self._root.default_slot.children[index] is not row.root:
                row.root.move(target_index=index)
