"""The colour of a target: one rule, for what is parsed now and for what was written down before."""

import pytest

from contracts.colours import COLOUR_WORDS, Colour
from contracts.vision import Target


@pytest.mark.parametrize(("word", "colour"), [("gray", Colour.GREY), ("violet", Colour.PURPLE), ("red", Colour.RED)])
def test_a_colour_is_known_in_each_of_its_spellings(word: str, colour: Colour) -> None:
    assert Colour(word) is COLOUR_WORDS[word] is colour
    assert word in colour.spellings


@pytest.mark.parametrize(
    ("description", "label", "colour"),
    [
        ("Red bottle", "bottle", Colour.RED),
        ("gray cup", "cup", Colour.GREY),
        ("red or gray cup", "cup", Colour.RED),
        ("orange cup", "cup", Colour.ORANGE),
        ("orange", "orange", None),
        ("ripe oranges", "orange", None),
        ("orange orange", "orange", Colour.ORANGE),
        ("green orange", "orange", Colour.GREEN),
        ("the reddish one", "cup", None),
        ("a bored hundred", "cup", None),
    ],
)
def test_the_first_colour_word_is_the_colour_and_a_fruit_is_none(
    description: str, label: str, colour: Colour | None
) -> None:
    assert Target(label=label, description=description).colour is colour


def test_a_target_written_down_without_its_colour_gets_it_when_it_is_read() -> None:
    before = '{"label": "cup", "description": "gray cup", "not_colours": ["violet"]}'
    target = Target.model_validate_json(before)
    assert (target.colour, target.not_colours) == (Colour.GREY, (Colour.PURPLE,))


def test_a_target_of_no_colour_stays_one() -> None:
    plain = Target(label="bottle", description="red bottle", colour=None)
    assert Target.model_validate_json(plain.model_dump_json()).colour is None


@pytest.mark.parametrize(("label", "colour", "fits"), [
    ("bottle", Colour.RED, True), ("bottle", None, True), ("bottle", Colour.BLUE, False), ("cup", Colour.RED, False),
])  # fmt: skip
def test_an_unknown_colour_disagrees_with_nothing(label: str, colour: Colour | None, fits: bool) -> None:
    assert Target(label="bottle", description="red bottle").may_be(label, colour) is fits


def test_an_excluded_colour_disagrees() -> None:
    wanted = Target(label="bottle", description="bottle", not_colours=(Colour.BLUE,))
    assert wanted.may_be("bottle", Colour.RED)
    assert not wanted.may_be("bottle", "blue")
