"""What was heard, put right by ear; and what is left alone."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts.speech import HOT_WORDS_MAX
from vocabulary.hot_words import CHARACTERS_MAX, NAMES, OPENINGS, expected, hot_words, sayable
from vocabulary.sounding import HeardText, by_ear, said_once


@pytest.mark.parametrize(
    ("heard", "meant"),
    [
        ("find my black rock sack", HeardText("find my black rucksack")),
        ("When did you last see the yellow hand back?", HeardText("when did you last see the yellow handbag")),
        ("find the blew bottle", HeardText("find the blue bottle")),
        ("have you seen my big mock", HeardText("have you seen my big mug", sure=False)),
        ("can you find my water model?", HeardText("can you find my water bottle", sure=False)),
        ("find my fake toothbrush", HeardText("find my fake toothbrush", sure=False)),
        ("find the duster", HeardText("find the toaster", sure=False)),
        ("please find the bit laptop", HeardText("please find the bit laptop", sure=False)),
    ],
)
def test_a_word_that_names_nothing_is_taken_for_the_name_that_sounds_nearest(heard: str, meant: HeardText) -> None:
    assert by_ear(heard) == meant


@pytest.mark.parametrize(
    "said",
    [
        "find the red bottle", "find the ball near the table", "go to the living room please", "stop",
        "where is my phone",

        "find the red apple not the orange one", "find my keys", "bring me something to drink", "go back to the dock",
        "find the old wooden chair in the kitchen",
    ],
)  # fmt: skip
def test_what_is_known_is_left_alone(said: str) -> None:
    assert by_ear(said) == HeardText(said)


@pytest.mark.parametrize(
    ("heard", "words", "once"),
    [
        ("find my laptop, find my lap top,", 3, "find my laptop"),
        ("I'm looking for my rucksack, I'm lookin' for my rucksacks, I am looking", 5, "im looking for my rucksack"),
        ("find the red cup find the red cap", 8, "find the red cup find the red cap"),
        ("Pour me some water Pour me some water Pour", 4, "pour me some water"),
        ("find the red apple, not the orange one", 8, "find the red apple not the orange one"),
        ("find the purple, tennis racket on the table", 8, "find the purple tennis racket on the table"),
    ],
)
def test_what_a_recogniser_repeats_is_said_once(heard: str, words: int, once: str) -> None:
    assert said_once(heard, words) == once


@given(st.text(max_size=120))
def test_whatever_was_heard_can_be_put_right(heard: str) -> None:
    assert isinstance(by_ear(said_once(heard, 5)), HeardText)


def test_what_memory_holds_is_expected_first_and_no_name_is_cut() -> None:
    told = hot_words(("surfboard", "cup")).split(", ")
    first = len(OPENINGS)
    assert told[:first] == list(OPENINGS)
    assert told[first : first + 2] == ["surfboard", "cup"]
    assert len(", ".join(told)) <= CHARACTERS_MAX
    assert set(told[first:]) <= {"surfboard", *NAMES}


def test_labels_that_nobody_says_are_left_out_and_no_more_are_chosen_than_speech_takes() -> None:
    assert sayable(["red cup", "red cup", "<|startoftranscript|>", "", "tea, pot", "x" * 41]) == ["red cup"]
    assert len(sayable([f"thing {number}" for number in range(100)])) == HOT_WORDS_MAX


def test_a_name_is_expected_once_before_the_common_ones() -> None:
    told = expected(("cup", "surfboard"))
    assert told[len(OPENINGS) : len(OPENINGS) + 2] == ("cup", "surfboard")
    assert len(told) == len(set(told)) == len(OPENINGS) + len(NAMES) + 1
