"""Readings of one saying, weighed: the same goes on, different ones are asked back."""

import pytest

from contracts.intent import Intent, WantedAction
from contracts.reading import Mood
from contracts.vision import Target
from coordinator.commands.readings import HeardIntent, understood, uses_all_colours


def find(what: str, label: str, action: WantedAction = WantedAction.FIND) -> Intent:
    return Intent(
        action=action, command=f"find the {what}", targets=(Target(label=label, description=what),), mood=Mood.FIND
    )


CUP, CAP = find("blue cup", "cup"), find("blue cap", "bottle")
NOTHING = Intent(action=WantedAction.NOTHING, command="the blue", mood=Mood.UNKNOWN)
STOP = Intent(action=WantedAction.STOP, command="stop", mood=Mood.STOP)
GO_ON = Intent(action=WantedAction.RESUME, command="go on", mood=Mood.RESUME)


def heard(*intents: Intent, sure: bool = True) -> list[HeardIntent]:
    return [HeardIntent(one, sure) for one in intents]


def test_the_same_wish_goes_on() -> None:
    told = understood(heard(CUP, CUP.model_copy(update={"command": "Find the blue cup."})))
    assert (told.intent, told.question, told.choices) == (CUP, "", ())


def test_two_spellings_of_a_name_are_one_wish() -> None:
    told = understood(heard(find("donut", "donut"), find("doughnut", "donut")))
    assert told.intent == find("donut", "donut")


def test_one_sure_reading_is_enough_where_both_mean_the_same() -> None:
    told = understood([HeardIntent(CUP, sure=False), HeardIntent(CUP, sure=True)])
    assert told.intent == CUP


@pytest.mark.parametrize("sure", [True, False])
def test_different_wishes_are_asked_back_the_likeliest_first(sure: bool) -> None:
    told = understood(heard(CUP, CAP, sure=sure))
    assert told.intent is None
    assert told.question == "Did you mean: find the blue cup, or find the blue cap?"
    assert [one.intent for one in told.choices] == [CUP, CAP]


def test_another_action_with_the_same_thing_is_another_wish() -> None:
    told = understood(heard(CUP, find("blue cup", "cup", WantedAction.BRING)))
    assert [one.text for one in told.choices] == ["find the blue cup", "bring the blue cup"]


def test_what_nobody_is_sure_of_is_asked_back_though_both_read_the_same() -> None:
    told = understood(heard(CUP, CUP, sure=False))
    assert (told.intent, [one.intent for one in told.choices]) == (None, [CUP])


def test_a_reading_that_asks_for_nothing_known_is_no_choice() -> None:
    told = understood(heard(NOTHING, CUP))
    assert (told.intent, [one.intent for one in told.choices]) == (None, [CUP])


def test_nothing_is_offered_where_nothing_was_understood() -> None:
    told = understood(heard(NOTHING, CUP.model_copy(update={"targets": ()})))
    assert (told.intent, told.choices) == (None, ())
    assert "say it again" in told.question


def test_one_reading_that_says_stop_is_a_stop_but_one_that_says_go_on_is_asked_back() -> None:
    assert understood(heard(CUP, STOP)).intent == STOP
    assert understood(heard(GO_ON, CUP)).intent is None


@pytest.mark.parametrize(
    ("command", "uses"),
    [
        ("find the red cup", True),
        ("find the red cup at the green one", False),
        ("find the red cup not the blue one", True),
    ],
)
def test_a_colour_that_is_left_over_tells_that_a_word_was_lost(command: str, uses: bool) -> None:
    target = Target.model_validate({"label": "cup", "description": "red cup", "not_colours": ("blue",)})
    assert (
        uses_all_colours(Intent(action=WantedAction.FIND, command=command, targets=(target,), mood=Mood.FIND)) is uses
    )
