"""In which rooms a person wants a thing looked for: from the words, by memory's rooms. Pure."""

import re
from collections.abc import Sequence

from contracts.mission import SearchedRoom
from contracts.reading import Restriction
from coordinator.questions.rooms_meant import KnownRooms
from vocabulary.folding import joined, words_of
from vocabulary.rooms import SaidRoom, searched_in

NAMES_TOLD = 12
IN_TURN = re.compile(r"\bthen\b")
IT = re.compile(r"\b(?:it|that|this|them|that one|this one|the same)\b")


class UnknownRoomError(ValueError):
    """The home has no room that is meant; for a person."""


def rooms_said(asked: str, parts: Sequence[str], names: Sequence[str]) -> tuple[SaidRoom | None, ...]:
    """Of each part of a command. The one place that is said of a part holds for all of them ('the cup and the book in
    the kitchen'), unless they are asked for one after the other.
    """
    own, whole = [searched_in(part, names) for part in parts], searched_in(asked, names)
    each = {one.names for one in own if one is not None}
    of_all = whole is not None and {name for some in each for name in some} < set(whole.names)
    if whole is not None and (of_all or len(each) == 1) and not _in_turn(asked, parts):
        return (whole,) * len(parts)
    return (None,) if len(parts) == 1 and whole is None else tuple(own)


def _in_turn(asked: str, parts: Sequence[str]) -> bool:
    return len(parts) > 1 and IN_TURN.search(joined(words_of(asked))) is not None


def rooms_meant(said: SaidRoom, known: KnownRooms) -> tuple[SearchedRoom, ...]:
    """Every room of the place that is said. Raises `UnknownRoomError`, where it has one that nobody knows."""
    meant = [(name, known.meant(name)) for name in said.names]
    missing = next((name for name, rooms in meant if not rooms), None)
    if missing is None:
        found = {one.id: SearchedRoom(id=one.id, name=one.name) for _, rooms in meant for one in rooms}
        return tuple(found.values())
    if not known.rooms:
        raise UnknownRoomError(f"I know no room yet, and so not where the {missing} is")
    names = ", ".join(known.names[:NAMES_TOLD]) + (", ..." if len(known.names) > NAMES_TOLD else "")
    raise UnknownRoomError(f"I know no room called '{missing}'. I know: {names}")


def not_of_a_room(restrictions: Sequence[Restriction], said: Sequence[SaidRoom | None]) -> tuple[Restriction, ...]:
    """Without those whose words only say the room, which is held to."""
    rooms = [one.said for one in said if one is not None]
    return tuple(one for one in restrictions if not any(joined(words_of(one.said)) in room for room in rooms))


def means_the_last(asked: str) -> bool:
    """No thing is named but 'it'."""
    return IT.search(joined(words_of(asked))) is not None
