"""Where a command says to look: a room of the home, by its name or kind; or one that nobody knows."""

import pytest

from vocabulary.rooms import may_say_where, named_in, searched_in

NAMES = ("kitchen", "bedroom", "bedroom 2", "Anna's room", "den", "unnamed room 3", "Küche")


@pytest.mark.parametrize(
    ("said", "room"),
    [
        ("find the red bottle in the kitchen", "kitchen"),
        ("look for it in the living room", "living room"),
        ("look in the bedroom for my book", "bedroom"),
        ("search the kitchen for a red cup", "kitchen"),
        ("check my bedroom for the phone", "bedroom"),
        ("look through the office for the scissors", "office"),
        ("bring me the cup from the kitchen", "kitchen"),
        ("in the bathroom, find the toothbrush", "bathroom"),
        ("find the book in bedroom 2", "bedroom 2"),
        ("find the book in the bedrooms", "bedroom"),
        ("find the book in any of the bedrooms", "bedroom"),
        ("find the book in both bedrooms", "bedroom"),
        ("find the phone in Anna's room", "Anna's room"),
        ("find the phone in annas room please", "Anna's room"),
        ("find the cup in the den", "den"),
        ("find the cup inside unnamed room 3", "unnamed room 3"),
        ("find the cup in the lounge", "living room"),
        ("find the soap in the restroom", "bathroom"),
        ("find the cup in the küche", "Küche"),
        ("find the toilet in the bathroom", "bathroom"),
        ("fetch the cup from the kitchen and bring it to the bedroom", "kitchen"),
        ("find the spoon in the kitchen sink", "kitchen"),
        ("go to the kitchen and find the cup", "kitchen"),
        ("drive into my bedroom to look for the book", "bedroom"),
    ],
)
def test_the_room_that_is_said_as_a_place_is_the_one_to_look_in(said: str, room: str) -> None:
    found = searched_in(said, NAMES)
    assert found is not None
    assert found.name == room
    assert may_say_where(said)


@pytest.mark.parametrize(
    "said",
    [
        "find the red bottle",
        "find the kitchen knife",
        "find the bathroom scale",
        "find the living room remote",
        "bring the red cup to the kitchen",
        "take the book to the bedroom",
        "find the cup, but not in the kitchen",
        "find the cup anywhere but in the kitchen",
        "find the cup on the table",
        "find the cup in the box",
        "I am in the kitchen, find the red bottle",
        "go to the kitchen",
        "find the cup in the house",
        "find the cup in every room",
        "look for the cup in any room",
        "look around in the room",
        "find the cup that my mother left",
        "find the bottle in front of the couch",
    ],
)
def test_what_only_describes_a_thing_or_says_where_not_is_no_place_to_look_in(said: str) -> None:
    assert searched_in(said, NAMES) is None


@pytest.mark.parametrize(
    ("said", "room"),
    [
        ("find the bottle in the garage", "garage"),
        ("find the bottle in the hallway", "hallway"),
        ("find the bottle in Bob's room", "bobs room"),
        ("find the bottle in the guest room", "guest room"),
        ("find the bottle in this room", "this room"),
        ("find the bottle in the other room", "other room"),
        ("find the bottle in the attic", "attic"),
    ],
)
def test_a_room_that_nobody_knows_is_told_as_it_was_said(said: str, room: str) -> None:
    found = searched_in(said, NAMES)
    assert found is not None
    assert found.name == room


def test_the_words_for_it_are_told_so_that_they_are_not_said_to_be_passed_over() -> None:
    found = searched_in("Find the red bottle in the Kitchen!", NAMES)
    assert found is not None
    assert found.said == "in the kitchen"


def test_a_name_of_the_homes_own_outweighs_the_kind_that_is_in_it() -> None:
    found = searched_in("find the cup in the guest bedroom", ("guest bedroom", "bedroom"))
    assert found is not None
    assert found.name == "guest bedroom"


@pytest.mark.parametrize(
    ("said", "rooms"),
    [
        ("find the cup in the kitchen and the bedroom", ("kitchen", "bedroom")),
        ("find the cup in the kitchen or the bedroom", ("kitchen", "bedroom")),
        ("find the cup in the kitchen or in the bedroom", ("kitchen", "bedroom")),
        ("find the cup in the kitchen, the bedroom or the office", ("kitchen", "bedroom", "office")),
        ("find the cup in either the kitchen or bedroom 2 please", ("kitchen", "bedroom 2")),
        ("look in the kitchen for the cup and then in the bedroom", ("kitchen", "bedroom")),
        ("go to the kitchen or the bedroom and find the cup", ("kitchen", "bedroom")),
        ("find the cup in the kitchen or the attic", ("kitchen", "attic")),
        ("find the cup in Anna's room and my living room", ("Anna's room", "living room")),
        ("find the cup in the kitchen, not in the bedroom", ("kitchen",)),
        ("it isn't in the kitchen, find the cup in the bedroom", ("bedroom",)),
        ("I can't find my cup, look in the kitchen", ("kitchen",)),
        ("no, in the kitchen", ("kitchen",)),
        ("find the red cup, not the blue one; it is in the kitchen", ("kitchen",)),
        ("find the cup in the kitchen and the kitchen", ("kitchen",)),
    ],
)
def test_every_room_that_is_said_as_a_place_is_one_to_look_in(said: str, rooms: tuple[str, ...]) -> None:
    found = searched_in(said, NAMES)
    assert found is not None
    assert found.names == rooms


@pytest.mark.parametrize(
    "said",
    [
        "find the cup, it isn't in the kitchen",
        "find the cup. It is not here, in the kitchen",
        "I already looked in the kitchen, find the cup",
        "I have looked for the cup in the kitchen",
        "I searched the kitchen for the cup and want it",
        "find the cup, not the one in the kitchen",
        "find another cup than the one in the kitchen",
        "find a cup other than in the kitchen",
        "find the red cup, nobody is in the kitchen",
        "find the cup, somebody is in the kitchen",
        "I can't find the cup in the kitchen",
        "find the cup that was in the kitchen",
        "find the cup in no room but in the kitchen or the bedroom, nor in the office",
        "find the cup in the kitchen, if it isn't there in the bedroom",
        "find the cup in the kitchen, otherwise in the bedroom",
        "search the kitchen for the cup and the bedroom for the book",
        "find the cup in the kitchen and the bedroom wardrobe thing",
    ],
)
def test_where_it_is_not_sure_which_rooms_are_meant_none_is(said: str) -> None:
    assert searched_in(said, NAMES) is None


def test_several_rooms_are_called_by_all_their_names_within_the_length_of_one() -> None:
    found = searched_in("find the cup in the kitchen or the bedroom", NAMES)
    assert found is not None
    assert found.name == "kitchen or bedroom"
    long = [f"room of the person called {letter * 12}" for letter in "abc"]
    found = searched_in("find the cup in " + " or ".join(long), long)
    assert found is not None
    assert len(found.names) == 3
    assert len(found.name) == 64


@pytest.mark.parametrize(
    ("said", "goal"),
    [
        ("go to the kitchen", "kitchen"),
        ("go to the hallway next to the kitchen", "hallway"),
        ("go to the kitchen next to Anna's room", "kitchen"),
        ("go to the attic next to the kitchen", None),
        ("go to the room beside the bedroom", None),
        ("go next to the kitchen", None),
        ("drive close to the lounge", None),
    ],
)
def test_a_room_that_only_tells_where_another_place_is_is_not_meant(said: str, goal: str | None) -> None:
    assert named_in(said, ("kitchen", "hallway", "bedroom", "Anna's room")) == goal
