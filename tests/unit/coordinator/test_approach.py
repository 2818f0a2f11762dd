"""Centring, and driving up to it."""

import math

import pytest

from contracts.mission import MissionState, Outcome
from contracts.motion import MotionEnd
from contracts.robot import GoalStatus
from contracts.vision import Verdict
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core.plain.centering import centering_speed_rad_s
from support.mission_script import Script, box, rules_of

S = MissionState


@pytest.mark.parametrize(
    ("error_px", "speed_rad_s"),
    [(160.0, -0.3), (-160.0, 0.3), (50.0, -0.15), (-50.0, 0.15), (5.0, -0.05), (-5.0, 0.05)],
)
def test_the_centring_speed_is_proportional_clipped_and_never_too_slow(error_px: float, speed_rad_s: float) -> None:
    assert centering_speed_rad_s(error_px, rules_of()) == pytest.approx(speed_rad_s)


def test_three_centred_frames_in_a_row_lead_to_the_depth_check() -> None:
    script = Script().begin().see(box()).see(box()).see(box())
    assert script.mission.state is S.CENTERING
    assert script.see(box()).mission.state is S.DEPTH_CHECK


def test_a_frame_off_centre_starts_the_count_again() -> None:
    script = Script(centering_rule="proportional").begin().see(box()).see(box()).see(box()).see(box(200)).see(box())
    assert script.mission.state is S.CENTERING


def test_the_plain_rule_turns_by_leases_towards_the_box() -> None:
    script = Script(centering_rule="proportional").begin().see(box(60)).see(box(60))
    assert script.last(do.SetVelocity).twist.angular_z == pytest.approx(0.3)
    assert script.last(do.SetVelocity).duration_s == pytest.approx(0.4)


def test_the_bearing_rule_turns_by_the_bearing() -> None:
    script = Script().begin().see(box(60)).see(box(60))
    assert script.last(do.Rotate).angle_rad == pytest.approx(math.atan(100 / (160 / math.tan(0.471))), abs=0.01)


def test_pixels_are_scaled_to_the_frame_they_come_from() -> None:
    script = Script().begin().see(box())
    assert script.mission.candidate is not None
    assert abs(script.mission.candidate.sighting.error_px) < 1e-6


def test_lost_for_four_seconds_it_goes_back_to_scanning() -> None:
    script = Script().begin().see(box()).wait(4.4)
    assert script.mission.state is S.SCANNING


def test_fifteen_seconds_without_being_centred_are_enough() -> None:
    script = Script(centering_rule="proportional").begin().see(box(60))
    for _ in range(60):
        if script.mission.state is not S.CENTERING:
            break
        script.see(box(60))
    assert script.mission.state is S.SCANNING


def test_what_turns_out_to_be_of_another_colour_is_left_with_that_reason() -> None:
    script = Script(centering_rule="proportional").begin().see(box(60, colour=None))
    for colour in ("white", "white", None, "white", "red", "white", "white", "white"):
        script.see(box(60, colour=colour))
        assert script.mission.state is S.CENTERING
    script.see(box(60, colour="white"))
    assert script.mission.state is S.SCANNING
    assert "it is white, not red" in script.said()


def test_a_thing_of_another_colour_beside_it_does_not_count_against_it() -> None:
    script = Script(centering_rule="proportional").begin().see(box(60))
    for _ in range(8):
        script.see(box(60), box(90, colour="white"))
    assert script.mission.state is S.CENTERING


def test_a_thing_of_unknown_colour_is_not_given_its_neighbours() -> None:
    script = Script(centering_rule="proportional").begin().see(box(60, colour=None))
    for _ in range(8):
        script.see(box(60, colour=None), box(90, colour="white"))
    assert script.mission.state is S.CENTERING


def test_what_was_lost_twice_in_a_direction_is_not_followed_a_third_time() -> None:
    script = Script().begin().see(box()).wait(4.4).see(box()).wait(4.4)
    assert script.mission.state is S.SCANNING
    assert script.see(box()).mission.state is S.SCANNING


def approaching(distance_m: float = 1.2, **rules: object) -> Script:
    return Script(**rules).begin().centred().measured(distance_m, 3).voted(Verdict.YES)


def test_it_asks_for_a_reachable_place_round_the_object_facing_it() -> None:
    script = approaching()
    asked = script.last(do.Navigate)
    first = asked.candidates[0].pose
    assert math.hypot(first.x - 1.26, first.y) == pytest.approx(0.62)
    assert first.yaw == pytest.approx(0.0)
    assert [each.rank for each in asked.candidates[::9]] == [0, 1]
    assert (asked.candidates[0].cost_m, asked.candidates[1].cost_m) == (0.0, pytest.approx(0.35 * 0.4))
    assert asked.ring_radius_m == 0.0


def test_a_place_that_nav2_would_call_reached_at_once_is_turned_to_and_driven_up_to() -> None:
    script = approaching(0.85)
    assert script.asked(do.Navigate) == []
    assert script.see_at(0.85, 0.91).last(do.Drive).distance_m == pytest.approx(0.45, abs=0.01)


