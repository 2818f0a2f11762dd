"""Remembered places, exploration, scans, and what goes wrong on the way."""

import math
from itertools import pairwise

import pytest

from contracts.geometry import Pose2D
from contracts.mission import MissionState, Outcome
from contracts.motion import MotionEnd
from contracts.robot import GoalStatus
from contracts.vision import Detection
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core.activities import AwaitingFrame, Waking
from coordinator.core.geometry import relative
from coordinator.core.mission import SearchPose
from coordinator.core.rules import ApproachRule
from support.mission_script import ORIGIN, TARGET, Script, box

S = MissionState
VIEW = Pose2D(x=3.0, y=0.0, yaw=1.0)
OTHER = Pose2D(x=0.0, y=4.0, yaw=0.0)
THING_XY = (6.0, 0.0)
FARTHER = Pose2D(x=6.0, y=3.0, yaw=-1.57)


def scan(script: Script, looks: int = 11) -> Script:
    """Looks round and sees nothing."""
    for _ in range(looks):
        script.see()
        if script.mission.state is S.SCANNING and script.actions and isinstance(script.actions[-1], do.Rotate):
            script.turned()
    return script


def test_without_memory_it_looks_round_where_it_stands() -> None:
    script = Script().begin()
    assert script.mission.state is S.SCANNING
    assert len(script.mission.search.headings) == 11


def test_with_memory_it_drives_to_the_best_view_first() -> None:
    script = Script().begin(VIEW, OTHER)
    assert script.mission.state is S.MEMORY_NAV
    assert script.last(do.Navigate).candidates[0].pose == VIEW


def remembered(thing_xy: tuple[float, float] | None = THING_XY, **rules: object) -> Script:
    return Script(**rules).feed(
        ev.MissionStarted("m1", "find the red bottle", TARGET, "rules", (SearchPose(VIEW, "seen before", thing_xy),))
    )


def test_a_thing_whose_place_is_known_is_driven_to_itself_on_the_side_it_was_seen_from() -> None:
    *in_reach, last = remembered().last(do.Navigate).candidates
    assert (last.pose, last.rank) == (VIEW, 2)
    assert [one.rank for one in in_reach] == [0] * 5 + [1] * 5
    best = in_reach[0].pose
    assert (best.x, best.y, best.yaw) == pytest.approx((4.75, 0.0, 0.0))
    for pose in (one.pose for one in in_reach):
        away = relative(*THING_XY, pose)
        assert away.bearing_rad == pytest.approx(0.0, abs=1e-6)
        assert away.distance_m < 1.51
        assert pose.x < THING_XY[0]


def test_before_a_thing_it_looks_at_it_first_from_wherever_it_could_stand() -> None:
    script = remembered()
    stands = script.arrived(at=3).last(do.Navigate).candidates[3].pose
    assert script.mission.search.headings[0] == pytest.approx(stands.yaw)


def test_a_thing_seen_from_near_and_one_of_the_plain_approach_are_looked_at_from_where_it_was_seen() -> None:
    for script in (remembered((4.0, 0.0)), remembered(approach_rule=ApproachRule.STRAIGHT), remembered(None)):
        assert [one.pose for one in script.last(do.Navigate).candidates] == [VIEW]


def test_a_thing_looked_for_in_reach_is_looked_for_from_its_further_view_itself() -> None:
    views = tuple(SearchPose(pose, "seen before", THING_XY) for pose in (VIEW, FARTHER))
    script = Script().feed(ev.MissionStarted("m1", "find the red bottle", TARGET, "rules", views))
    scan(script.arrived())
    assert [one.pose for one in script.last(do.Navigate).candidates] == [FARTHER]


def test_it_leaves_the_dock_before_anything_else() -> None:
    script = Script().robot(docked=True).begin(VIEW)
    assert not script.asked(do.Navigate)
    script.feed(ev.Undocked(script.last(do.Undock).call)).see()
    assert script.last(do.Navigate).candidates[0].pose == VIEW


