"""Cuts a command into plain words that remember where they stood. Pure."""

import re
import unicodedata
from dataclasses import dataclass

TOKENS_MAX = 120
CHARACTERS_MAX = 4000
_WORD = re.compile(r"[^\W\d_]+(?:['\u2019][^\W\d_]+)*['\u2019]?")
_STOP = re.compile(r"[.,;:!?()\"\u2026]+(?:\s|$)|\s[-\u2013\u2014]\s|\n")


@dataclass(frozen=True, slots=True)
class Token:
    """`word` is lower-case a-z; `start` and `end` are its place in the command."""

    word: str
    start: int
    end: int
    stop: bool = False
    """Punctuation stands before it."""
    owner: bool = False
    """Said with an apostrophe at its end: "the dog's", "the kids'"."""


def tokens_of(command: str) -> list[Token]:
    """At most 120 words without accents and apostrophes."""
    found: list[Token] = []
    behind = 0
    for match in _WORD.finditer(command[:CHARACTERS_MAX]):
        word = plain(match.group())
        if not word:
            continue
        stop = bool(found) and _STOP.search(command, behind, match.start()) is not None
        owner = match.group().casefold().endswith(("'s", "\u2019s", "s'", "s\u2019"))
        found.append(Token(word, match.start(), match.end(), stop, owner))
        behind = match.end()
    return found[:TOKENS_MAX]


def words_of(text: str) -> list[str]:
    return [token.word for token in tokens_of(text)]


def plain(text: str) -> str:
    """Lower case, no accents, letters a-z alone."""
    return re.sub(r"[^a-z]", "", unicodedata.normalize("NFKD", text.casefold()))
