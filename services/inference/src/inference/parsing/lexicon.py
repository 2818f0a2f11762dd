"""The parser's word table (`data/words.toml`), read once and indexed for matching."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from contracts.colours import COLOUR_WORDS
from vocabulary.labels import Name, names
from vocabulary.looks import MATERIALS_AND_COLOURS, NOT_COLOURS, colour_meant
from vocabulary.spelling import correction, singular_forms

Pattern = tuple[str, ...]
"""Words; "*" stands for up to three of any."""


@dataclass(frozen=True)
class Lexicon:
    names: dict[tuple[str, ...], Name]
    needs: tuple[tuple[Pattern, tuple[str, ...]], ...]
    """(pattern, labels that answer it), longest first."""
    activities: tuple[tuple[Pattern, tuple[str, ...]], ...]
    """The same for those that beat a thing named in them."""
    near: dict[str, tuple[str, ...]]
    vocabulary: frozenset[str]
    """Every single word that is part of a name."""
    correctable: tuple[str, ...]
    """The words a typo may be taken for."""
    attributes: frozenset[str]
    colours: frozenset[str]
    places: frozenset[str]
    negations: frozenset[str]
    denied: frozenset[str]
    requests: frozenset[str]
    searched: frozenset[str]
    fillers: frozenset[str]
    afterwords: frozenset[str]
    """May stand between a thing and its colour: 'the bottle that is red', 'a cup, the blue one'."""
    never_corrected: frozenset[str]
    longest: int
    """Words in the longest name."""

    def is_attribute(self, word: str) -> bool:
        return word in self.attributes

    def is_plain(self, word: str) -> bool:
        """Says nothing about which thing is meant."""
        return word in self.fillers or word in self.places or word in self.negations or word in self.requests

    def forms(self, word: str) -> tuple[str, ...]:
        """How `word` may be read: literally where it is part of a name, else as a singular, else corrected."""
        singulars = tuple(form for form in singular_forms(word) if form in self.vocabulary)
        if word in self.vocabulary:
            return (word, *singulars)
        if singulars:
            return singulars
        if word in self.never_corrected or any(form in self.never_corrected for form in singular_forms(word)):
            return (word,)
        read = (word, *singular_forms(word))
        return (word, *(fixed for form in read if (fixed := correction(form, self.correctable)) is not None))

    def attribute(self, word: str) -> str:
        """The word itself, or the colour it is a slip of ('yelow')."""
        known = (word, *singular_forms(word))
        own = any(one in group for group in (self.vocabulary, self.never_corrected, NOT_COLOURS) for one in known)
        if own or self.is_attribute(word):
            return word
        return colour_meant(word) or word


@cache
def lexicon() -> Lexicon:
    table = tomllib.loads(files("inference").joinpath("data/words.toml").read_text(encoding="utf-8"))
    real_words = files("inference").joinpath("data/real_words.txt").read_text(encoding="utf-8").split()
    words = table["words"]
    english = {word for said, name in names().items() if name.label != "none" and not name.foreign for word in said}
    groups = {key: frozenset(words[key]) for key in GROUPS}
    groups["attributes"] |= MATERIALS_AND_COLOURS
    needs, activities = (_patterns(table[key]) for key in ("needs", "activities"))
    said_of_needs = {word for pattern, _ in (*needs, *activities) for word in pattern}
    return Lexicon(
        names=names(),
        needs=needs,
        activities=activities,
        near={label: tuple(labels) for label, labels in table["near"].items()},
        vocabulary=frozenset(word for said in names() for word in said),
        correctable=tuple(sorted(word for word in english if len(word) >= 3)),
        colours=frozenset(COLOUR_WORDS),
        never_corrected=frozenset(word for group in groups.values() for word in group)
        | said_of_needs
        | frozenset(real_words),
        longest=max(len(said) for said in names()),
        **groups,
    )


GROUPS = ("attributes", "places", "negations", "denied", "requests", "searched", "fillers", "afterwords")


def _patterns(table: Mapping[str, list[str]]) -> tuple[tuple[Pattern, tuple[str, ...]], ...]:
    found = [(tuple(said.split()), tuple(labels)) for said, labels in table.items()]
    return tuple(sorted(found, key=lambda one: -len(one[0])))
