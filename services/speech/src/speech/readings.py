"""Whether two readings of the same sound say the same, and what a recogniser is told to expect. Pure."""

import re
from collections.abc import Callable, Iterable
from typing import Final

TOKENS_MAX: Final = 200
"""faster-whisper cuts hot words at 223 tokens without a word."""


def agree(one: str, other: str) -> bool:
    """The same words in the same order; case and punctuation are the engine's."""
    return _words(one) == _words(other)


def fitting(names: Iterable[str], tokens_of: Callable[[str], int], tokens_max: int = TOKENS_MAX) -> str:
    """The first of `names`, each once and whole, with commas between, as many as fit."""
    taken: list[str] = []
    left = tokens_max
    for name in dict.fromkeys(names):
        left -= tokens_of(f" {name},")
        if left < 0:
            break
        taken.append(name)
    return ", ".join(taken)


def _words(text: str) -> list[str]:
    return re.findall(r"[^\W_]+", text.casefold().replace("'", ""))
