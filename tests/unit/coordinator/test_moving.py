"""MOVING: plain motions, leg by leg."""

import math
from itertools import pairwise

import pytest

from contracts.geometry import Pose2D
from contracts.mission import EndCause, MissionKind, MissionState, Outcome
from contracts.motion import MotionEnd
from contracts.robot import GoalStatus
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core import recording
from coordinator.core.activities import Driving, Paused, Waiting
from coordinator.core.motions import Leg, PlaceLeg, PlainMotion, RoundLeg, StraightLeg, TurnLeg
from support.mission_script import ORIGIN, Script, box


def moving(*legs: Leg, limit_s: float | None = None, docked: bool = False, **rules: object) -> Script:
    script = Script(**rules)
    script.robot(docked=docked)
    return script.feed(ev.MotionStarted("m1", "as asked", PlainMotion("as asked", legs, limit_s=limit_s)))


def kitchen(*, may_miss: bool = False) -> PlaceLeg:
    return PlaceLeg(3.0, 4.0, None, "the kitchen", may_miss)


def ended(script: Script) -> tuple[Outcome | None, EndCause | None]:
    report = script.mission.report
    assert report is not None
    return script.mission.outcome, report.ended_by


def test_a_turn_is_done_in_steps_of_one_direction_and_ends_as_done() -> None:
    script = moving(TurnLeg(-4.0))
    assert script.mission.kind is MissionKind.MOVE
    while script.mission.running:
        script.turned()
    turns = [action.angle_rad for action in script.asked(do.Rotate)]
    assert sum(turns) == pytest.approx(-4.0)
    assert all(-2.5 <= turn < 0.0 for turn in turns)
    assert ended(script) == (Outcome.DONE, None)
    assert script.states[-2:] == [MissionState.MOVING, MissionState.IDLE]


def test_a_paused_turn_goes_on_to_the_heading_it_was_to_end_at() -> None:
    script = moving(TurnLeg(1.0))
    script.robot(Pose2D(x=0.0, y=0.0, yaw=0.4)).feed(ev.PauseRequested())
    assert isinstance(script.mission.activity, Paused)
    assert script.asked(do.StopMotion)
    script.feed(ev.ResumeRequested())
    assert script.last(do.Rotate).angle_rad == pytest.approx(0.6)


def test_the_next_step_of_a_turn_waits_for_no_news_of_the_heading() -> None:
    script = moving(TurnLeg(4.0))
    script.feed(ev.MotionEnded(script.last(do.Rotate).call, MotionEnd.COMPLETED, turned_rad=2.0))
    assert script.last(do.Rotate).angle_rad == pytest.approx(2.0)
    script.feed(ev.MotionEnded(script.last(do.Rotate).call, MotionEnd.COMPLETED, turned_rad=2.0))
    assert ended(script) == (Outcome.DONE, None)


def test_a_turn_that_ends_within_what_a_turn_is_off_by_is_done() -> None:
    """robot_bridge calls a turn done at 0.02 rad: what is left then cannot be turned."""
    script = moving(TurnLeg(-1.0))
    script.feed(ev.MotionEnded(script.last(do.Rotate).call, MotionEnd.COMPLETED, turned_rad=-0.981))
    assert ended(script) == (Outcome.DONE, None)
    assert len(script.asked(do.Rotate)) == 1


def test_a_drive_is_not_taken_up_again_in_another_direction() -> None:
    script = moving(StraightLeg(2.0))
    script.robot(Pose2D(x=0.7, y=0.0, yaw=0.0)).feed(ev.PauseRequested())
    script.robot(Pose2D(x=0.7, y=0.0, yaw=1.2)).feed(ev.ResumeRequested())
    assert ended(script) == (Outcome.ABORTED, EndCause.CANNOT_MOVE)
    assert "driven 0.70 m of 2.00 m" in script.mission.reason
    assert len(script.asked(do.Drive)) == 1


def test_a_drive_counts_what_was_driven_before_a_pause() -> None:
    script = moving(StraightLeg(1.0))
    assert script.last(do.Drive).distance_m == pytest.approx(1.0)
    script.robot(Pose2D(x=0.7, y=0.0, yaw=0.0)).feed(ev.PauseRequested()).feed(ev.ResumeRequested())
    assert script.last(do.Drive).distance_m == pytest.approx(0.3)
    script.drove()
    assert ended(script) == (Outcome.DONE, None)


@pytest.mark.parametrize(
    "end", [MotionEnd.BLOCKED, MotionEnd.HAZARD, MotionEnd.BLIND, MotionEnd.TIMED_OUT, MotionEnd.PREEMPTED]
)
def test_what_stands_in_the_way_ends_a_drive_and_is_told(end: MotionEnd) -> None:
    script = moving(StraightLeg(1.0)).drove(end, moved=0.4)
    assert ended(script) == (Outcome.ABORTED, EndCause.CANNOT_MOVE)
    assert "driven 0.40 m of 1.00 m" in script.mission.reason
    assert len(script.asked(do.Drive)) == 1


def test_a_lifted_robot_pauses() -> None:
    script = moving(StraightLeg(1.0)).drove(MotionEnd.LIFTED, moved=0.2)
    assert script.mission.paused


def test_a_motion_begins_off_the_dock() -> None:
    script = moving(StraightLeg(0.5), docked=True)
    assert script.asked(do.Undock)
    assert not script.asked(do.Drive)
    script.robot().feed(ev.Undocked(script.last(do.Undock).call)).see()
    assert script.asked(do.Drive)


def test_undocking_alone_is_done_off_the_dock() -> None:
    script = moving(docked=True)
    script.robot().feed(ev.Undocked(script.last(do.Undock).call)).see()
    assert ended(script) == (Outcome.DONE, None)
    assert ended(moving()) == (Outcome.DONE, None)


