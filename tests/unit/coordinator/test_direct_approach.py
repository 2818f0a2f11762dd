"""The direct approach: at once, with place and votes on the way."""

import pytest

from contracts.geometry import Pose2D
from contracts.measuring import NotMeasured, not_measured
from contracts.mission import MissionState, Outcome
from contracts.motion import MotionEnd
from contracts.robot import GoalStatus
from contracts.vision import Detection, Verdict
from coordinator.core import actions as do
from coordinator.core import events as ev
from support.mission_script import Script, box

S = MissionState


def on_the_way(distance_m: float = 2.0, **rules: object) -> Script:
    """Seen straight ahead in a look round."""
    return Script(approach_rule="direct", **rules).begin().see_at(distance_m, distance_m + 0.06)


def test_what_is_measured_is_driven_up_to_at_once() -> None:
    script = on_the_way()
    assert script.states[-1] is S.APPROACHING
    assert not script.asked(do.Rotate)
    assert script.last(do.Navigate).candidates[0].pose.x == pytest.approx(2.06 - 0.62, abs=0.5)


def test_what_has_no_place_is_centred_on_as_ever() -> None:
    script = Script(approach_rule="direct").begin().centred().measured(1.2, 3)
    assert script.asked(do.Validate)
    assert script.mission.state is S.DEPTH_CHECK


def too_far() -> Detection:
    nothing = not_measured(NotMeasured.NO_DEPTH, "too few depth pixels in the box")
    return box().model_copy(update={"measurement": nothing})


def test_what_is_too_far_to_measure_is_driven_towards_until_it_can_be() -> None:
    script = Script(approach_rule="direct").begin().see(too_far())
    assert script.states[-1] is S.APPROACHING
    assert not script.asked(do.Rotate)
    assert script.last(do.Navigate).candidates[0].pose.x == pytest.approx(2.0, abs=0.1)
    script.see(too_far()).robot(Pose2D(x=1.0, y=0.0, yaw=0.0)).see_at(2.4, 3.46)
    assert len(script.asked(do.Navigate)) == 2
    assert script.last(do.Navigate).candidates[0].pose.x == pytest.approx(3.46 - 0.62, abs=0.6)
    assert not script.asked(do.StopMotion)
    assert script.mission.state is S.APPROACHING


def test_what_is_not_measured_on_the_way_either_is_looked_at_standing() -> None:
    script = Script(approach_rule="direct").begin().see(too_far())
    script.arrived()
    assert script.mission.state is S.CENTERING


def test_what_is_neither_measured_nor_come_nearer_to_is_left_after_two_steps() -> None:
    script = Script(approach_rule="direct").begin().see(too_far()).arrived(GoalStatus.ABORTED)
    for _ in range(2):
        for _ in range(3):
            script.see(too_far())
        script.see(too_far()).see(too_far()).see(too_far()).wait(2.1)
        assert script.mission.state is S.DRIVING_1M, script.said()
        script.drove(MotionEnd.BLOCKED, moved=0.02)
    assert script.mission.state is S.SCANNING
    assert [one.narrow for one in script.mission.search.rejections] == [True]


def test_two_models_that_are_used_to_say_yes_are_not_enough_by_evidence() -> None:
    """Their log-odds say what such a yes is worth: here not enough."""
    script = on_the_way(validation_rule="evidence").see_at(1.9, 2.06).voted(Verdict.YES, 0.7, log_odds=-0.7)
    assert script.mission.candidate is not None
    assert not script.mission.candidate.confirmed
    assert script.mission.state is S.APPROACHING
    script.wait(1.1).see_at(0.9, 2.06).voted(Verdict.YES, 0.9, log_odds=2.0)
    assert script.mission.candidate.confirmed


def test_what_was_measured_and_judged_from_afar_is_driven_up_to_without_a_step_between() -> None:
    script = Script(approach_rule="direct").begin().centred().measured(2.2, 3).voted(Verdict.YES)
    assert script.mission.state is S.APPROACHING
    assert S.DRIVING_1M not in script.states


def test_it_is_judged_on_the_way_without_the_slow_model_and_without_a_stop() -> None:
    script = on_the_way().see_at(1.9, 2.06)
    assert script.last(do.Validate).moving
    script.voted(Verdict.YES)
    assert script.mission.state is S.APPROACHING
    assert script.mission.candidate is not None
    assert script.mission.candidate.confirmed
    assert not script.asked(do.StopMotion)
    assert len(script.see_at(1.8, 2.06).asked(do.Validate)) == 1


def test_confirmed_and_measured_often_enough_it_is_faced_looked_at_and_driven_up_to() -> None:
    script = on_the_way().see_at(1.9, 2.06).voted(Verdict.YES).see_at(1.8, 2.06).see_at(1.7, 2.06)
    script.arrived().see_at(0.6, 2.06)
    script.drove().see_at(0.4, 2.06)
    assert script.mission.outcome is Outcome.FOUND
    assert S.DEPTH_CHECK not in script.states


