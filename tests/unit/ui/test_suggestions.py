"""What the command box offers."""

from contracts.memory import LabelCount
from support.ui_world import thing
from ui.latest_facts import Remembered
from ui.suggestions import is_question, suggestions


def test_what_is_remembered_comes_first_and_everything_once() -> None:
    count = LabelCount(label="cup", views=1, best_confidence=0.5, last_seen_s=1.0)
    offered = suggestions(Remembered(labels=(count,), objects=(thing(1), thing(2, "blue cup", belief=0.9))))
    assert offered[:3] == ("find the blue cup", "find the red bottle", "find the cup")
    assert len(set(offered)) == len(offered)
    assert "find the refrigerator" in offered
    assert "find the person" not in offered


def test_a_question_ends_like_one() -> None:
    assert is_question("where did you last see my keys? ")
    assert is_question("how many bottles have you seen")
    assert not is_question("find the red bottle")
