"""What a question is about, read by rules: words lead to a topic, a kind of thing, a colour, a room. Nothing else."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from contracts.asking import About
from contracts.colours import Colour, colour_asked
from contracts.reading import Mood
from vocabulary.folding import joined, plain_words_of
from vocabulary.groups import Group, group_in
from vocabulary.labels import label_in
from vocabulary.moods import read
from vocabulary.rooms import named_in, speaks_of_a_place

SPOKEN: tuple[tuple[About, str], ...] = (
    (About.BATTERY, r"\bbatter(y|ies)\b|\bcharg(e|ed|ing)\b|\bpower\b"),
    (About.DOING, r"\b(are you doing|you up to|going on|your status|busy|queue|what is next)\b"),
    (About.DISCOVERIES, r"\bdiscover(y|ies|ed)?\b|\bexplor(ed|ing|ation)\b"),
    (About.HISTORY, r"\b(did you|have you|last mission|history|why did|why not|yesterday|so far)\b"),
)
"""First match wins."""


CHANGED = re.compile(r"\b(changed?|changes|moved|different|whats new|what is new|anything new|disappeared)\b")
SPANS: tuple[tuple[str, float], ...] = (("week", 7.0), ("month", 30.0), ("yesterday", 2.0), ("hour", 1.0 / 24.0))


@dataclass(frozen=True, slots=True)
class ParsedQuestion:
    about: About
    label: str | None = None
    colour: Colour | None = None
    room: str | None = None
    group: Group | None = None
    """'anything to drink?': several kinds of things."""
    days: float = 1.0
    """Of changes: how far back."""


def parse_question(question: str, rooms: Iterable[str] = ()) -> ParsedQuestion:
    """`rooms`: the names of the home's own."""
    text = joined(plain_words_of(question))
    label, room = label_in(text), named_in(question, rooms)
    colour = colour_asked(label or "", text)
    group = group_in(text) if label is None else None
    about = _about(text, label, room)
    mood = read(question).mood
    if mood is Mood.COUNT:
        about = About.COUNT
    elif about is not About.BATTERY and CHANGED.search(text):
        about = About.CHANGES
    elif group is not None and about in {About.UNKNOWN, About.LAST_SEEN, About.HISTORY, About.CONTENTS}:
        about = About.CONTENTS
    days = next((days for said, days in SPANS if said in text), 1.0)
    return ParsedQuestion(about, label, colour, room, group, days)


def needs_rooms(question: str, asked: ParsedQuestion) -> bool:
    """Whether the names of the home's rooms could change what it is read as, or belong to the answer."""
    if asked.about in {About.BATTERY, About.DOING, About.DISCOVERIES, About.HISTORY}:
        return False
    return asked.about is not About.UNKNOWN or speaks_of_a_place(question)


def _about(text: str, label: str | None, room: str | None) -> About:
    named = next((about for about, pattern in SPOKEN if re.search(pattern, text)), None)
    if named is About.HISTORY and re.search(r"\b(see|seen|saw)\b", text):
        named = None  # "have you seen my cup?"
    if named is not None:
        return named
    if room is not None and (label is None or re.search(r"\bwhat\b", text)):
        return About.CONTENTS
    if label is None and re.search(r"\b(what|which|list)\b.*\b(know|remember|seen|see|there|things|objects)\b", text):
        return About.CONTENTS
    seen = label is not None or re.search(r"\b(where|when|seen|see|saw)\b", text)
    return About.LAST_SEEN if seen else About.UNKNOWN
