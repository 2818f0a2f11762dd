"""Kinds of rooms: their names, and the things that make them. Pure."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from vocabulary.folding import Word, joined, plain_words_of, words_of

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
NAMED_MAX = 64
ONLY_ONE = frozenset({"kitchen", "living room", "dining room"})
"""A home has one of these: the room that most speaks for it."""
SAID: dict[str, str] = {
    "lounge": "living room", "sitting room": "living room", "bath": "bathroom", "toilet room": "bathroom",
    "restroom": "bathroom", "study": "office",
}  # fmt: skip
"""Other words for a kind."""
BESIDE = r"(?:next to|beside|near|near to|close to|nearby|opposite|opposite to|across from|adjacent to)"
"""Before a place that is not meant itself."""
BEFORE = r"(?:in|into|inside|from|to|of|through|at)"


_THE = r"(?:(?:either|both) )?(?:(?:the|my|our|your|his|her|their|any|both|either|all)(?: of the)? )?"
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
    r"\b(?:i am|im|we are|were|you are|youre|i was"
    r"|(?:he|she|somebody|someone|everybody|everyone|mum|mom|dad) is|(?:they|people) are) $"
)
"""Before a place where somebody is."""
DENIES = re.compile(
    r"\b(?:not|no|never|nobody|none|nothing|nowhere|neither|nor|cannot|without|except|excepting|excluding|besides"
    r"|isnt|arent|wasnt|werent|dont|doesnt|didnt|havent|hasnt|hadnt|cant|couldnt|wont|shouldnt|wouldnt|aint"
    r"|(?:any|every|some)(?:where|thing|body|one| rooms?) but|all but|but for|than|apart from|aside from|instead of"
    r"|away from|far from|outside|ignore|ignoring|skip|skipping|avoid|avoiding"
    r"|already|yesterday|was|were|been|had|looked|searched|checked|scanned|explored|saw|seen|used to)\b"
)
"""In a clause that tells where a thing is not, or where it was."""
DEPENDS = re.compile(r"\b(?:if|unless|otherwise|else|in case)\b")
"""Where of several places one is for the case that another is in vain."""
_AND = r"(?:and|or|then|also|maybe|perhaps|possibly|even|plus)"
_IN = r"(?:in|into|inside|within|at|on|around|from|through)"
_ITS = r"(?:the|my|our|your|his|her|their)"
AND_THE = rf"(?:(?: {_AND})+(?: {_IN})? {_THE}| {_ITS} )"
"""Between two places of which both are meant."""
BEHIND = (
    rf"(?:$| (?:{_AND}|{_IN}|for|to|please|find|look|search|check|get|bring|fetch|see|now|first|too|as|but|if|with|that"
    r"|which|next|instead|only|again|rooms?|there|is|are)\b)"
)
"""What may follow a place: anything else is a thing that the room only describes."""
ADDS = frozenset(f"{_AND}|{_IN}|{_ITS}|nor".replace("(?:", "").replace(")", "").split("|"))
"""A clause that begins so is of the one before it."""
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

    A name is heard where a room may be meant ('in', 'to', 'from the ...'): Anna is a room only in 'go to Anna'. One
    that only tells where another place is ('the hallway next to the kitchen') is not meant.
    """
    text = without_neighbours(text, names)
    said = joined(words_of(text))
    for name in sorted(names, key=lambda one: (-len(one), one)):
        words = joined(words_of(name))
        if words and re.search(rf"\b{BEFORE} (?:the |my |our |a )?{re.escape(words)}\b", said):
            return name
    kind = room_in(text)
    if kind is not None:
        return kind
    return next((kind for word, kind in SAID.items() if re.search(rf"\b{BEFORE} (?:the |my )?{word}\b", said)), None)


def without_neighbours(text: str, names: Iterable[str]) -> str:
    """The words without 'next to the kitchen' and the like, as joined words where any is left out."""
    said = joined(words_of(text))
    rooms = "|".join(re.escape(joined(words_of(one))) for one in sorted({*names, *ROOMS, *SAID}, key=len, reverse=True))
    kept = re.sub(rf"\b{BESIDE} {_THE}(?:{rooms})\b", "", said)
    return text if kept == said else " ".join(kept.split())


