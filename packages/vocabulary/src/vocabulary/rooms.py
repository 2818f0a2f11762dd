"""Kinds of rooms: their names, and the things that make them. Pure."""

import re
from collections.abc import Iterable, Mapping, Sequence

from vocabulary.folding import joined, plain_words_of, words_of

MARKS: dict[str, dict[str, float]] = {
    "kitchen": {"oven": 3.0, "refrigerator": 3.0, "microwave": 2.0, "toaster": 1.5, "sink": 1.0},
    "bathroom": {"toilet": 3.0, "toothbrush": 1.5, "hair drier": 1.5, "sink": 1.0},
    "bedroom": {"bed": 3.0},
    "living room": {"couch": 2.0, "tv": 1.5},
    "dining room": {"dining table": 1.5},
    "office": {"laptop": 1.0, "keyboard": 1.5, "mouse": 1.0},
}
"""The COCO classes that make a room one of its kind, and how much each says: a sink alone makes no kitchen."""
ROOMS: dict[str, tuple[str, ...]] = {
    room: tuple(sorted(marks, key=lambda label: -marks[label])) for room, marks in MARKS.items()
}
"""The same, the surest first."""
SURE_FROM = 1.5
ONLY_ONE = frozenset({"kitchen", "living room", "dining room"})
"""A home has one of these: the room that most speaks for it."""
SAID: dict[str, str] = {
    "lounge": "living room", "sitting room": "living room", "bath": "bathroom", "toilet room": "bathroom",
    "restroom": "bathroom", "study": "office",
}  # fmt: skip
"""Other words for a kind."""
BEFORE = r"(?:in|into|inside|from|to|of|through|at)"


def room_in(text: str) -> str | None:
    """The first kind of room that is named; None where none is."""
    said = joined(plain_words_of(text))
    return next((room for room in ROOMS if room in said), None)


def named_in(text: str, names: Iterable[str]) -> str | None:
    """Of the names of a home's rooms the longest that is said, as a whole word; else the kind of room that is said.

    A name is heard where a room may be meant ('in', 'to', 'from the ...'): Anna is a room only in 'go to Anna'.
    """
    said = joined(words_of(text))
    for name in sorted(names, key=lambda one: (-len(one), one)):
        words = joined(words_of(name))
        if words and re.search(rf"\b{BEFORE} (?:the |my |our |a )?{re.escape(words)}\b", said):
            return name
    kind = room_in(text)
    if kind is not None:
        return kind
    return next((kind for word, kind in SAID.items() if re.search(rf"\b{BEFORE} (?:the |my )?{word}\b", said)), None)


def speaks_of_a_place(text: str) -> bool:
    """Whether a word is said behind which `named_in` may hear the name of a room."""
    return re.search(rf"\b{BEFORE}\b", joined(words_of(text))) is not None


def kinds_of(contents: Mapping[int, Iterable[str]], taken: Iterable[str] = ()) -> dict[int, str]:
    """What each room is, by the labels of what stands in it: its surest kind that is left. A room of which nothing
    speaks clearly is left out; `taken` are kinds of which a person has already named the one there is.
    """
    scores = {
        (room, kind): sum(marks.get(label, 0.0) for label in set(labels))
        for room, labels in contents.items()
        for kind, marks in MARKS.items()
    }
    out: dict[int, str] = {}
    gone = ONLY_ONE & set(taken)
    for (room, kind), score in sorted(scores.items(), key=lambda one: (-one[1], one[0])):
        if score < SURE_FROM or room in out or kind in gone:
            continue
        out[room] = kind
        gone |= {kind} & ONLY_ONE
    return out


def numbered(kinds: Sequence[str], taken: Iterable[str] = ()) -> list[str]:
    """Names for rooms of these kinds: the second bedroom is 'bedroom 2'. None of them is in `taken`."""
    used = {one.casefold() for one in taken}
    out: list[str] = []
    for kind in kinds:
        names = (kind if k == 1 else f"{kind} {k}" for k in range(1, len(kinds) + len(used) + 2))
        name = next(one for one in names if one not in used)
        used.add(name)
        out.append(name)
    return out
