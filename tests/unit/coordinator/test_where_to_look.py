"""Of several rooms and several things: what is to be looked for where."""

import pytest

from contracts.rooms import NamedBy, NamedRoom
from coordinator.commands.where_to_look import UnknownRoomError, rooms_meant, rooms_said
from coordinator.questions.rooms_meant import KnownRooms
from vocabulary.rooms import SaidRoom

KNOWN = KnownRooms(
    tuple(
        NamedRoom(id=at, name=name, named_by=NamedBy.PERSON, kind=kind, x=0.0, y=0.0, area_m2=9.0)
        for at, name, kind in ((1, "kitchen", "kitchen"), (2, "bedroom", "bedroom"), (3, "bedroom 2", "bedroom"))
    )
)


@pytest.mark.parametrize(
    ("asked", "parts", "rooms"),
    [
        ("find the cup in the kitchen and the bedroom", ("the cup in the kitchen",), [("kitchen", "bedroom")]),
        ("find the cup in the kitchen or in the bedroom", ("the cup",), [("kitchen", "bedroom")]),
        (
            "find the cup and the book in the kitchen or the bedroom",
            ("the cup", "the book in the kitchen or the bedroom"),
            [("kitchen", "bedroom"), ("kitchen", "bedroom")],
        ),
        (
            "find the cup in the kitchen and the book in the bedroom",
            ("the cup in the kitchen", "the book in the bedroom"),
            [("kitchen",), ("bedroom",)],
        ),
        (
            "find the cup and then the book in the kitchen",
            ("the cup", "the book in the kitchen"),
            [None, ("kitchen",)],
        ),
        ("find another cup than the one in the kitchen", ("the one in the kitchen",), [None]),
    ],
)
def test_no_room_that_is_said_is_passed_over(
    asked: str, parts: tuple[str, ...], rooms: list[tuple[str, ...] | None]
) -> None:
    found = rooms_said(asked, parts, KNOWN.names)
    assert [one.names if one is not None else None for one in found] == rooms


def test_all_rooms_of_the_place_are_meant_each_once() -> None:
    meant = rooms_meant(SaidRoom(("kitchen", "bedroom 2", "kitchen"), ""), KNOWN)
    assert [(one.id, one.name) for one in meant] == [(1, "kitchen"), (3, "bedroom 2")]


def test_a_place_of_which_one_room_is_not_known_is_refused() -> None:
    with pytest.raises(UnknownRoomError, match="no room called 'attic'"):
        rooms_meant(SaidRoom(("kitchen", "attic"), ""), KNOWN)
