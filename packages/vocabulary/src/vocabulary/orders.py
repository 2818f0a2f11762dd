"""Stop, wait, go on: words that act on what runs, at once, in every language people shout in. Pure and quick.

When in doubt it is a stop: a robot that stands still too often is a nuisance, one that drives on is a danger.
"""

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.resources import files
from typing import Any

from contracts.reading import Mood
from vocabulary.folding import Word, joined, words_of
from vocabulary.spelling import one_slip

SLIP_LETTERS_MIN = 4
JOINTS = frozenset(("and", "then", "but", "instead"))
TRAILING = frozenset(("stop", "halt", "abort", "freeze"))
"""At the end of a saying without punctuation, as speech recognition writes it: 'look out stop'."""
SHOUTED_MAX = 4
STOPPING = (Mood.EMERGENCY, Mood.STOP)

Phrase = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Order:
    """What to do about what runs, and what is said behind it ('stop and find the cup' -> 'find the cup')."""

    mood: Mood
    said: str
    rest: str = ""


@dataclass(frozen=True)
class _Table:
    opens: Mapping[Mood, frozenset[Phrase]]
    alone: Mapping[Mood, frozenset[Phrase]]
    around: Mapping[str, frozenset[str]]
    single: tuple[str, ...]
    """One word, long enough to be told from a slip of it."""
    longest: int


def order_in(text: str) -> Order | None:
    """The order in what was said or written; None where there is none. Of several, the gravest."""
    words = words_of(text)
    table = _table()
    for mood in (Mood.EMERGENCY, Mood.STOP, Mood.PAUSE, Mood.RESUME):
        found = _opening(text, words, mood, table) or _alone(words, mood, table)
        if found is not None:
            return found
    return _trailing(words, table)


def stop_words(language: str) -> tuple[str, ...]:
    """What a recogniser is told to expect so that it hears a stop in noise; English where the language is unknown."""
    table = tomllib.loads(files("vocabulary").joinpath("data/orders.toml").read_text(encoding="utf-8"))
    return tuple(table["stop"]["languages"].get(language, table["stop"]["shouted"])[:SHOUTED_MAX])


def stop_in(text: str, *, whole: bool = True) -> bool:
    """Whether it is an order to stop. Of a saying that may go on (`whole` is False) only what stops whatever follows:
    "don't" may become "don't forget the cup", and "a place to stop" a "place to stop by".
    """
    if whole:
        order = order_in(text)
        return order is not None and order.mood in STOPPING
    words, table = words_of(text), _table()
    return any(_opening(text, words, mood, table) is not None for mood in STOPPING)


def _opening(text: str, words: Sequence[Word], mood: Mood, table: _Table) -> Order | None:
    """A clause that begins with it, fillers aside: 'ok robot, stop looking for the cup'."""
    phrases = table.opens.get(mood, frozenset())
    for first in (at for at, word in enumerate(words) if word.opens):
        for at in range(first, len(words)):
            behind = _phrase_end(words, at, phrases, table, whole=False)
            if behind is not None and not _is_thing(words, behind, table):
                return Order(mood, joined(words[at:behind]), _rest(text, words, behind))
            if words[at].text not in table.around["fillers"] or (at > first and words[at].opens):
                break
    return None


def _alone(words: Sequence[Word], mood: Mood, table: _Table) -> Order | None:
    """Nothing but it and fillers is said: 'oh no, wait a second please'."""
    phrases, fillers = table.alone.get(mood, frozenset()) | table.opens.get(mood, frozenset()), table.around["fillers"]
    at, said = 0, ""
    while at < len(words):
        behind = _phrase_end(words, at, phrases, table, whole=True)
        if behind is not None and not _is_denied(words, at, behind, table):
            at, said = behind, said or joined(words[at:behind])
        elif behind is None and words[at].text in fillers:
            at += 1
        else:
            return None
    return Order(mood, said) if said else None


def _trailing(words: Sequence[Word], table: _Table) -> Order | None:
    if not words or words[-1].text not in TRAILING or words[0].text in table.around["questions"]:
        return None
    before = [word.text for word in words[-3:-1]]
    denied = any(word in table.around["negations"] for word in before)
    thing = bool(before) and before[-1] in table.around["nouns_before"] | table.around["sequence"] - {"to"}
    return None if denied or thing else Order(Mood.STOP, words[-1].text)


def _is_denied(words: Sequence[Word], at: int, behind: int, table: _Table) -> bool:
    """ "don't *stop*", but not "don't, *don't*" nor "don't! *Stop*!"."""
    negations = table.around["negations"]
    own = any(word.text in negations for word in words[at:behind])
    return at > 0 and words[at - 1].text in negations and not words[at].opens and not own


def _phrase_end(
    words: Sequence[Word], at: int, phrases: frozenset[Phrase], table: _Table, *, whole: bool
) -> int | None:
    """Where the longest phrase that begins at `at` ends."""
    for length in range(min(table.longest, len(words) - at), 0, -1):
        said = tuple(word.text for word in words[at : at + length])
        if said in phrases and not any(word.opens for word in words[at + 1 : at + length]):
            return at + length
    slip = _meant(words[at].text, whole=whole)
    return at + 1 if slip is not None and (slip,) in phrases else None


@lru_cache(maxsize=4096)
def _meant(written: str, *, whole: bool) -> str | None:
    """The order that a word is a slip of: two letters swapped, or in a saying of nothing else one letter wrong."""
    table = _table()
    if len(written) < SLIP_LETTERS_MIN or not written.isascii() or written in table.around["real_words"]:
        return None
    return next(
        (
            word
            for word in table.single
            if one_slip(written, word) and (sorted(written) == sorted(word) or (whole and word in TRAILING))
        ),
        None,
    )


def _is_thing(words: Sequence[Word], behind: int, table: _Table) -> bool:
    """'stop sign', 'emergency exit'."""
    following = words[behind] if behind < len(words) else None
    return following is not None and not following.opens and following.text in table.around["nouns_behind"]


def _rest(text: str, words: Sequence[Word], behind: int) -> str:
    """What is said behind the clause of the order."""
    for at in range(behind, len(words)):
        if words[at].text in JOINTS and at + 1 < len(words):
            return text[words[at + 1].start :].strip()
        if words[at].opens:
            return text[words[at].start :].strip()
    return ""


@cache
def _table() -> _Table:
    table = tomllib.loads(files("vocabulary").joinpath("data/orders.toml").read_text(encoding="utf-8"))
    moods = (Mood.EMERGENCY, Mood.STOP, Mood.PAUSE, Mood.RESUME)
    opens = {
        mood: _phrases(table[mood.value], "opens", "languages" if mood is not Mood.PAUSE else "") for mood in moods
    }
    alone = {mood: _phrases(table[mood.value], "alone", "languages_alone") for mood in moods}
    for mood in (Mood.PAUSE, Mood.RESUME):
        alone[mood] |= _phrases(table[mood.value], "", "languages")
        opens[mood] = frozenset[Phrase]()
    every = {phrase for group in (*opens.values(), *alone.values()) for phrase in group}
    single = sorted(one[0] for one in every if len(one) == 1 and one[0].isascii() and len(one[0]) >= SLIP_LETTERS_MIN)
    around = {name: frozenset(words) for name, words in table["around"].items()}
    return _Table(opens, alone, around, tuple(single), max(map(len, every)))


def _phrases(group: Mapping[str, Any], own: str, languages: str) -> frozenset[Phrase]:
    lists: list[Iterable[str]] = [group.get(own, ()), *group.get(languages, {}).values()]
    return frozenset(tuple(word.text for word in words_of(said)) for said_in in lists for said in said_in)
