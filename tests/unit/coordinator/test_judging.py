"""Measuring how far it is, and what the votes make of it."""

import pytest

from contracts.geometry import Pose2D
from contracts.mission import MissionState, Outcome
from contracts.vision import Verdict
from coordinator.core import actions as do
from coordinator.core import events as ev
from support.mission_script import Script, box

S = MissionState


@pytest.mark.parametrize(
    ("distance_m", "samples", "state"),
    [(0.44, 3, S.DONE), (1.2, 3, S.APPROACHING), (2.0, 3, S.DRIVING_1M)],
)
def test_after_a_yes_the_distance_decides(distance_m: float, samples: int, state: MissionState) -> None:
    script = Script().begin().centred().measured(distance_m, samples).voted(Verdict.YES)
    assert script.mission.state is state


def test_beyond_two_and_a_half_metres_it_goes_closer_without_asking() -> None:
    script = Script().begin().centred().measured(2.8)
    assert script.mission.state is S.DRIVING_1M
    assert not script.asked(do.Validate)


def test_the_plain_rule_counts_reach_as_done_without_asking() -> None:
    script = Script(approach_rule="straight").begin().centred().measured(0.44, 3)
    assert script.mission.state is S.DONE
    assert not script.asked(do.Validate)


def test_three_measurements_have_to_agree_and_their_middle_counts() -> None:
    script = Script().begin().centred()
    for distance_m in (1.2, 0.6, 1.25):
        script.see_at(distance_m, distance_m + 0.06)
    assert not script.asked(do.Validate)
    script.see_at(1.3, 1.36)
    assert script.mission.candidate is not None
    assert script.mission.candidate.distance_m == pytest.approx(1.25)


def test_of_measurements_that_never_agree_the_farther_are_believed() -> None:
    script = Script().begin().centred()
    for distance_m in (0.5, 1.0, 1.5, 0.5, 1.0, 1.5, 2.2):
        script.see_at(distance_m, distance_m + 0.06)
    assert script.mission.candidate is not None
    assert script.mission.candidate.distance_m == pytest.approx(1.5)


def test_a_picture_that_was_not_measured_is_followed_by_a_newer_one() -> None:
    script = Script().begin().centred().see(box()).see(box()).measured(1.2, 2)
    assert not script.asked(do.Validate)
    assert script.measured(1.2).asked(do.Validate)


def test_the_picture_that_was_centred_is_not_the_one_that_measures() -> None:
    script = Script().begin().see(box())
    for _ in range(3):
        script.see_at(2.8, 2.86)
    assert script.mission.state is S.DEPTH_CHECK
    assert script.see_at(2.8, 2.86).mission.state is S.DRIVING_1M


def test_too_few_measurements_decide_nothing_it_is_looked_at_again() -> None:
    script = Script().begin().centred().measured(1.2, 2).wait(2.2)
    assert script.mission.state is S.CENTERING
    assert not script.asked(do.Validate)


def test_without_any_measurement_the_cause_is_told_and_it_is_tried_again() -> None:
    script = Script(failures_max=2).begin().centred().see(box()).wait(2.2)
    assert "robot_bridge: no measurement came with the picture; trying again" in script.said()
    assert script.mission.running


def test_who_never_measures_is_named_as_the_cause_after_the_failures_that_count() -> None:
    script = Script(failures_max=3).begin().centred()
    for _ in range(20):
        script.see(box()).wait(0.7)
    assert script.mission.outcome is Outcome.ABORTED
    assert "robot_bridge failed 3 times in a row" in script.mission.reason
    assert script.states.count(S.CENTERING) == 1


def test_a_target_that_left_the_picture_is_nobodys_failure() -> None:
    script = Script().begin().centred().wait(2.2)
    assert script.mission.state is S.CENTERING
    assert script.mission.failures == 0


def test_beside_something_refused_what_was_not_measured_is_looked_at_again() -> None:
    script = Script().begin().centred().measured(1.0, 3).voted(Verdict.NO).see(box())
    assert script.mission.state is S.SCANNING
    assert script.wait(2.5).see_at(2.0, 2.06).mission.state is S.CENTERING