def test_a_scan_turns_420_degrees_in_equal_steps_from_the_remembered_heading() -> None:
    script = Script().begin(VIEW).arrived()
    headings = script.mission.search.headings
    assert headings[0] == VIEW.yaw
    assert math.degrees(headings[-1] - headings[0]) == pytest.approx(420.0, abs=0.01)
    steps = {round(b - a, 6) for a, b in pairwise(headings)}
    assert len(steps) == 1
    assert steps.pop() < math.radians(54)


def test_a_frame_taken_while_turning_does_not_count_as_a_look() -> None:
    script = Script().begin()
    script.see()
    rotate = script.last(do.Rotate)
    script.see(box())
    assert script.mission.state is S.SCANNING
    script.feed(ev.MotionEnded(rotate.call, MotionEnd.COMPLETED, turned_rad=rotate.angle_rad))
    script.see(box())
    assert script.mission.state is S.CENTERING


def test_after_a_scan_comes_the_next_view_and_then_exploration() -> None:
    script = scan(Script().begin(VIEW, OTHER).arrived())
    assert script.mission.state is S.MEMORY_NAV
    scan(script.arrived())
    assert script.mission.state is S.MOVING_TO_SCAN
    assert script.asked(do.PlanCoverage)


def test_a_view_beside_a_place_already_looked_at_is_not_looked_at_again() -> None:
    near = Pose2D(x=3.2, y=0.1, yaw=2.0)
    script = scan(Script().begin(VIEW, near).arrived())
    assert script.mission.state is S.MOVING_TO_SCAN


def test_the_plan_is_asked_without_what_was_looked_at_or_unreachable() -> None:
    script = scan(Script().begin())
    script.planned(VIEW, OTHER).unreachable()
    assert script.mission.state is S.MOVING_TO_SCAN
    assert set(script.last(do.PlanCoverage).avoid) == {ORIGIN, VIEW}


def test_a_place_that_nav2_gave_up_is_skipped_for_the_bridge_has_tried_again_by_then() -> None:
    script = Script().begin(VIEW, OTHER).arrived(GoalStatus.ABORTED, 104)
    assert script.last(do.Navigate).candidates[0].pose == OTHER


def test_an_unreachable_view_is_skipped_with_the_reason() -> None:
    script = Script().begin(VIEW, OTHER).unreachable()
    assert script.last(do.Navigate).candidates[0].pose == OTHER
    assert "there is no path to it" in script.said()


def test_when_no_view_is_reachable_it_looks_round_here() -> None:
    script = Script().begin(VIEW).unreachable()
    assert script.mission.state is S.SCANNING


def test_a_sighting_on_the_way_stops_the_drive_when_the_next_picture_shows_it_too() -> None:
    script = Script().begin(VIEW).see(box(40))
    assert script.mission.state is S.MEMORY_NAV
    script.see(box(50))
    assert script.mission.state is S.CENTERING
    assert script.asked(do.StopMotion)


def test_the_plain_rule_stops_the_drive_at_the_first_sighting() -> None:
    assert Script(moving_twice=False).begin(VIEW).see(box(40)).mission.state is S.CENTERING


@pytest.mark.parametrize("then", [(), (box(300),)])
def test_a_flicker_on_the_way_does_not_stop_the_drive(then: tuple[Detection, ...]) -> None:
    script = Script().begin(VIEW).see(box(40)).see(*then)
    assert script.mission.state is S.MEMORY_NAV


def test_the_same_picture_told_twice_is_one_sighting() -> None:
    script = Script().begin(VIEW).see(box(40))
    script.feed(script.fed[-1])
    assert script.mission.state is S.MEMORY_NAV


def test_another_colour_or_an_unsure_box_does_not_stop_the_drive() -> None:
    script = Script().begin(VIEW).see(box(colour="blue"), box(confidence=0.35), box(label="cup"))
    assert script.mission.state is S.MEMORY_NAV


def test_a_box_of_unknown_colour_is_worth_a_look() -> None:
    assert Script().begin().see(box(colour=None)).mission.state is S.CENTERING


