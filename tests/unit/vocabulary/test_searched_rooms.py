"""Where a command says to look: a room of the home, by its name or kind; or one that nobody knows."""

import pytest

from vocabulary.rooms import may_say_where, searched_in

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
