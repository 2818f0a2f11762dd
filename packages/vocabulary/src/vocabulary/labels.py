"""What people call things: labels, synonyms, loans of other languages, things that no detector knows. Pure."""

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from itertools import product

from contracts.coco import COCO_LABELS
from vocabulary.folding import words_of
from vocabulary.groups import group_in
from vocabulary.spelling import singular_forms

WORDS_MAX = 4
"""Of a name."""


@dataclass(frozen=True, slots=True)
class Name:
    """One thing a person can name: its words, the class it means ("none": known, but no detector class)."""

    words: tuple[str, ...]
    label: str
    foreign: bool = False

    @property
    def shown(self) -> str:
        """What the image-text model is asked for: it reads English."""
        return self.label if self.foreign else " ".join(self.words)


def label_in(text: str) -> str | None:
    """The label of the longest English name said, in singular or plural. A group's word ('dishes') names no label."""
    said = [word.text for word in words_of(text)]
    runs = (said[at : at + length] for length in range(WORDS_MAX, 0, -1) for at in range(len(said) - length + 1))
    for run in runs:
        for read in product(*((word, *singular_forms(word)) for word in run)):
            name = names().get(read)
            if name is not None and not name.foreign and (len(run) > 1 or group_in(run[0]) is None):
                return name.label if name.label != "none" else None
    return None


@cache
def names() -> dict[tuple[str, ...], Name]:
    """By their words. A name of two words is also known joined ("teddybear")."""
    table = tomllib.loads(files("vocabulary").joinpath("data/names.toml").read_text(encoding="utf-8"))
    found: dict[tuple[str, ...], Name] = {}
    for label in COCO_LABELS:
        for said in (label, *table["names"].get(label, ())):
            words = tuple(said.split())
            found.setdefault(words, Name(words, label))
            if len(words) == 2:
                found.setdefault(("".join(words),), Name(words, label))
    for said in table["unseen"]:
        found.setdefault(tuple(said.split()), Name(tuple(said.split()), "none"))
    for language in table["loans"].values():
        for said, label in language.items():
            found.setdefault(tuple(said.split()), Name(tuple(said.split()), label, foreign=True))
    return found