def test_a_candidate_that_nobody_can_judge_is_left_before_the_failures_end_the_mission() -> None:
    script = Script(judge_tries=1, failures_max=1).begin().centred().measured(1.2, 3)
    script.feed(ev.CallFailed(script.last(do.Validate).call, "inference", "away"))
    assert script.mission.state is S.SCANNING


def test_a_clear_no_is_remembered_and_the_same_thing_is_not_judged_again() -> None:
    script = Script().begin().centred().measured(1.2, 3).voted(Verdict.NO)
    assert script.mission.state is S.SCANNING
    script.see_at(1.2, 1.26)
    assert script.mission.state is S.SCANNING
    assert len(script.asked(do.Validate)) == 1


def test_another_one_behind_the_refused_one_is_judged() -> None:
    script = Script().begin().centred().measured(1.0, 3).voted(Verdict.NO)
    script.see_at(2.0, 2.06)
    assert script.mission.state is S.CENTERING


@pytest.mark.parametrize(("from_m", "state"), [(1.1, S.CENTERING), (1.4, S.SCANNING)])
def test_what_was_refused_is_judged_again_from_much_nearer_only(from_m: float, state: MissionState) -> None:
    script = Script(closer_looks_max=0).begin().centred().measured(2.0, 3).voted(Verdict.NO)
    script.robot(Pose2D(x=2.0 - from_m, y=0.0, yaw=0.0)).see_at(from_m, 2.06)
    assert script.mission.state is state


def test_a_picture_in_which_the_detector_saw_nothing_is_looked_at_from_closer() -> None:
    script = Script().begin().centred().measured(2.0, 3).voted(Verdict.NO, detector=Verdict.NO)
    assert script.mission.state is S.DRIVING_1M
    assert not script.mission.search.rejections


def test_from_near_a_picture_that_did_not_show_it_is_no_refusal_until_it_happened_three_times() -> None:
    script = Script().begin().centred()
    for _ in range(2):
        script.measured(1.0, 3).voted(Verdict.NO, detector=Verdict.NO)
        assert script.mission.state is S.CENTERING
        assert not script.mission.search.rejections
        script.see(box()).see(box()).see(box())
    script.measured(1.0, 3).voted(Verdict.NO, detector=Verdict.NO)
    assert script.mission.state is S.SCANNING
    assert len(script.mission.search.rejections) == 1


def test_what_was_confirmed_is_not_dropped_for_standing_beside_something_refused() -> None:
    script = Script(closer_looks_max=0).begin().centred().measured(2.0, 3).voted(Verdict.NO)
    script.robot(Pose2D(x=1.0, y=0.0, yaw=0.0)).see_at(1.1, 2.16).see(box()).see(box()).see(box())
    script.measured(1.7, 3).voted(Verdict.YES).arrived().see(box()).see(box()).see(box())
    for _ in range(3):
        script.see_at(1.6, 2.2)
    assert "this one was already rejected" not in script.said()
    assert script.asked(do.Validate)[-1].call == script.mission.activity.call


def test_a_find_whose_colour_no_look_named_says_so() -> None:
    told = []
    for colour in (None, "red"):
        script = Script().begin()
        for _ in range(4):
            script.see(box(colour=colour))
        for _ in range(2):
            script.see_at(0.4, 0.46, colour=colour)
        reason = script.see_at(0.4, 0.46, colour=colour).voted(Verdict.YES).mission.reason
        told.append("only the votes say red" in reason)
    assert told == [True, False]


def test_a_narrow_no_from_afar_earns_one_closer_look() -> None:
    script = Script().begin().centred().measured(2.0, 3).voted(Verdict.NO, score=0.38)
    assert script.mission.state is S.DRIVING_1M


def test_a_narrow_no_from_near_makes_the_ending_unsure() -> None:
    script = Script(mission_timeout_s=40.0, look_timeout_s=60.0).begin().centred()
    script.measured(1.0, 3).voted(Verdict.NO, score=0.38).wait(41.0)
    assert script.mission.outcome is Outcome.UNSURE
