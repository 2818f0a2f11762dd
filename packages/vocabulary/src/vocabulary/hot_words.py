"""The names a speech recogniser is told to expect, within what Whisper takes. Pure."""

from collections.abc import Iterable, Sequence
from typing import Final

from pydantic import TypeAdapter, ValidationError

from contracts.speech import HOT_WORDS_MAX, HotWord

OPENINGS: Final = ("find the", "bring me the", "where did I leave my", "pour the", "what is in the kitchen")
NAMES: Final = (
    "bottle", "cup", "mug", "wine glass", "fork", "knife", "spoon", "bowl", "banana", "apple", "orange", "sandwich",
    "book", "clock", "vase", "scissors", "teddy bear", "remote control", "laptop", "mouse", "keyboard", "phone",
    "backpack", "handbag", "suitcase", "umbrella", "tie", "chair", "couch", "potted plant", "bed", "table",
    "television", "microwave", "oven", "toaster", "sink", "fridge", "ball", "frisbee", "kite", "skateboard",
    "toothbrush", "hair dryer", "keys", "glasses", "hat", "shoe", "towel", "lamp", "medicine", "dock",
)  # fmt: skip
"""Things of a home that are asked for most. No colours: they are heard well, and what is expected is also made up."""
CHARACTERS_MAX: Final = 600
"""faster-whisper cuts at 223 tokens without a word; a token of these is three characters and more."""

_HOT_WORD: Final[TypeAdapter[str]] = TypeAdapter(HotWord)


def sayable(labels: Iterable[str]) -> list[str]:
    """Those of `labels` (what memory holds, most wanted first) that speech takes as hot words, as many as it takes."""
    return [one for one in dict.fromkeys(labels) if _is_hot_word(one)][:HOT_WORDS_MAX]


def expected(first: Sequence[str] = ()) -> tuple[str, ...]:
    """How commands begin, then `first` (what memory holds), then the common names; each once."""
    return tuple(dict.fromkeys((*OPENINGS, *first, *NAMES)))


def hot_words(first: Sequence[str] = ()) -> str:
    """`first` (what memory holds) before the common names, each once; whole names only."""
    told = ", ".join(OPENINGS)
    for name in dict.fromkeys((*first, *NAMES)):
        if len(told) + len(name) + 2 > CHARACTERS_MAX:
            break
        told += f", {name}"
    return told


def _is_hot_word(label: str) -> bool:
    try:
        _HOT_WORD.validate_python(label)
    except ValidationError:
        return False
    return True
