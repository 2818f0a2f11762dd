"""When a speaker is done, whether two readings agree, and which hot words fit."""

import pytest

from speech.end_of_speech import ALLOWED, PAUSES_S, Listening, Turn, due, step
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


def test_while_the_button_is_held_no_silence_is_an_end_and_let_go_it_is_one() -> None:
    listening = Listening()
    for probability in [*[0.0] * 90, *[0.9] * 5, *[0.0] * 20]:
        listening = step(listening, probability, 0.1, held=True)
    assert listening.turn is Turn.SPEAKING
    assert step(listening, 0.0, 0.1).turn is Turn.DONE
    waiting = Listening()
    for _ in range(90):
        waiting = step(waiting, 0.0, 0.1, held=True)
    assert waiting.turn is Turn.WAITING
    assert step(waiting, 0.0, 0.1).turn is Turn.NOBODY


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


def reads(*stretches: tuple[float, float], period_s: float = 0.5) -> list[float]:
    """Where it is read, in seconds, over stretches of (how likely speech is, seconds), in windows of 20 ms."""
    listening, read_s, told = Listening(), None, list[float]()
    for probability, length_s in stretches:
        for _ in range(round(length_s / 0.02)):
            listening = step(listening, probability, 0.02)
            if due(listening, read_s, period_s):
                read_s = listening.heard_s
                told.append(round(read_s, 2))
    return told


def test_one_word_is_read_as_soon_as_it_may_have_ended() -> None:
    assert reads((0.0, 1.0), (0.9, 0.3), (0.0, 0.5)) == [round(1.3 + one, 2) for one in PAUSES_S]


def test_who_goes_on_speaking_is_read_each_period() -> None:
    assert reads((0.9, 1.6)) == [0.5, 1.0, 1.5]


def test_each_pause_is_read_a_long_one_twice() -> None:
    assert reads((0.9, 0.2), (0.0, 0.3), (0.9, 0.2), (0.0, 0.6), period_s=5.0) == [0.36, 0.86, 1.1]


def test_nothing_is_read_before_somebody_speaks() -> None:
    assert reads((0.1, 3.0)) == []