def test_out_of_the_picture_it_finishes_on_the_place_and_odometry() -> None:
    script = approaching().arrived().wait(3.0)
    drive = script.last(do.Drive)
    assert drive.distance_m == pytest.approx(0.62 - 0.06 - 0.40, abs=0.01)
    script.drove().wait(2.0)
    assert script.mission.outcome is Outcome.FOUND
    assert script.mission.state is S.DONE
    assert script.mission.candidate is not None
    assert script.mission.candidate.distance_m == pytest.approx(0.40, abs=0.01)


def test_a_last_look_corrects_the_place() -> None:
    script = approaching().arrived().see_at(0.66, 1.36)
    assert script.last(do.Drive).distance_m == pytest.approx(0.26, abs=0.01)


def test_a_single_measurement_that_jumps_is_not_believed() -> None:
    script = approaching().arrived().see_at(2.5, 3.2)
    assert not script.asked(do.Drive)
    script.see_at(0.56, 1.26)
    assert script.last(do.Drive).distance_m == pytest.approx(0.16, abs=0.02)


def test_what_two_measurements_say_replaces_the_place_believed_so_far() -> None:
    script = approaching().arrived().see_at(1.6, 2.3).see_at(1.6, 2.3)
    assert script.mission.candidate is not None
    assert script.mission.candidate.map_xy == pytest.approx((2.3, 0.0))
    assert script.last(do.Drive).distance_m == pytest.approx(1.2, abs=0.1)


def test_a_reach_shorter_than_the_stand_off_is_driven_to_all_the_same() -> None:
    script = approaching(reach_m=0.2, rounds_max=3).arrived().see_at(0.56, 1.26)
    script.drove().wait(3.0).drove().wait(3.0)
    assert script.mission.outcome is Outcome.FOUND
    assert "0.2" in script.mission.reason


def test_a_blocked_drive_is_a_find_with_its_distance_and_the_reason() -> None:
    script = approaching().arrived().wait(3.0).drove(MotionEnd.BLOCKED, moved=0.02).wait(2.0)
    assert script.mission.outcome is Outcome.FOUND
    assert "as near as the map allows: something is in the way" in script.mission.reason


def test_stopped_far_off_it_tries_another_side_once() -> None:
    script = approaching(1.45).unreachable().wait(3.0).drove(MotionEnd.BLOCKED, moved=0.1).wait(2.0)
    assert script.mission.state is S.APPROACHING
    script.unreachable().wait(3.0).drove(MotionEnd.BLOCKED, moved=0.0).wait(2.0)
    assert script.mission.outcome is Outcome.FOUND


def test_the_step_to_a_far_target_ends_in_centring_even_when_blocked() -> None:
    script = Script().begin().centred().measured(2.8).unreachable()
    assert script.last(do.Drive).distance_m == pytest.approx(1.0)
    assert script.drove(MotionEnd.BLOCKED, moved=0.1).mission.state is S.CENTERING


def test_an_aborted_step_ends_in_another_look() -> None:
    script = Script().begin().centred().measured(2.8).arrived(GoalStatus.ABORTED, 104)
    assert script.mission.state is S.CENTERING


def test_a_sighting_on_the_way_up_to_it_cancels_nothing_and_is_measured_on_arrival() -> None:
    """Requirement A13; on the way to a place of the search it ends the drive: see test_search."""
    script = approaching().see(box()).see(box())
    assert (script.mission.state, script.asked(do.StopMotion)) == (S.APPROACHING, [])
    assert "0.66 m away" in script.arrived().see_at(0.66, 1.36).said()


def test_confirmed_and_then_out_of_sight_it_finishes_on_the_map() -> None:
    script = Script().begin().centred().measured(2.0, 3).voted(Verdict.YES).arrived().wait(4.5)
    assert script.mission.state is S.APPROACHING


def test_what_was_seen_from_afar_only_and_not_from_near_is_no_find() -> None:
    script = Script().begin().centred().measured(2.0, 3).voted(Verdict.YES).arrived().wait(4.5)
    script.arrived().wait(3.0).drove().wait(3.0)
    assert script.mission.outcome is None
    assert "seen only from far away so far" in script.said()
    script.wait(6.0)
    assert script.mission.state is S.SCANNING
    assert [loss.confirmed for loss in script.mission.search.losses] == [True]


def test_the_plain_approach_drives_by_leases_and_measures_twice_a_second() -> None:
    script = approaching(approach_rule="straight")
    script.robot(speed_m_s=0.15).wait(1.0)
    assert script.last(do.SetVelocity).twist.linear_x == pytest.approx(0.15)
    script.see_at(0.44, 1.26)
    assert script.mission.outcome is Outcome.FOUND


