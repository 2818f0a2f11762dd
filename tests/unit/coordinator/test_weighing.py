"""Votes as evidence: what earned doubt is looked at from another side before it is given up, and again in the end."""

import pytest

from contracts.geometry import Pose2D
from contracts.mission import MissionState, Outcome
from contracts.vision import Verdict
from coordinator.core import actions as do
from support.mission_script import Script, box

S = MissionState


def confirmed_then_refused() -> Script:
    """The case seen: two yes from 2.13 m, then CLIP's no on one picture from 1.18 m."""
    script = Script(validation_rule="evidence").begin().centred().measured(2.13, 3).voted(Verdict.YES, log_odds=2.5)
    script.robot(Pose2D(x=0.95, y=0.0, yaw=0.0))
    script.arrived().see(box()).see(box()).see(box())
    for _ in range(3):
        script.see_at(1.18, 2.19)
    return script.voted(Verdict.NO, log_odds=-1.2)


def looked_at_from_there(script: Script, clip: Verdict, log_odds: float) -> Script:
    script.arrived().see(box()).see(box()).see(box())
    for _ in range(3):
        script.see_at(1.2, 2.19)
    return script.voted(clip, log_odds=log_odds)


def test_one_no_after_a_yes_is_looked_at_from_another_side_and_found() -> None:
    script = confirmed_then_refused()
    assert script.mission.state is S.DRIVING_1M
    assert abs(script.last(do.Navigate).candidates[0].pose.yaw) > 0.5
    looked_at_from_there(script, Verdict.YES, 2.5)
    assert script.mission.candidate is not None
    assert script.mission.candidate.confirmed
    assert len(script.mission.candidate.log_odds) == 3


def test_refused_from_every_side_it_ends_in_doubt_with_the_evidence_as_it_grew() -> None:
    script = confirmed_then_refused()
    for _ in range(2):
        looked_at_from_there(script, Verdict.NO, -1.2)
    assert script.mission.state is S.SCANNING
    (refused,) = script.mission.search.rejections
    assert refused.record is not None
    assert len(refused.record.log_odds) == 4
    assert "evidence +" in refused.text


def test_what_is_in_doubt_is_driven_to_again_when_nothing_else_is_left_and_only_once() -> None:
    script = confirmed_then_refused()
    script.unreachable()
    to_the_last_place(script)
    assert script.mission.state is S.DRIVING_1M
    script.unreachable()
    to_the_last_place(script)
    assert script.mission.outcome is Outcome.UNSURE
    assert script.mission.report is not None
    assert script.mission.report.candidates[0].log_odds


def to_the_last_place(script: Script) -> Script:
    """Looks round, sees nothing, and is told that every place was looked at."""
    script.see()
    while script.mission.state is S.SCANNING:
        script.turned().see()
    return script.planned()


def test_a_clear_no_is_given_up_at_once() -> None:
    script = Script(validation_rule="evidence").begin().centred().measured(1.1, 3).voted(Verdict.NO, log_odds=-4.0)
    assert script.mission.state is S.SCANNING
    assert not script.mission.search.rejections[0].narrow


@pytest.mark.parametrize(("log_odds", "confirmed"), [(2.0, True), (-0.7, False)])
def test_two_yes_that_are_hardly_over_their_thresholds_do_not_confirm(log_odds: float, confirmed: bool) -> None:
    script = Script(validation_rule="evidence").begin().centred().measured(1.1, 3).voted(Verdict.YES, log_odds=log_odds)
    assert script.mission.candidate is not None
    assert script.mission.candidate.confirmed is confirmed
