"""A goal that came to nothing is told as it ended, and no reason is made up."""

import pytest

from contracts.causes import GoalCause
from contracts.geometry import Pose2D
from contracts.robot import Goal, GoalStatus
from ui.operator_actions import goal_end_in_words


def ended(**told: object) -> Goal:
    here = Pose2D(x=0.0, y=0.0, yaw=0.0)
    return Goal.model_validate({"id": "g", "pose": here, "status": GoalStatus.ABORTED, "stamp_s": 1.0, **told})


@pytest.mark.parametrize("cause", GoalCause)
def test_without_words_of_nav2_the_cause_is_told(cause: GoalCause) -> None:
    assert goal_end_in_words(ended(cause=cause)) == cause.sentence


def test_nav2s_own_words_come_first() -> None:
    assert goal_end_in_words(ended(cause=GoalCause.NAV2, error_msg="PATIENCE_EXCEEDED")) == "PATIENCE_EXCEEDED"


def test_where_nobody_said_why_nobody_is_quoted() -> None:
    assert goal_end_in_words(ended()) == "no reason given"
