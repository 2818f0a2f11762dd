"""A saying as it was heard, put right by ear: repeats dropped, and in the place of a thing a word that names nothing
taken for the name that sounds nearest. Pure.

Only where a thing is due, behind an article or a word of asking, and only where one name is nearest.
"""

import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.resources import files
from typing import Final

import jellyfish
from rapidfuzz import fuzz
from rapidfuzz.distance import OSA

from contracts.colours import COLOUR_WORDS
from vocabulary.folding import Word, joined, words_of
from vocabulary.labels import names
from vocabulary.looks import MATERIALS_AND_COLOURS
from vocabulary.rooms import ROOMS
from vocabulary.spelling import singular_forms

_TABLE = tomllib.loads(files("vocabulary").joinpath("data/sounding.toml").read_text(encoding="utf-8"))
ARTICLES, ENDS, LIKES, PLACES = (frozenset(_TABLE[name].split()) for name in ("articles", "ends", "likes", "places"))
SOUND_MIN: Final = 2
"""Consonants of a name that is known by its sound alone."""
SOUND_SURE_MIN: Final = 4
SPELT_SURE_MIN: Final = 80.0
"""From so many consonants on, and so much of its letters in percent, a name that sounds the same is taken without
asking: 'doughnut' is one, 'duster' is no toaster."""
SPELT_ALIKE_MIN: Final = 50.0
"""In percent: so far what sounds alike must be written alike too, as consonants alone tell too little."""
SHORT_ALIKE_MIN: Final = 65.0
"""The same, where one consonant of fewer than four is another."""
SAME_ALIKE_MIN: Final = 25.0
"""The same, where all consonants agree."""
REPEATED_MIN: Final = 70.0
"""In percent: as near is a clause that says the first again."""
NAME_WORDS_MAX: Final = 3


@dataclass(frozen=True, slots=True)
class HeardText:
    """`sure`: each word in the place of a thing is known, or sounds the same as one that is."""

    text: str
    sure: bool = True


@dataclass(frozen=True, slots=True)
class _Sound:
    name: str
    written: str
    """Its words joined."""
    code: str


def said_once(text: str, words_expected: int) -> str:
    """Without the repeats that a recogniser makes of its hints: 'find the cup, find the cup,'. At least the first
    clause; as many words as were heard without hints may stay.
    """
    words = words_of(text)
    starts = [at for at, word in enumerate(words) if word.opens] or [0]
    clauses = [words[a:b] for a, b in zip(starts, [*starts[1:], len(words)], strict=True)]
    kept: list[Word] = []
    for clause in clauses:
        longer = len(kept) + len(clause) > words_expected
        if kept and longer and (len(kept) >= words_expected or _says_again(clause, kept)):
            break
        kept += clause
    return _without_echo(joined(kept)) if kept else text


def by_ear(text: str) -> HeardText:
    """The same words, things put right; what is sure already is left alone."""
    words = [word.text for word in words_of(text)]
    told: list[str] = []
    sure = True
    at = 0
    while at < len(words):
        told.append(words[at])
        at += 1
        if words[at - 1] not in ARTICLES:
            continue
        end = at
        while end < len(words) and words[end] not in ENDS and words[end] not in ARTICLES:
            end += 1
        thing = _thing(words[at:end])
        told.append(thing.text)
        sure = sure and thing.sure
        at = end
    return HeardText(" ".join(filter(None, told)), sure)


def _thing(said: Sequence[str]) -> HeardText:
    """The words in the place of one thing: what it is like, and what it is."""
    like = next((at for at, word in enumerate(said) if not _is_like(word)), len(said))
    head = list(said[like:])
    if all(map(_is_known, head)):
        return HeardText(" ".join(said))
    if not _is_known(head[-1]) and len(head) <= NAME_WORDS_MAX + 1:
        for length in range(min(NAME_WORDS_MAX, len(head)), 0, -1):
            name, sure = _nearest("".join(head[-length:]))
            if name:
                before = [_colour(word) for word in head[:-length]]
                return HeardText(" ".join([*said[:like], *before, name]), sure and all(map(_is_like, before)))
    told = [*said[:like], *(word if _is_known(word) else _colour(word) for word in head)]
    return HeardText(" ".join(told), all(_is_known(word) or _is_like(word) for word in told))


def _is_like(word: str) -> bool:
    return word in LIKES or word in MATERIALS_AND_COLOURS


def _is_known(word: str) -> bool:
    return any(one in _words_of_names() or one in _words_of_rooms() for one in (word, *singular_forms(word)))


def _colour(word: str) -> str:
    """'blew' before a thing is blue."""
    code = sound_of(word)
    alike = {colour for colour in COLOUR_WORDS if sound_of(colour) == code and colour[0] == word[0]}
    return alike.pop() if len(alike) == 1 else word


@lru_cache(maxsize=4096)
def _nearest(written: str) -> tuple[str, bool]:
    """The one name that sounds like it, and whether it sounds the same; '' where none does, or two as much."""
    code = sound_of(written)
    if len(code) < SOUND_MIN:
        return "", False
    ranked: list[tuple[int, float, str]] = []
    for one in _sounds():
        steps = OSA.distance(code, one.code, score_cutoff=1)
        alike = fuzz.ratio(written, one.written)
        alike_min = (
            SAME_ALIKE_MIN if steps == 0 else SPELT_ALIKE_MIN if len(code) >= SOUND_SURE_MIN else SHORT_ALIKE_MIN
        )
        if steps <= 1 and alike >= alike_min:
            ranked.append((steps, -alike, one.name))
    ranked.sort()
    best = ranked[:2]
    if not best or (len(best) == 2 and best[0][:2] == best[1][:2]):
        return "", False
    steps, unlike, name = best[0]
    return name, steps == 0 and len(code) >= SOUND_SURE_MIN and -unlike >= SPELT_SURE_MIN


def _says_again(clause: Sequence[Word], kept: Sequence[Word]) -> bool:
    said, before = joined(clause), joined(kept)
    return fuzz.partial_ratio(said, before) >= REPEATED_MIN


def _without_echo(plain: str) -> str:
    """'pour me some water pour me some water pour' is said once."""
    words = plain.split()
    for length in range(2, len(words) // 2 + 1):
        rest = words[length:]
        again = (words[:length] * (len(rest) // length + 1))[: len(rest)]
        if again == rest:
            return " ".join(words[:length])
    return plain


@lru_cache(maxsize=4096)
def sound_of(written: str) -> str:
    """Its consonants by ear: 'doughnut' and 'donut' are the same."""
    return re.sub(r"(.)\1+", r"\1", jellyfish.metaphone(written))


@cache
def _sounds() -> tuple[_Sound, ...]:
    known = {" ".join(one.words) for one in names().values() if not one.foreign}
    return tuple(_Sound(one, one.replace(" ", ""), sound_of(one.replace(" ", ""))) for one in sorted(known))


@cache
def _words_of_rooms() -> frozenset[str]:
    return frozenset(word for room in (*ROOMS, *PLACES) for word in room.split())


@cache
def _words_of_names() -> frozenset[str]:
    return frozenset(word for one in names().values() if not one.foreign for word in one.words)
