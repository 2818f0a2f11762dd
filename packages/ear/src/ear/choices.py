"""Which of its own choices an answer means: by number, or by the words in which they differ. Pure."""

from collections.abc import Sequence
from enum import Enum
from typing import Final

from contracts.intent import Choice
from vocabulary.folding import words_of

NUMBERS: Final = (
    frozenset({"1", "one", "first", "former"}),
    frozenset({"2", "two", "second", "latter"}),
    frozenset({"3", "three", "third"}),
    frozenset({"4", "four", "fourth"}),
)
NO: Final = frozenset({"no", "neither", "none", "nothing", "nope"})
YES: Final = frozenset({"yes", "yeah", "yep", "right", "correct", "sure", "okay", "ok"})


class Neither(Enum):
    """A person said that none of them is meant."""

    SAID = "said"


def chosen(choices: Sequence[Choice], readings: Sequence[str]) -> Choice | Neither | None:
    """None where the answer names none of them, or where two readings of it name different ones."""
    named = [_named(choices, _words(one)) for one in readings]
    said = [one for one in named if one is not None]
    return said[0] if said and all(one == said[0] for one in said) else None


def _named(choices: Sequence[Choice], said: frozenset[str]) -> Choice | Neither | None:
    told = [_words(one.text) for one in choices]
    own = [words.difference(*told[:at], *told[at + 1 :]) for at, words in enumerate(told)]
    by_words = [choice for choice, words in zip(choices, own, strict=True) if words & said]
    if len(choices) > 1 and by_words:
        return by_words[0] if len(by_words) == 1 else None
    by_number = [choice for choice, words in zip(choices, NUMBERS, strict=False) if words & said]
    if len(by_number) == 1:
        return by_number[0]
    if said & NO:
        return Neither.SAID
    return choices[0] if len(choices) == 1 and said & YES else None


def _words(sentence: str) -> frozenset[str]:
    return frozenset(word.text for word in words_of(sentence))
