"""Kinds of rooms: their names, and the things that make them. Pure."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

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


_THE = r"(?:(?:the|my|our|your|his|her|their|any|both|either|all)(?: of the)? )?"
WHERE = (
    r"\b(?:(?:in|into|inside|within|at|around|from|through)(?: of)?|"
    r"(?:any|one|either|both|all) of|(?:search|check|scan|explore)(?: (?:in|through))?)"
    rf" {_THE}"
)
"""The words before a place to look in."""
GOING = rf"\b(?:go|drive|head|run|walk|move)(?: (?:back|over|up|down))* (?:to|into) {_THE}"
TO_LOOK = r"(?= (?:and|then|and then|to) (?:find|look|search|get|fetch|bring|see|check)\b)"
"""'Go to the kitchen and find the cup': it is looked for there."""
NOT_THERE = re.compile(
    r"\b(?:(?:not|never|except|without|besides|nowhere|(?:any|every)where but|all but)(?: for)?"
    r"|i am|im|we are|were|you are|youre|i was) $"
)
"""Before a place where not to look, or where somebody is."""
SOME_ROOM = (
    r"garage|hall|hallway|corridor|entrance|garden|attic|basement|cellar|balcony|terrace|nursery|pantry|porch|den|loft"
    r"|laundry|wardrobe|closet|playroom|sunroom"
    r"|(?!(?:the|every|each|any|all|whole|which|what|a|one|same) )\w+ room(?: \w*\d\w*)?|\w+s room"
)
"""What is a room by its name, whichever home it is in: of these a person can be told that there is none."""


def called(name: str) -> str:
    """'the kitchen', and 'Anna's room' as it is: a name with a capital is a person's own word."""
    return name if name[:1].isupper() else f"the {name}"


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


@dataclass(frozen=True, slots=True)
class SaidRoom:
    """Where a person says to look. `name` is a name of the home's own or a kind; `said` are the words for it."""

    name: str
    said: str


def searched_in(text: str, names: Iterable[str] = ()) -> SaidRoom | None:
    """The room that a command says to look in: the first one said as a place ('in the kitchen', 'search the kitchen').

    Not where a thing is to be brought ('to the kitchen'), nor what only describes it ('the kitchen knife'), nor where
    not to look. A room that none of `names` and no kind is ('in the attic', "in Anna's room") is told as it was said.
    """
    said = joined(words_of(text))
    found = (_place(said, words, name) for words, name in _said_rooms(names))
    places = [one for one in found if one is not None]
    if not places:
        unknown = re.search(rf"{WHERE}(?P<room>{SOME_ROOM})\b", said)
        places = [(unknown, unknown["room"])] if unknown is not None and not _is_denied(said, unknown) else []
    if not places:
        return None
    match, name = min(places, key=lambda one: (one[0].start(), -len(one[0].group())))
    return SaidRoom(name, match.group().strip())


def may_say_where(text: str) -> bool:
    """Whether words are said behind which `searched_in` may hear the name of a room."""
    return re.search(f"{WHERE}|{GOING}", joined(words_of(text)) + " ") is not None


def _said_rooms(names: Iterable[str]) -> Iterator[tuple[str, str]]:
    """(words as a pattern, the name they mean)."""
    for name in names:
        if words := joined(words_of(name)):
            yield re.escape(words), name
    for kind in ROOMS:
        yield rf"{kind}s?", kind
    for word, kind in SAID.items():
        yield rf"{word}s?", kind


def _place(said: str, words: str, name: str) -> tuple[re.Match[str], str] | None:
    match = re.search(rf"{WHERE}{words}\b|{GOING}{words}\b{TO_LOOK}", said)
    return None if match is None or _is_denied(said, match) else (match, name)


def _is_denied(said: str, match: re.Match[str]) -> bool:
    return NOT_THERE.search(said[: match.start()]) is not None


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
