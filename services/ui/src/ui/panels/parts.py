"""Small things several parts of the page are made of."""

from collections.abc import Sequence

from nicegui import ui as nicegui_ui
from nicegui.element import Element

from ui.acts import Told
from ui.view import Chip


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


def told_classes(told: Told) -> str:
    return f"answer {'good' if told.ok else 'refused'}"


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