@pytest.mark.parametrize("votes", [0, 1])
def test_what_is_not_settled_on_arrival_is_looked_at_standing(votes: int) -> None:
    """Neither without votes, nor with votes and too few measurements."""
    script = on_the_way()
    for _ in range(votes):
        script.see_at(1.9, 2.06).voted(Verdict.YES)
    script.arrived()
    assert script.mission.state is S.CENTERING
    for _ in range(6):
        script.see_at(0.6, 2.06)
    assert not script.last(do.Validate).moving


def test_two_clear_noes_on_the_way_leave_it() -> None:
    """The detector named no colour: it cannot have seen the right one."""
    script = on_the_way().see_at(1.9, 2.06, colour=None).voted(Verdict.NO)
    assert script.mission.state is S.APPROACHING
    script.wait(1.1).see_at(1.7, 2.06, colour=None).voted(Verdict.NO)
    assert script.asked(do.StopMotion)
    assert script.mission.state is S.SCANNING
    assert [one.narrow for one in script.mission.search.rejections] == [False]


def test_a_narrow_no_on_the_way_decides_nothing() -> None:
    script = on_the_way()
    for _ in range(3):
        script.wait(1.1).see_at(1.9, 2.06).voted(Verdict.NO, 0.38)
    assert script.mission.state is S.APPROACHING


def test_what_is_refused_from_near_is_looked_at_standing_from_there() -> None:
    script = on_the_way(1.2).see_at(1.2, 1.26).voted(Verdict.NO, 0.38)
    assert script.asked(do.StopMotion)
    assert script.mission.state is S.CENTERING


def test_votes_that_fail_are_asked_for_again_later_and_end_nothing() -> None:
    script = on_the_way().see_at(1.9, 2.06)
    script.feed(ev.CallFailed(script.last(do.Validate).call, "inference", "away"))
    assert len(script.see_at(1.9, 2.06).asked(do.Validate)) == 1
    assert len(script.wait(3.0).see_at(1.8, 2.06).asked(do.Validate)) == 2
    assert (script.mission.state, script.mission.failures) == (S.APPROACHING, 0)


def test_what_turns_out_to_be_of_another_colour_is_left_on_the_way() -> None:
    script = on_the_way(other_colour_looks=2)
    for _ in range(2):
        script.see(box(colour="green"))
    assert "it is green, not red" in script.said()
    assert script.mission.state is S.SCANNING


def test_a_place_that_turns_out_to_be_elsewhere_replaces_the_goal() -> None:
    script = on_the_way(3.2).wait(3.1)
    for _ in range(4):
        script.see_at(2.2, 2.26)
    first, last = (script.asked(do.Navigate)[k].candidates[0].pose.x for k in (0, -1))
    assert "its place is known better" in script.said()
    assert last == pytest.approx(2.26 - 0.62, abs=0.4)
    assert first != last


def test_what_was_confirmed_and_then_stands_elsewhere_is_judged_anew() -> None:
    """Another thing in the same direction, while the first is hidden: no vote was about it."""
    script = on_the_way(3.2).see_at(2.4, 3.26).voted(Verdict.YES).see_at(2.4, 3.26)
    assert script.mission.candidate is not None
    assert script.mission.candidate.confirmed
    for _ in range(3):
        script.see_at(1.6, 1.66)
    assert script.mission.candidate is not None
    assert not script.mission.candidate.confirmed
    assert len(script.asked(do.Validate)) == 2
    script.voted(Verdict.YES)
    assert script.mission.candidate is not None
    assert script.mission.candidate.confirmed


def test_a_goal_that_cannot_be_reached_leads_to_a_look_from_here() -> None:
    assert on_the_way().unreachable().mission.state is S.CENTERING
    assert on_the_way().arrived(GoalStatus.REJECTED).mission.state is S.CENTERING


def test_on_the_way_for_too_long_is_no_find() -> None:
    script = on_the_way(goal_timeout_s=400.0).wait(241.0)
    assert script.mission.outcome is not Outcome.FOUND
    assert "not settled on the way" in script.said()


def test_lifted_on_the_way_its_place_is_forgotten() -> None:
    script = on_the_way()
    lifted = ev.RobotUpdated(script.now_s, script.mission.robot.pose, None, False, 0.0, False, 0, lifted=True)
    script.feed(lifted)
    script.now_s += 1.5
    script.feed(ev.RobotUpdated(script.now_s, script.mission.robot.pose, None, False, 0.0, False, 0, lifted=True))
    assert script.mission.paused
    assert script.mission.candidate is not None
    assert script.mission.candidate.track is None