def test_a_look_round_is_one_turn_with_a_look_at_each_stop() -> None:
    script = moving(RoundLeg())
    while script.mission.running:
        script.see(box(label="chair")) if script.asked(do.Rotate) == [] else script.turned().see(box(label="chair"))
    looks = script.asked(do.RecordLook)
    assert len(looks) == math.ceil(math.tau / 0.7331)
    headings = sorted(look.pose.yaw % math.tau for look in looks)
    assert max(b - a for a, b in pairwise(headings)) < 0.8
    assert ended(script) == (Outcome.DONE, None)
    assert [one.label for one in script.mission.search.other_objects] == ["chair"]
    assert "seen: red chair" in script.mission.reason


def test_without_pictures_a_look_round_ends_with_the_cause() -> None:
    script = moving(RoundLeg(), blind_looks_max=2).wait(12.0)
    assert ended(script) == (Outcome.ABORTED, EndCause.NO_PICTURES)


def test_it_drives_to_a_place_facing_as_it_came() -> None:
    script = moving(kitchen())
    goal = script.last(do.Navigate).candidates[0].pose
    assert (goal.x, goal.y) == (3.0, 4.0)
    assert goal.yaw == pytest.approx(math.atan2(4.0, 3.0))
    script.arrived()
    assert ended(script) == (Outcome.DONE, None)


def test_a_place_that_cannot_be_reached_ends_it() -> None:
    script = moving(kitchen()).unreachable()
    assert ended(script) == (Outcome.ABORTED, EndCause.NAVIGATION)
    assert "the kitchen could not be reached" in script.mission.reason


def test_a_goal_that_was_given_up_is_tried_once_more() -> None:
    script = moving(kitchen())
    script.feed(ev.GoalEnded(script.last(do.Navigate).call, GoalStatus.ABORTED, 1))
    assert isinstance(script.mission.activity, Waiting)
    script.wait(3.0)
    assert len(script.asked(do.Navigate)) == 2
    script.feed(ev.GoalEnded(script.last(do.Navigate).call, GoalStatus.ABORTED, 1))
    assert ended(script) == (Outcome.ABORTED, EndCause.NAVIGATION)


def test_a_navigation_that_refuses_again_and_again_ends_it() -> None:
    script = moving(kitchen(), failures_max=3)
    for _ in range(3):
        script.feed(ev.GoalEnded(script.last(do.Navigate).call, GoalStatus.REJECTED)).wait(11.0)
    assert ended(script) == (Outcome.ABORTED, EndCause.NAVIGATION)


def test_a_tour_goes_on_without_a_room_it_cannot_reach() -> None:
    hall = PlaceLeg(1.0, 0.0, None, "the hall", may_miss=True)
    script = moving(kitchen(may_miss=True), RoundLeg(), hall, TurnLeg(1.0)).unreachable()
    assert script.last(do.Navigate).candidates[0].pose.x == 1.0
    script.arrived().turned()
    assert ended(script) == (Outcome.DONE, None)
    assert "could not reach the kitchen" in script.mission.reason
    report = script.mission.report
    assert report is not None
    assert (report.places_looked, report.places_unreachable) == (1, 1)


def test_a_tour_of_which_no_room_is_reached_is_not_done() -> None:
    script = moving(kitchen(may_miss=True), RoundLeg()).unreachable()
    assert ended(script) == (Outcome.ABORTED, EndCause.NAVIGATION)


def test_its_own_limit_ends_it() -> None:
    script = moving(StraightLeg(1.0), limit_s=4.0).wait(5.0)
    assert ended(script) == (Outcome.ABORTED, EndCause.TIME_UP)
    assert "4 s" in script.mission.reason


def test_a_stop_ends_it_and_nothing_goes_on_after_the_reset() -> None:
    script = moving(StraightLeg(1.0)).feed(ev.StopLatched(1, "pressed"))
    assert ended(script) == (Outcome.ABORTED, EndCause.STOPPED)
    asked = len(script.asked(do.Drive))
    script.feed(ev.StopReset(1)).wait(2.0)
    assert (script.mission.state, len(script.asked(do.Drive))) == (MissionState.IDLE, asked)


def test_nothing_begins_while_stopped() -> None:
    script = Script().feed(ev.StopLatched(1, "pressed"))
    script.feed(ev.MotionStarted("m1", "drive", PlainMotion("drive", (StraightLeg(1.0),))))
    assert script.mission.state is MissionState.EMERGENCY_STOP
    assert not script.asked(do.Drive)


def test_cancelling_stops_it() -> None:
    script = moving(StraightLeg(1.0)).feed(ev.CancelRequested())
    assert ended(script) == (Outcome.CANCELED, EndCause.PERSON)
    assert isinstance(script.actions[-2], do.StopMotion) or script.asked(do.StopMotion)
    assert not isinstance(script.mission.activity, Driving)


def test_a_recorded_motion_decides_the_same_again() -> None:
    script = Script()
    header = recording.header_of(script.mission, "m1", script.now_s)
    lines = [recording.header_line(header)]
    legs = (TurnLeg(2.0), StraightLeg(0.5), kitchen(may_miss=True), RoundLeg())
    started = ev.MotionStarted("m1", "as asked", PlainMotion("as asked", legs))
    for event in (started, ev.MotionEnded(1, MotionEnd.COMPLETED)):
        before = len(script.actions)
        script.feed(event)
        taken = recording.Step(script.now_s, event, tuple(script.actions[before:]), script.mission.state)
        lines.append(recording.step_line(taken))
    again = list(recording.replay(recording.read(lines)))
    assert [one.same for one in again] == [True, True]
    assert again[-1].after.motion == script.mission.motion
    assert script.mission.robot.pose == ORIGIN
