"""Words for a group of things: 'anything to drink?' is about bottles, cups and glasses. Pure."""

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from vocabulary.folding import words_of


@dataclass(frozen=True, slots=True)
class Group:
    name: str
    labels: tuple[str, ...]
    """COCO classes."""


def group_in(text: str) -> Group | None:
    """The first group that is named; None where none is."""
    groups = _groups()
    return next((groups[word.text] for word in words_of(text) if word.text in groups), None)


@cache
def _groups() -> dict[str, Group]:
    table = tomllib.loads(files("vocabulary").joinpath("data/groups.toml").read_text(encoding="utf-8"))
    named = ((Group(name, tuple(one["labels"])), one["words"]) for name, one in table.items())
    return {word: group for group, words in named for word in words}
