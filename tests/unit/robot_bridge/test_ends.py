"""How a motion ends that is held back: by what was sent last, whatever else was changed about it."""

import pytest

from contracts.causes import GoalCause, LimitCause, SafetyCause
from contracts.geometry import Twist2D
from contracts.motion import BaseEnd, Hazard, MotionEnd
from robot_bridge.motion.arbiter import NO_COMMAND, STOPPED, ZERO, ArbitratedCommand
from robot_bridge.motion.motion_executor import held_by
from robot_bridge.motion.words import restraint_in_words
from robot_bridge.safety.collision_monitor import Restraint

ASKED = Twist2D(linear_x=0.2)


def choice(*causes: Restraint | LimitCause, source: str = "drive") -> ArbitratedCommand:
    return ArbitratedCommand(ZERO, source, ASKED, causes)


@pytest.mark.parametrize("cause", [cause for cause in SafetyCause if cause is not SafetyCause.SLOWED])
def test_what_stops_it_ends_it_also_behind_what_only_changed_it(cause: SafetyCause) -> None:
    restraint = Restraint(cause, hazards=frozenset({Hazard.CLIFF}))
    held = held_by(choice(Restraint(SafetyCause.SLOWED), LimitCause.ACCELERATION, restraint), "drive")
    assert held.end is cause.ends_as
    assert held.text == restraint_in_words(restraint)
    assert held.hazards == {Hazard.CLIFF}


@pytest.mark.parametrize(
    ("last", "end"),
    [
        (None, MotionEnd.HELD_BACK),
        (NO_COMMAND, MotionEnd.HELD_BACK),
        (STOPPED, MotionEnd.STOPPED),
        (choice(source="teleop"), MotionEnd.PREEMPTED),
        (choice(Restraint(SafetyCause.OBSTACLE), source="teleop"), MotionEnd.PREEMPTED),
        (choice(), MotionEnd.HELD_BACK),
        (choice(LimitCause.SPEED), MotionEnd.HELD_BACK),
        (choice(Restraint(SafetyCause.SLOWED)), MotionEnd.HELD_BACK),
    ],
)
def test_what_says_nothing_about_the_way_is_no_obstacle(last: ArbitratedCommand | None, end: MotionEnd) -> None:
    assert held_by(last, "drive").end is end


def test_only_slowing_down_ends_nothing() -> None:
    assert [cause for cause in SafetyCause if cause.ends_as is None] == [SafetyCause.SLOWED]


@pytest.mark.parametrize("member", [*MotionEnd, *GoalCause, *BaseEnd, *LimitCause])
def test_every_member_has_its_sentence(member: MotionEnd | GoalCause | BaseEnd | LimitCause) -> None:
    done = member in {MotionEnd.COMPLETED, BaseEnd.COMPLETED}
    assert bool(member.sentence) is not done


@pytest.mark.parametrize("cause", SafetyCause)
@pytest.mark.parametrize("forward", [True, False])
def test_every_restraint_can_be_told(cause: SafetyCause, forward: bool) -> None:
    assert restraint_in_words(Restraint(cause, forward=forward))
