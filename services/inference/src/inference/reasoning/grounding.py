"""Whether an answer says more than it was told: things, places, colours and numbers nobody gave. Pure."""

import re
from collections.abc import Iterable

from contracts.colours import COLOUR_WORDS
from inference.parsing.lexicon import lexicon
from inference.parsing.mentions import find_mentions
from vocabulary.folding import plain_words_of

NUMBERS = {
    "zero": "0", "two": "2", "three": "3", "four": "4", "five": "5", "six": "6", "seven": "7", "eight": "8",
    "nine": "9", "ten": "10", "eleven": "11", "twelve": "12", "fifteen": "15", "twenty": "20", "thirty": "30",
}  # fmt: skip
"""Without 'one', which often is no number: 'the red one'."""
PLACES = frozenset((
    "kitchen", "bedroom", "bathroom", "hall", "hallway", "corridor", "office", "garage", "garden", "attic", "basement",
    "cellar", "nursery", "pantry", "balcony", "lounge", "study", "upstairs", "downstairs",
))  # fmt: skip


def invented(answer: str, given: Iterable[str]) -> tuple[str, ...]:
    """What `answer` names that `given` does not hold, in the order said, each once."""
    known: set[str] = set()
    for text in given:
        known.update(_claims(text))
    return tuple(dict.fromkeys(claim for claim in _claims(answer) if claim not in known))


def _claims(text: str) -> list[str]:
    """Labels of things (or the words for things without one), colours, places, numbers."""
    words = lexicon()
    tokens = plain_words_of(text)
    things = [
        one.label if one.label != "none" else one.said for one in find_mentions(tokens, words) if not one.corrected
    ]
    said = [token.text for token in tokens]
    plain = [COLOUR_WORDS.get(word, word) for word in said if word in words.colours or word in PLACES]
    spoken = [NUMBERS[word] for word in said if word in NUMBERS]
    return [*things, *plain, *spoken, *(_number(one) for one in re.findall(r"\d+(?:[.,]\d+)*", text))]


def _number(said: str) -> str:
    """'07' and '7.0' are 7; '0,5' is 0.5."""
    plain = said.replace(",", ".").lstrip("0") or "0"
    if "." in plain and plain.count(".") == 1:
        plain = plain.rstrip("0").rstrip(".")
    return f"0{plain}" if plain.startswith(".") else plain
