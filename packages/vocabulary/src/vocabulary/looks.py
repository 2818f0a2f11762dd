"""What a thing is like: colours, materials, and the slips of the finger they are written with. Pure."""

import tomllib
from importlib.resources import files

from contracts.colours import COLOUR_WORDS, Colour
from vocabulary.spelling import doubled, one_slip, same_start

_TABLE = tomllib.loads(files("vocabulary").joinpath("data/looks.toml").read_text(encoding="utf-8"))
NOT_COLOURS: frozenset[str] = frozenset(_TABLE["not_colours"])
"""Words and names that stand one slip of the finger from a colour and are none: 'the back door', 'a pine chair'."""
MATERIALS_AND_COLOURS: frozenset[str] = frozenset({*_TABLE["materials"], *_TABLE["other_colours"], *COLOUR_WORDS})
_SAME: dict[str, str] = _TABLE["same"] | COLOUR_WORDS


def normalise(word: str) -> str:
    """One word for what is said in two: 'wood' is 'wooden', 'gray' is 'grey'."""
    return _SAME.get(word, word)


def colour_meant(word: str) -> Colour | None:
    """The one colour that `word` is a slip of: a letter too many, too few, wrong or swapped, or letters doubled.

    None for words of their own ("back", "write") and where two colours are as near. The beginning must be right, and
    colours of three letters are known by doubled ones alone: too many words are a letter away from "red".
    """
    if word in NOT_COLOURS or word in MATERIALS_AND_COLOURS:
        return None
    slips = {colour for known, colour in COLOUR_WORDS.items() if doubled(word, known)} or {
        colour
        for known, colour in COLOUR_WORDS.items()
        if len(known) >= 4 and same_start(word, known) and one_slip(word, known)
    }
    return slips.pop() if len(slips) == 1 else None
