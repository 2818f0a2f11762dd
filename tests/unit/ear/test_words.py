"""What is said and read: answers to a question, endings of missions, the wake word left out, quiet hours."""

from datetime import time
from typing import Any

import pytest

from contracts.intent import Choice, Intent, Understood, WantedAction
from contracts.mission import EndCause, Mission, MissionKind, MissionState, Outcome, Report
from contracts.reading import Mood
from contracts.vision import Target
from ear import words
from ear.choices import Neither, chosen
from ear.quiet_hours import QuietHours


def choice(said: str) -> Choice:
    return Choice(text=said, intent=Intent(action=WantedAction.FIND, command=said, mood=Mood.FIND))


CUP, CAP = choice("find the blue cup"), choice("find the blue cap")


@pytest.mark.parametrize(
    ("readings", "meant"),
    [
        (("the cup",), CUP),
        (("The blue cap, please.",), CAP),
        (("find the blue cap",), CAP),
        (("the first one",), CUP),
        (("two",), CAP),
        (("cup", "cap"), None),
        (("cup", "the"), CUP),
        (("the second one",), CAP),
        (("The second one, please.",), CAP),
        (("the last one",), CAP),
        (("number one",), CUP),
        (("One.",), CUP),
        (("um, one",), CUP),
        (("the blue one",), None),
        (("wait a second",), None),
        (("the third one",), None),
        (("the blue one and the cap and the cup",), None),
        (("not the cup",), CAP),
        (("It is not the cup.",), CAP),
        (("not the first one",), CAP),
        (("not the cup, the cap",), CAP),
        (("not the cup but the cap",), CAP),
        (("No, the cap.",), CAP),
        (("no the cap",), CAP),
        (("the cap, not the cup",), CAP),
        (("no cup",), None),
        (("the cup, no, not the cup",), None),
        (("not the cup, find the bottle",), None),
        (("not the cup", "the cup"), None),
        (("no one",), Neither.SAID),
        (("No one.", "No, one."), None),
        (("not one",), Neither.SAID),
        (("neither one",), Neither.SAID),
        (("neither the cup nor the cap",), Neither.SAID),
        (("none of the two",), Neither.SAID),
        (("not the cup and not the cap",), Neither.SAID),
        (("don't find the cup",), Neither.SAID),
        (("not that",), Neither.SAID),
        (("neither",), Neither.SAID),
        (("No.",), Neither.SAID),
        (("the blue",), None),
        (("find the bottle",), None),
        ((), None),
    ],
)
def test_an_answer_means_the_choice_it_names(readings: tuple[str, ...], meant: object) -> None:
    assert chosen((CUP, CAP), readings) == meant


def test_yes_means_the_only_choice() -> None:
    assert chosen((CUP,), ("yes",)) == CUP
    assert chosen((CUP,), ("no",)) == Neither.SAID
    assert chosen((CUP, CAP), ("yes",)) is None
    assert chosen((CUP,), ("Okay.",)) == CUP
    assert chosen((CUP,), ("not the cup",)) == Neither.SAID
    assert chosen((CUP,), ("no one",)) == Neither.SAID
    assert chosen((CUP,), ("the red one",)) is None


def test_of_three_that_are_left_none_is_guessed() -> None:
    can = choice("find the blue can")
    assert chosen((CUP, CAP, can), ("not the cup",)) == Neither.SAID
    assert chosen((CUP, CAP, can), ("the last one",)) == can
    assert chosen((CUP, CAP, can), ("three",)) == can


@pytest.mark.parametrize(
    ("said", "left"),
    [
        ("Hey Jarvis, find the red bottle.", ("find the red bottle.",)),
        ("Jarvis find the cup", ("find the cup",)),
        ("find the cup", ("find the cup",)),
        ("Ok Naboo, find the cup", ("find the cup",)),
        ("Hey, Jarvis.", ()),
        ("", ()),
        ("...", ()),
        ("find the\x07 cup", ("find the  cup",)),
    ],
)
def test_the_word_that_woke_it_is_left_out(said: str, left: tuple[str, ...]) -> None:
    assert words.readings_of(said) == left


def test_readings_are_told_once() -> None:
    assert words.readings_of("find the cup", "find the cup") == ("find the cup",)


def mission(outcome: Outcome, **more: Any) -> Mission:
    told: dict[str, Any] = {
        "id": "m1",
        "command": "find the red bottle",
        "target": Target(label="bottle", colour="red", description="red bottle"),
        "state": MissionState.IDLE,
        "started_s": 1.0,
        "outcome": outcome,
    }
    return Mission(**(told | more))


@pytest.mark.parametrize(
    ("ended", "sentence"),
    [
        (mission(Outcome.FOUND), "I found the red bottle."),
        (mission(Outcome.NOT_FOUND), "I did not find the red bottle."),
        (mission(Outcome.UNSURE), "I am not sure whether I found the red bottle."),
        (mission(Outcome.ABORTED), "I gave up on the red bottle."),
        (mission(Outcome.DOCKED, kind=MissionKind.DOCK, target=None), "I am on my dock."),
        (mission(Outcome.ABORTED, kind=MissionKind.DOCK, target=None), "I did not get onto my dock."),
        (mission(Outcome.CANCELED), ""),
        (mission(Outcome.INTERRUPTED), ""),
        (mission(Outcome.ABORTED, report=Report(text="stopped", ended_by=EndCause.STOPPED)), ""),
    ],
)
def test_an_ending_is_one_short_sentence(ended: Mission, sentence: str) -> None:
    assert words.ending(ended) == sentence


def test_every_outcome_has_its_sentence_or_none_on_purpose() -> None:
    assert {one for one in Outcome if not words.ending(mission(one))} == {Outcome.CANCELED, Outcome.INTERRUPTED}


def test_a_long_answer_is_cut_at_the_end_of_a_sentence() -> None:
    told = words.short("The cup stands in the kitchen, on the table by the window. " + "It was seen there. " * 20)
    assert len(told) <= words.SENTENCE_CHARACTERS_MAX
    assert told.endswith("seen there.")
    assert words.short("word " * 100).endswith("word.")


def test_a_question_without_choices_is_asked_as_it_is() -> None:
    assert words.question(Understood(question="Which room?"), again=True) == "Which room?"


@pytest.mark.parametrize(
    ("written", "now", "quiet"),
    [
        ("22:00-07:00", time(23, 0), True),
        ("22:00-07:00", time(6, 59, 59), True),
        ("22:00-07:00", time(7, 0), False),
        ("22:00-07:00", time(21, 59), False),
        ("13:00-15:00", time(14, 0), True),
        ("13:00-15:00", time(15, 0), False),
        ("00:00-00:00", time(12, 0), True),
    ],
)
def test_quiet_hours_go_over_midnight(written: str, now: time, quiet: bool) -> None:
    hours = QuietHours.read(written)
    assert hours is not None
    assert hours.covers(now) is quiet


@pytest.mark.parametrize("written", ["22-7", "24:00-07:00", "22:00", "22:00-07:60", "at night"])
def test_what_is_no_stretch_of_the_day_is_refused(written: str) -> None:
    with pytest.raises(ValueError, match="write it as"):
        QuietHours.read(written)


def test_nothing_written_means_no_quiet_hours() -> None:
    assert QuietHours.read(" ") is None