def test_with_nothing_left_to_look_at_it_says_not_found_and_how_much_it_saw() -> None:
    script = scan(Script().begin())
    script.feed(ev.CoverageLooked(0.87)).planned()
    assert script.mission.outcome is Outcome.NOT_FOUND
    assert script.mission.state is S.IDLE
    assert "87 %" in script.mission.reason


def test_lawnmower_points_are_planned_once_and_taken_in_order() -> None:
    script = scan(Script(coverage_rule="lawnmower").begin())
    script.planned(VIEW, OTHER).arrived()
    scan(script)
    assert len(script.asked(do.PlanCoverage)) == 1
    assert script.last(do.Navigate).candidates[0].pose == OTHER


def test_a_blind_robot_waits_as_long_as_an_update_of_inference_takes_and_then_gives_up() -> None:
    script = Script().begin().wait(45.0)
    assert script.mission.running
    script.wait(20.0)
    assert script.mission.outcome is Outcome.ABORTED
    assert "no picture" in script.mission.reason


def test_nav2_refusing_every_goal_ends_the_mission_with_the_cause() -> None:
    script = Script().begin(*(Pose2D(x=float(k), y=5.0, yaw=0.0) for k in range(10)))
    for _ in range(30):
        if script.mission.outcome is not None:
            break
        script.arrived(GoalStatus.REJECTED).wait(2.5)
    assert script.mission.outcome is Outcome.ABORTED
    assert "refused" in script.mission.reason


def test_the_mission_deadline_ends_a_search() -> None:
    script = Script(mission_timeout_s=30.0, look_timeout_s=20.0).begin().wait(31.0)
    assert script.mission.outcome is Outcome.NOT_FOUND
    assert "time limit reached" in script.mission.reason


def test_a_goal_that_others_cancelled_is_sent_again_after_a_pause() -> None:
    script = Script().begin(VIEW).arrived(GoalStatus.CANCELED).wait(2.2)
    assert script.mission.state is S.MEMORY_NAV
    assert [n.candidates[0].pose for n in script.asked(do.Navigate)] == [VIEW, VIEW]


def test_a_turn_cut_off_is_done_again_and_its_heading_not_skipped() -> None:
    script = Script().begin().see()
    heading = script.mission.search.headings[0]
    script.turned(MotionEnd.PREEMPTED).wait(10.2)
    assert script.mission.search.headings[0] == heading
    assert len(script.asked(do.Rotate)) == 2


def test_a_robot_that_never_turns_ends_the_mission_with_the_cause() -> None:
    script = Script().begin().see()
    for _ in range(8):
        if script.mission.running:
            script.turned(MotionEnd.PREEMPTED).wait(10.2)
    assert script.mission.outcome is Outcome.ABORTED
    assert "would not move" in script.mission.reason


def test_a_dock_status_that_lags_does_not_undock_twice() -> None:
    script = Script().robot(docked=True).begin(VIEW)
    script.feed(ev.Undocked(script.last(do.Undock).call)).robot(docked=True).see().unreachable()
    assert len(script.asked(do.Undock)) == 1


def test_off_the_dock_the_first_picture_is_waited_for_before_anything_else() -> None:
    """A TurtleBot 4 turns lidar and camera off on its dock, and the camera takes its time to come back."""
    script = Script(wake_s_max=60.0).robot(docked=True).begin()
    script.feed(ev.Undocked(script.last(do.Undock).call)).robot(docked=False)
    script.wait(50.0)
    assert isinstance(script.mission.activity, Waking)
    script.see().wait(0.2)
    assert isinstance(script.mission.activity, AwaitingFrame)


def test_a_camera_that_stays_off_after_the_dock_is_told_and_ends_the_mission_as_ever() -> None:
    script = Script(wake_s_max=20.0).robot(docked=True).begin()
    script.feed(ev.Undocked(script.last(do.Undock).call)).robot(docked=False)
    script.wait(20.2)
    assert "no camera picture 20 s after undocking" in script.said()
    script.wait(70.0)
    assert script.mission.outcome is Outcome.ABORTED
    assert "the camera is down" in script.mission.reason
