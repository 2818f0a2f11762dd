"""The colour words the system knows, and the one that a description asks for."""

import re
from enum import StrEnum


class Colour(StrEnum):
    """A parser may use no other. `Colour("gray")` is GREY."""

    RED = "red"
    GREEN = "green"
    BLUE = "blue"
    YELLOW = "yellow"
    WHITE = "white"
    BLACK = "black"
    PURPLE = "purple"
    ORANGE = "orange"
    BROWN = "brown"
    PINK = "pink"
    GREY = "grey"

    @property
    def spellings(self) -> tuple[str, ...]:
        return tuple(word for word, colour in COLOUR_WORDS.items() if colour is self)

    @classmethod
    def _missing_(cls, value: object) -> "Colour | None":
        return COLOUR_WORDS.get(value) if isinstance(value, str) else None


COLOUR_WORDS: dict[str, Colour] = {one.value: one for one in Colour} | {"gray": Colour.GREY, "violet": Colour.PURPLE}
"""Every spelling, and the colour it stands for."""


def colour_asked(label: str, description: str) -> Colour | None:
    """The first colour word of the description. Of an orange, "orange" is the name unless it is said twice."""
    said: list[str] = re.findall(r"[a-z]+", description.lower())
    named = label == Colour.ORANGE and sum(word in {"orange", "oranges"} for word in said) < 2
    found = (COLOUR_WORDS[word] for word in said if word in COLOUR_WORDS)
    return next((one for one in found if not (named and one is Colour.ORANGE)), None)