def speaks_of_a_place(text: str) -> bool:
    """Whether a word is said behind which `named_in` may hear the name of a room."""
    return re.search(rf"\b{BEFORE}\b", joined(words_of(text))) is not None


@dataclass(frozen=True, slots=True)
class SaidRoom:
    """Where a person says to look: in any of `names`, each a name of the home's own or a kind. `said` are the words
    for it.
    """

    names: tuple[str, ...]
    said: str

    @property
    def name(self) -> str:
        """For a person, of at most 64 letters: 'kitchen', 'kitchen or bedroom'."""
        return " or ".join(self.names)[:NAMED_MAX]


def searched_in(text: str, names: Iterable[str] = ()) -> SaidRoom | None:
    """The rooms that a command says to look in: all that are said as a place ('in the kitchen', 'search the kitchen').

    Not where a thing is to be brought ('to the kitchen'), nor what only describes it ('the kitchen knife'), nor what a
    clause says that denies something or tells of the past ("it isn't in the kitchen"). None too where one of several
    rooms is not clearly meant: it is looked for everywhere then. A room that none of `names` and no kind is ('in the
    attic', "in Anna's room") is told as it was said.
    """
    known = _known_rooms(names)
    room = f"(?:{'|'.join((*known, SOME_ROOM))})"
    rooms = rf"{room}\b(?:{AND_THE}{room}\b)*"
    place = re.compile(rf"{WHERE}(?P<there>{rooms})|{GOING}(?P<goal>{rooms}){TO_LOOK}")
    beside = re.compile(rf"(?:^|\b{_AND} ){_THE}{room}{BEHIND}")
    found: list[str] = []
    said: list[str] = []
    sure = True
    for clause in _clauses(text):
        places = [one for one in place.finditer(clause) if NOT_THERE.search(clause[: one.start()]) is None]
        if DENIES.search(clause) is not None:
            sure &= not places or DEPENDS.search(joined(words_of(text))) is None
            continue
        sure &= all(any(p.start() <= one.start() < p.end() for p in places) for one in beside.finditer(clause))
        for one in places:
            meant = re.findall(rf"(?:^|{AND_THE})({room})\b", one["there"] or one["goal"])
            sure &= len(meant) == 1 or re.match(BEHIND, clause[one.end() :]) is not None
            found += meant
            said.append(one.group().strip())
    named = tuple(dict.fromkeys(_name(one, known) for one in found))
    sure &= len(named) == 1 or DEPENDS.search(joined(words_of(text))) is None
    return SaidRoom(named, "; ".join(said)) if named and sure else None


def may_say_where(text: str) -> bool:
    """Whether words are said behind which `searched_in` may hear the name of a room."""
    return re.search(f"{WHERE}|{GOING}", joined(words_of(text)) + " ") is not None


def _known_rooms(names: Iterable[str]) -> dict[str, str]:
    """The name that each pattern of words means; the longest first."""
    found: dict[str, str] = {}
    for name in names:
        if words := joined(words_of(name)):
            found.setdefault(re.escape(words), name)
    for kind in ROOMS:
        found.setdefault(rf"{kind}s?", kind)
    for word, kind in SAID.items():
        found.setdefault(rf"{word}s?", kind)
    return dict(sorted(found.items(), key=lambda one: -len(one[0])))


def _name(said: str, known: Mapping[str, str]) -> str:
    return next((name for words, name in known.items() if re.fullmatch(words, said)), said)


def _clauses(text: str) -> list[str]:
    """As joined words. What only adds to the clause before it, a place or an alternative, is of that clause."""
    clauses: list[list[Word]] = []
    for word in words_of(text):
        alone = not clauses or joined(clauses[-1]) == "no"
        if word.opens and (alone or word.text not in ADDS):
            clauses.append([])
        clauses[-1].append(word)
    return [joined(one) for one in clauses]


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
