"""What is to be done with a thing, by the words that ask for it."""

import pytest

from contracts.intent import WantedAction
from vocabulary.actions import action_in, is_docking


@pytest.mark.parametrize(
    ("said", "action"),
    [
        ("find the red bottle", WantedAction.FIND),
        ("the red bottle", WantedAction.FIND),
        ("where is my phone", WantedAction.FIND),
        ("bring me an apple", WantedAction.BRING),
        ("Could you please FETCH the scissors?", WantedAction.BRING),
        ("get me the cup", WantedAction.BRING),
        ("give me the blue cup", WantedAction.BRING),
        ("find the cup and bring it to me", WantedAction.BRING),
        ("get to the kitchen", WantedAction.FIND),
        ("pour the medicine", WantedAction.POUR),
        ("pour me a glass of water", WantedAction.POUR),
        ("bring the thing one pours espresso into", WantedAction.BRING),
        ("find something to pour water into", WantedAction.FIND),
        ("it's pouring outside", WantedAction.FIND),
        ("go to the kitchen", WantedAction.GO),
        ("drive back to the couch", WantedAction.GO),
        ("take me to the sink", WantedAction.GO),
        ("go to the kitchen and find the red cup", WantedAction.FIND),
    ],
)
def test_the_wanted_action_is_read_from_the_words(said: str, action: WantedAction) -> None:
    assert action_in(said) is action


@pytest.mark.parametrize(
    "said",
    ["dock", "go to the dock", "Go home!", "please go back to your charger", "return to the dock now", "go charge"],
)
def test_the_way_to_the_dock_is_known(said: str) -> None:
    assert is_docking(said)


@pytest.mark.parametrize(
    "said", ["", "find the dock", "go charge yourself", "go to the kitchen", "find my phone charger"]
)
def test_what_names_more_than_the_dock_is_no_docking(said: str) -> None:
    assert not is_docking(said)
