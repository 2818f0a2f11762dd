"""Which of its own choices an answer means: by number, by the words in which they differ, or as the one that is left.
Pure.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from typing import Final

from contracts.intent import Choice
from vocabulary.folding import Word, words_of

CARDINALS: Final = {"1": 0, "one": 0, "2": 1, "two": 1, "3": 2, "three": 2, "4": 3, "four": 3}
ORDINALS: Final = {"first": 0, "former": 0, "second": 1, "latter": 1, "third": 2, "fourth": 3, "last": -1}
COUNTING: Final = frozenset({"number", "option", "choice"})
"""Before a "one" that is a number; elsewhere it stands for a thing: "the blue one", "no one"."""
POINTING: Final = frozenset({"the", "a", "an", "this", "that", "it"}) | COUNTING
FILLING: Final = frozenset({
    "um", "uh", "er", "hm", "well", "please", "i", "mean", "meant", "said", "say", "want", "is", "its", "thats",
})  # fmt: skip
YES: Final = frozenset({"yes", "yeah", "yep", "right", "correct", "sure", "okay", "ok"})
NO: Final = frozenset({"no", "nope", "nah"})
NOT: Final = frozenset({"not", "isnt"})
NONE: Final = frozenset({"neither", "nor", "none", "nothing", "nobody", "dont", "doesnt", "never"})
BUT: Final = frozenset({"but", "rather", "instead"})


class Neither(Enum):
    """A person said that none of them is meant."""

    SAID = "said"


class _Stance(Enum):
    """Of what stands between two pauses, or between two of the words that turn it."""

    FOR = auto()
    NO = auto()
    """It answers by itself: "no, the cap"."""
    DOUBTFUL = auto()
    """A "no" without a pause, "no cap": either."""
    AGAINST = auto()
    """One of them: of two the other is meant."""
    NONE = auto()
    """Whatever it names, nothing is to be done."""


@dataclass(slots=True)
class _Part:
    stance: _Stance
    words: list[str]


def chosen(choices: Sequence[Choice], readings: Sequence[str]) -> Choice | Neither | None:
    """None where the answer names none of them, or where two readings of it name different ones."""
    named = [_named(choices, _parts(words_of(one))) for one in readings]
    said = [one for one in named if one is not None]
    return said[0] if said and all(one == said[0] for one in said) else None


def _named(choices: Sequence[Choice], parts: Sequence[_Part]) -> Choice | Neither | None:
    wanted, refused, doubtful = (
        _pointed_at(choices, [part.words for part in parts if part.stance is stance])
        for stance in (_Stance.FOR, _Stance.AGAINST, _Stance.DOUBTFUL)
    )
    if wanted or doubtful:
        sure = len(wanted) == 1 and not wanted & refused and not doubtful
        return choices[min(wanted)] if sure else None
    said = {word for part in parts if part.stance is _Stance.FOR for word in part.words}
    stances = {part.stance for part in parts} - {_Stance.FOR}
    if said - YES - POINTING:  # it asks for something else
        return None
    if len(choices) == 2 and refused and _Stance.NONE not in stances:
        return choices[1 - min(refused)] if len(refused) == 1 else Neither.SAID
    if stances:
        return Neither.SAID
    return choices[0] if len(choices) == 1 and said & YES else None


def _parts(words: Sequence[Word]) -> list[_Part]:
    """`FILLING` is left out."""
    parts = [_Part(_Stance.FOR, [])]
    for at, word in enumerate(words):
        follows = words[at + 1] if at + 1 < len(words) else None
        stance = _turned(word, follows)
        if stance is not None or word.opens:
            parts.append(_Part(stance or _Stance.FOR, []))
        if stance is _Stance.NO:  # and what follows is wanted
            parts.append(_Part(_Stance.FOR, []))
        elif stance is None and word.text not in FILLING:
            parts[-1].words.append(word.text)
    return parts


def _turned(word: Word, follows: Word | None) -> _Stance | None:
    """`follows` counts where it follows without a pause."""
    then = "" if follows is None or follows.opens else follows.text
    if word.text in NONE or (word.text in NO | NOT and then == "one"):
        return _Stance.NONE
    if word.text in NOT:
        return _Stance.AGAINST
    if word.text in BUT:
        return _Stance.FOR
    if word.text not in NO:
        return None
    return _Stance.DOUBTFUL if then and then not in POINTING | FILLING else _Stance.NO


def _pointed_at(choices: Sequence[Choice], said: Sequence[Sequence[str]]) -> set[int]:
    """Places of the choices; a number counts only where nothing is named by the words in which they differ."""
    told = [{word.text for word in words_of(one.text)} for one in choices]
    own = [words.difference(*told[:at], *told[at + 1 :]) for at, words in enumerate(told)]
    spoken = {word for words in said for word in words}
    by_words = {at for at, words in enumerate(own) if words & spoken} if len(choices) > 1 else set[int]()
    return by_words or {at for words in said for at in _numbers(words, len(choices))}


def _numbers(said: Sequence[str], count: int) -> Iterator[int]:
    for before, word in zip(("", *said), said, strict=False):
        place = ORDINALS.get(word) if before != "a" else None  # not "wait a second"
        if place is None and (word != "one" or not before or before in COUNTING):
            place = CARDINALS.get(word)
        if place is not None and place < count:
            yield place % count
