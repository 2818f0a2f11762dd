"""What each end of a motion does in each state: the table, and that nothing but an arrival or an obstacle is a find."""

from collections.abc import Callable

import pytest

from contracts.geometry import Pose2D
from contracts.mission import MissionState, Outcome
from contracts.motion import MotionEnd
from contracts.robot import GoalStatus
from contracts.vision import Verdict
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core.activities import Driving, Rotating, Steering, Waiting
from coordinator.core.reactions import REACTIONS, Reaction
from support.mission_script import Script, box

E, S = MotionEnd, MissionState

ARRIVALS = {E.COMPLETED, E.BLOCKED}
CANNOT_MOVE = sorted(set(MotionEnd) - ARRIVALS - {E.TIMED_OUT})
"""Ends that say nothing about what is ahead: by none of them is anything found."""


def approaching(**rules: object) -> Script:
    return Script(**rules).begin().centred().measured(1.2, 3).voted(Verdict.YES)


def scanning() -> Script:
    return Script().begin().see()


def centering() -> Script:
    return Script().begin().see(box(60)).see(box(60))


def stepping() -> Script:
    return Script().begin().centred().measured(2.8).unreachable()


def facing() -> Script:
    """It stands before the thing, and turns to it."""
    script = approaching()
    goal = script.last(do.Navigate).candidates[0].pose
    script.robot(goal.model_copy(update={"yaw": goal.yaw + 0.5}))
    return script.feed(ev.GoalEnded(script.last(do.Navigate).call, GoalStatus.SUCCEEDED))


def driving() -> Script:
    return approaching().arrived().wait(3.0)


MOVING: dict[str, tuple[Callable[[], Script], MissionState]] = {
    "scanning": (scanning, S.SCANNING),
    "centering": (centering, S.CENTERING),
    "one step": (stepping, S.DRIVING_1M),
    "turning to it": (facing, S.APPROACHING),
    "driving up to it": (driving, S.APPROACHING),
}


def end_motion(script: Script, end: MotionEnd) -> Script:
    return script.feed(ev.MotionEnded(script.mission.activity.call, end, text=end.sentence))


@pytest.mark.parametrize("end", MotionEnd)
@pytest.mark.parametrize("state", MissionState)
def test_every_end_has_a_reaction_in_every_state(state: MissionState, end: MotionEnd) -> None:
    assert isinstance(REACTIONS[state][end], Reaction)


@pytest.mark.parametrize("end", MotionEnd)
@pytest.mark.parametrize("where", MOVING)
def test_each_end_does_in_each_state_what_the_table_says(where: str, end: MotionEnd) -> None:
    begin, state = MOVING[where]
    script = begin()
    assert script.mission.state is state
    assert isinstance(script.mission.activity, Rotating | Driving)
    before = len(script.asked(do.StopMotion))
    end_motion(script, end)
    mission = script.mission
    seen = {
        Reaction.PAUSE: mission.paused and len(script.asked(do.StopMotion)) == before + 1,
        Reaction.REPEAT: isinstance(mission.activity, Waiting) and mission.state is state,
        Reaction.SET_ASIDE: mission.state is S.SCANNING and mission.candidate is None,
        Reaction.GO_ON: not mission.paused and not isinstance(mission.activity, Waiting),
        Reaction.AS_NEAR_AS_IT_GETS: mission.state is S.APPROACHING and not isinstance(mission.activity, Waiting),
    }
    assert seen[REACTIONS[state][end]]
    assert mission.running


@pytest.mark.parametrize("end", CANNOT_MOVE)
@pytest.mark.parametrize("where", ["turning to it", "driving up to it"])
def test_a_robot_that_cannot_drive_has_found_nothing_by_that(where: str, end: MotionEnd) -> None:
    script = end_motion(MOVING[where][0](), end).wait(60.0)
    assert script.mission.outcome is not Outcome.FOUND
    assert not script.asked(do.Celebrate)


def test_time_that_is_up_half_a_metre_short_is_no_find_however_often() -> None:
    script = driving()
    for _ in range(3):
        script.drove(E.TIMED_OUT, moved=0.01).wait(3.0)
    assert script.mission.state is S.SCANNING
    assert "could not be driven up to" in script.said()
    assert not script.asked(do.Celebrate)


def test_an_obstacle_half_a_metre_short_is_as_near_as_the_map_allows() -> None:
    script = approaching(alternatives_max=0).arrived().wait(3.0).drove(E.BLOCKED, moved=0.02).wait(3.0)
    assert script.mission.outcome is Outcome.FOUND


def again(script: Script) -> Script:
    return script.arrived().wait(3.0)


@pytest.mark.parametrize("end", [E.NO_SCAN, E.PREEMPTED, E.BASE_BUSY, E.SESSION_ENDED])
def test_what_keeps_cutting_it_off_ends_the_mission_with_the_cause(end: MotionEnd) -> None:
    script = driving()
    for _ in range(script.mission.rules.failures_max):
        again(end_motion(script, end).wait(10.5))
    assert script.mission.outcome is Outcome.ABORTED
    assert end.sentence in script.mission.reason


@pytest.mark.parametrize("where", MOVING)
def test_a_robot_that_was_carried_waits_for_a_person_and_forgets_where_the_thing_was(where: str) -> None:
    script = end_motion(MOVING[where][0](), E.LIFTED).wait(5.0)
    asked = len(script.asked(do.Rotate)) + len(script.asked(do.Drive)) + len(script.asked(do.Navigate))
    assert script.mission.paused
    assert "a wheel hangs in the air" in script.mission.progress
    assert script.mission.candidate is None or script.mission.candidate.map_xy is None
    script.wait(script.mission.rules.pause_timeout_s)
    assert script.mission.outcome is Outcome.ABORTED
    assert "a wheel hangs in the air" in script.mission.reason
    assert asked == len(script.asked(do.Rotate)) + len(script.asked(do.Drive)) + len(script.asked(do.Navigate))


def on_the_way() -> Script:
    return Script().begin(Pose2D(x=3.0, y=0.0, yaw=0.0))


def judging() -> Script:
    return Script().begin().centred()


@pytest.mark.parametrize("begin", [on_the_way, judging, scanning, centering, stepping, driving])
def test_a_wheel_in_the_air_for_a_second_pauses_whatever_it_is_at(begin: Callable[[], Script]) -> None:
    script = begin()
    held(script, 0.9)
    assert not script.mission.paused
    assert held(script, 0.3).mission.paused
    script.feed(ev.ResumeRequested())
    assert not script.mission.paused
    assert held(script, 0.1).mission.paused


def held(script: Script, seconds: float) -> Script:
    """Up in the air for so long."""
    for _ in range(round(seconds * 10) + 1):
        pose = script.mission.robot.pose
        script.feed(ev.RobotUpdated(script.now_s, pose, pose, False, 0.0, False, 0, lifted=True))
        script.now_s += 0.1
    return script


@pytest.mark.parametrize(
    ("held_by", "outcome"),
    [(E.BLOCKED, Outcome.FOUND), (E.LIFTED, None), (E.BLIND, None), (E.HAZARD, None), (E.HELD_BACK, None)],
)
def test_by_the_plain_rule_too_only_an_obstacle_ends_the_approach_as_a_find(
    held_by: MotionEnd, outcome: Outcome | None
) -> None:
    script = approaching(approach_rule="straight")
    assert isinstance(script.mission.activity, Steering)
    script.feed(ev.LeaseAnswered(held_by)).wait(3.3)
    assert script.mission.outcome is outcome
