"""A text as plain words that remember where they stood: any script, no case, no accents, no apostrophes."""

import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

WORDS_MAX = 200
CHARACTERS_MAX = 4000
APOSTROPHES = frozenset("'’‘`´")
BOUNDARIES = frozenset(".,;:!?()…\n")
DASHES = frozenset("-–—")
_SPELT = str.maketrans({"ß": "ss", "ı": "i", "đ": "d", "ø": "o", "ł": "l", "æ": "ae"})


@dataclass(frozen=True, slots=True)
class Word:
    """`text` is folded; `start` and `end` are its place in what was written."""

    text: str
    start: int
    end: int
    opens: bool = False
    """The first of the text, or punctuation stands before it."""
    owner: bool = False
    """Written with an apostrophe at its end: "the dog's", "the kids'"."""


def fold(text: str) -> str:
    """One word: "Arrêté!" becomes "arrete"."""
    plain = unicodedata.normalize("NFKD", text.casefold().translate(_SPELT))
    return "".join(letter for letter in plain if letter.isalnum())


def words_of(text: str) -> list[Word]:
    """At most 200 words. A hyphen parts two words, a dash between blanks is punctuation."""
    found: list[Word] = []
    opens = True
    for start, end, gap in _runs(text[:CHARACTERS_MAX]):
        opens = opens or any(letter in BOUNDARIES for letter in gap) or _is_dash(gap)
        written = text[start:end]
        word = fold(written)
        if word:
            plain = "".join("'" if letter in APOSTROPHES else letter for letter in written.casefold())
            owner = plain.endswith(("'s", "s'"))
            found.append(Word(word, start, end, opens, owner))
            opens = False
    return found[:WORDS_MAX]


def plain_words_of(text: str) -> list[Word]:
    """The same of letters a-z alone: numbers and other scripts are left out."""
    found: list[Word] = []
    opens = False
    for word in words_of(text):
        opens = opens or word.opens
        if word.text.isascii() and word.text.isalpha():
            found.append(replace(word, opens=opens))
            opens = False
    return found


def joined(words: Sequence[Word]) -> str:
    return " ".join(word.text for word in words)


def _runs(text: str) -> Iterator[tuple[int, int, str]]:
    """(start, end, what stands before it) of each run of letters, digits and apostrophes."""
    start, behind = None, 0
    for at, letter in enumerate(text):
        part = letter.isalnum() or unicodedata.category(letter).startswith("M") or (letter in APOSTROPHES)
        if part and start is None:
            start = at
        elif not part and start is not None:
            yield start, at, text[behind:start]
            start, behind = None, at
    if start is not None:
        yield start, len(text), text[behind:start]


def _is_dash(gap: str) -> bool:
    return any(letter in DASHES for letter in gap) and gap[:1].isspace() and gap[-1:].isspace()
