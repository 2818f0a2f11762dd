"""When a speaker is done, whether two readings agree, and which hot words fit."""

import pytest

from speech.end_of_speech import ALLOWED, Listening, Turn, step
from speech.readings import agree, fitting


def after(*stretches: tuple[float, float]) -> Turn:
    """The turn after stretches of (how likely speech is, seconds), in windows of 0.1 s."""
    listening = Listening()
    for probability, length_s in stretches:
        for _ in range(round(length_s * 10)):
            listening = step(listening, probability, 0.1)
    return listening.turn


def test_the_table_names_every_turn() -> None:
    assert set(ALLOWED) == set(Turn)


@pytest.mark.parametrize(
    ("stretches", "turn"),
    [
        ([(0.0, 2.0)], Turn.WAITING),
        ([(0.0, 8.1)], Turn.NOBODY),
        ([(0.0, 1.0), (0.9, 0.5)], Turn.SPEAKING),
        ([(0.9, 0.5), (0.1, 0.5)], Turn.SPEAKING),
        ([(0.9, 0.5), (0.1, 0.5), (0.9, 0.5), (0.1, 0.5)], Turn.SPEAKING),
        ([(0.9, 0.5), (0.1, 0.8)], Turn.DONE),
        ([(0.9, 0.5), (0.1, 0.8), (0.9, 2.0)], Turn.DONE),
    ],
)
def test_a_pause_ends_a_turn_and_a_breath_does_not(stretches: list[tuple[float, float]], turn: Turn) -> None:
    assert after(*stretches) is turn


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("Find the red bottle.", "find the red bottle,", True),
        ("Where's my cup?", "wheres my cup", True),
        ("the blue cup", "the blue cap", False),
        ("", "", True),
        ("stop", "stop stop", False),
    ],
)
def test_readings_agree_where_their_words_do(one: str, other: str, same: bool) -> None:
    assert agree(one, other) is same


def test_hot_words_are_the_first_that_fit_each_once_and_whole() -> None:
    assert fitting(["cup", "teddy bear", "cup", "vase"], len, tokens_max=20) == "cup, teddy bear"
