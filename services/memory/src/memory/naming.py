"""Which room of the map is which of those remembered, and what each is called. Pure."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from contracts.memory import ObjectState, RememberedObject
from contracts.rooms import ROOMS_MAX, NamedBy, NamedRoom
from geometry.rooms import IN_FURNITURE_M, Room, Rooms
from memory.ports import KeptRoom
from vocabulary.rooms import kinds_of, numbered

ANCHOR_OFF_M = 0.5
"""A map saved anew may show a thing where a room was remembered by."""
LABELS_TOLD = 100
ROOMS_TOLD = ROOMS_MAX
NAMELESS = re.compile(r"unnamed room \d+")


def is_nameless(name: str) -> bool:
    """Whether it is what `named` calls a room that nobody has named: no room may be given it."""
    return NAMELESS.fullmatch(" ".join(name.casefold().split())) is not None


@dataclass(frozen=True, slots=True)
class Matched:
    """`known`: the remembered room that each room of the map is, by its number; `new`: those that nobody remembers."""

    known: Mapping[int, KeptRoom]
    new: tuple[Room, ...]


def matched(kept: Iterable[KeptRoom], found: Rooms) -> Matched:
    """A remembered room is the one its place lies in. Where two are now one, the named one stays, then the older."""
    known: dict[int, KeptRoom] = {}
    for one in sorted(kept, key=lambda one: (not one.name, one.id)):
        room = found.at(one.x, one.y, within_m=ANCHOR_OFF_M)
        if room is not None:
            known.setdefault(room.number, one)
    return Matched(known, tuple(room for room in found.rooms if room.number not in known))


def shown(known: Mapping[int, KeptRoom]) -> list[KeptRoom]:
    """Those of the `known` that are told to anybody: the largest, where they are more than a reply may hold."""
    return [kept for number, kept in known.items() if number <= ROOMS_TOLD]


def placed(things: Sequence[RememberedObject], found: Rooms, known: Mapping[int, KeptRoom]) -> list[RememberedObject]:
    """The things with the room that each stands in."""
    out: list[RememberedObject] = []
    for one in things:
        room = found.at(one.position.x, one.position.y, within_m=IN_FURNITURE_M)
        kept = known.get(room.number) if room is not None else None
        out.append(one.model_copy(update={"room_id": kept.id}) if kept is not None else one)
    return out


def named(found: Rooms, known: Mapping[int, KeptRoom], things: Iterable[RememberedObject]) -> tuple[NamedRoom, ...]:
    """The rooms of the map by the order of their ids, each with the name a person gave it, or what it is, or none; the
    largest, where they are more than a reply may hold. No two bear one name.

    `things` know their rooms (`placed`); what is lost or has moved says nothing.
    """
    seen = ((known[one.number], one) for one in found.rooms[:ROOMS_TOLD] if one.number in known)
    rooms = sorted(seen, key=lambda each: each[0].id)
    contents: dict[int, list[str]] = {kept.id: [] for kept, _ in rooms}
    for thing in things:
        if thing.room_id in contents and thing.state in {ObjectState.PRESENT, ObjectState.DOUBTFUL}:
            contents[thing.room_id].append(thing.label)
    first: dict[str, KeptRoom] = {}
    for kept, _ in rooms:
        if kept.name and not is_nameless(kept.name):
            first.setdefault(kept.name.casefold(), kept)
    given = {kept.id: kept.name for kept in first.values()}
    kinds = kinds_of(contents)
    unnamed = [kept.id for kept, _ in rooms if kept.id not in given]
    free = kinds_of({one: contents[one] for one in unnamed}, taken=(name.casefold() for name in given.values()))
    guessed = dict(zip(free, numbered(list(free.values()), given.values()), strict=True))
    return tuple(
        NamedRoom(
            id=kept.id,
            name=given.get(kept.id) or guessed.get(kept.id) or f"unnamed room {kept.number}",
            named_by=NamedBy.PERSON if kept.id in given else NamedBy.CONTENTS if kept.id in guessed else NamedBy.NOBODY,
            kind=kinds.get(kept.id),
            x=room.x_m,
            y=room.y_m,
            area_m2=room.area_m2,
            labels=tuple(sorted(set(contents[kept.id])))[:LABELS_TOLD],
        )
        for kept, room in rooms
    )