def test_the_plain_approach_stands_still_and_says_why_where_nobody_measures() -> None:
    script = approaching(approach_rule="straight", failures_max=3)
    script.robot(speed_m_s=0.15).wait(0.2).see(box())
    leases = len(script.asked(do.SetVelocity))
    assert script.asked(do.StopMotion)
    assert len(script.wait(1.0).asked(do.SetVelocity)) == leases
    assert "robot_bridge: no measurement came with the picture; trying again" in script.said()
    assert len(script.wait(1.2).asked(do.SetVelocity)) == leases
    script.see(box()).wait(3.2).see(box())
    assert script.mission.outcome is Outcome.ABORTED
    assert len(script.asked(do.SetVelocity)) == leases


def test_the_plain_approach_drives_on_once_it_is_measured_again() -> None:
    script = approaching(approach_rule="straight").see(box()).wait(2.2)
    leases = len(script.asked(do.SetVelocity))
    assert len(script.see_at(1.0, 1.06).wait(0.3).asked(do.SetVelocity)) > leases


def test_the_plain_approach_turns_to_it_again_where_it_is_gone_after_a_failure() -> None:
    script = approaching(approach_rule="straight").see(box()).wait(5.5)
    assert script.mission.state is S.CENTERING


def test_the_last_look_is_measured_or_the_robot_stands_and_says_who_failed() -> None:
    script = approaching(failures_max=3).arrived().see(box())
    drives = len(script.asked(do.Drive))
    for _ in range(20):
        script.see(box()).wait(0.7)
    assert len(script.asked(do.Drive)) == drives
    assert script.mission.outcome is Outcome.ABORTED
    assert "robot_bridge failed 3 times in a row" in script.mission.reason


def test_a_last_look_that_is_measured_late_goes_on_from_where_it_stands() -> None:
    script = approaching().arrived().see(box()).wait(5.0)
    goals = len(script.asked(do.Navigate))
    script.wait(1.0).measured(0.7)
    assert script.asked(do.Drive)
    assert len(script.asked(do.Navigate)) == goals


def test_a_measurement_ends_the_row_of_those_that_failed() -> None:
    script = approaching(approach_rule="straight", failures_max=2).see(box()).wait(2.2).see_at(1.0, 1.06)
    assert script.mission.failures == 0
    assert script.wait(0.6).see(box()).mission.running


def test_the_plain_approach_centres_again_after_a_drift() -> None:
    script = approaching(approach_rule="straight").wait(0.2).see(box(220))
    assert script.mission.state is S.CENTERING


def test_the_plain_approach_ends_at_an_obstacle() -> None:
    script = approaching(approach_rule="straight").feed(ev.LeaseAnswered(MotionEnd.BLOCKED)).wait(3.3)
    assert script.mission.outcome is Outcome.FOUND
    assert "obstacle" in script.mission.reason


def test_the_plain_step_takes_a_metre_at_its_speed() -> None:
    script = Script(approach_rule="straight").begin().centred().measured(2.8).wait(6.5)
    assert script.mission.state is S.DRIVING_1M
    assert script.wait(0.3).mission.state is S.CENTERING


def test_a_candidate_that_never_gets_nearer_is_given_up() -> None:
    script = Script(rounds_max=2).begin()
    for _ in range(3):
        if script.mission.state is S.SCANNING:
            script.see(box())
        for _ in range(3):
            script.see(box())
        if script.mission.state is not S.DEPTH_CHECK:
            break
        script.measured(2.9).unreachable().drove(MotionEnd.BLOCKED, moved=0.0)
    assert script.mission.search.rejections


def test_validation_failing_again_and_again_aborts_with_the_cause() -> None:
    script = Script(failures_max=2).begin().centred().measured(1.2, 3)
    script.feed(ev.CallFailed(script.last(do.Validate).call, "inference", "away"))
    assert script.mission.running
    script.feed(ev.CallFailed(script.last(do.Validate).call, "inference", "away")).wait(2.2)
    assert script.mission.state in {S.DEPTH_CHECK, S.CENTERING}


def test_a_robot_that_is_not_localised_follows_what_it_sees() -> None:
    script = Script().begin().robot(None).see(box())
    assert script.mission.state is S.CENTERING


def test_a_drive_cut_off_by_something_else_than_an_obstacle_is_taken_up_again() -> None:
    script = approaching().arrived().wait(3.0).drove(MotionEnd.SESSION_ENDED, moved=0.02)
    assert script.mission.running
    script.wait(2.2)
    assert script.mission.state is S.APPROACHING
    script.wait(3.0)
    assert len(script.asked(do.Drive)) == 2


def test_a_rejected_step_nearer_is_driven_straight() -> None:
    script = Script().begin().centred().measured(2.8).arrived(GoalStatus.REJECTED)
    assert script.mission.state is S.DRIVING_1M
    assert script.last(do.Drive).distance_m == pytest.approx(1.0)


def test_a_goal_refused_twice_in_the_approach_is_done_without() -> None:
    script = approaching().arrived(GoalStatus.REJECTED).wait(2.4).arrived(GoalStatus.REJECTED)
    assert "REJECTED: driving straight ahead from here" in script.said()
    script.wait(3.0)
    assert script.asked(do.Drive)
