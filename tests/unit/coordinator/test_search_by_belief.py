"""The mission core by belief: one choice after another, each with its looks, looking on the way."""

import math

import pytest

from contracts.geometry import Pose2D
from contracts.mission import EndCause, MissionState, Outcome
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core.recording import Recording, Step, header_line, header_of, read, replay, step_line
from coordinator.execution.mission_messages import waiting_for
from support.mission_script import ORIGIN, Script

S = MissionState
AWAY = Pose2D(x=3.0, y=1.0, yaw=0.5)
QUARTER = (0.5, 1.2)


def by_belief() -> Script:
    return Script(coverage_rule="belief")


def chosen(script: Script, pose: Pose2D, *headings: float, why: str = "2 looks 3.2 m away") -> Script:
    call = script.last(do.PlanCoverage).call
    return script.feed(ev.CoveragePlanned(call, (pose,), 20.0, headings=headings, why=why))


def ended(script: Script, why: str) -> Script:
    return script.feed(ev.CoveragePlanned(script.last(do.PlanCoverage).call, (), 20.0, why=why))


def ended_by(script: Script) -> EndCause | None:
    report = script.mission.report
    return report.ended_by if report is not None else None


def looked(script: Script, looks: int) -> Script:
    for _ in range(looks):
        if isinstance(script.actions[-1], do.Rotate):
            script.turned()
        script.see()
    return script


def test_it_chooses_before_it_looks_or_drives_anywhere() -> None:
    script = by_belief().begin(AWAY)
    assert script.mission.state is S.MOVING_TO_SCAN
    assert script.asked(do.PlanCoverage)
    assert not script.asked(do.Navigate)
    assert not script.asked(do.Rotate)


def test_a_choice_is_one_line_and_its_looks_are_taken_there_and_no_more() -> None:
    script = chosen(by_belief().begin(), AWAY, *QUARTER)
    assert "2 looks 3.2 m away" in script.said()
    looked(script.arrived(), 2)
    assert len(script.asked(do.RecordLook)) == 2
    assert len(script.asked(do.PlanCoverage)) == 2
    assert script.mission.robot.yaw == pytest.approx(QUARTER[1], abs=0.01)


def test_a_place_that_was_only_chosen_from_does_not_count_as_looked_at() -> None:
    script = chosen(by_belief().begin(), AWAY, *QUARTER)
    assert script.mission.search.visited == ()
    assert "nothing found" not in script.said()
    assert looked(script.arrived(), 2).mission.search.visited == (AWAY,)


def test_it_looks_from_where_it_stands_without_driving() -> None:
    script = looked(chosen(by_belief().begin(), ORIGIN, *QUARTER), 2)
    assert not script.asked(do.Navigate)
    assert len(script.asked(do.PlanCoverage)) == 2


def test_it_looks_while_it_drives_each_time_the_view_is_another() -> None:
    script = chosen(by_belief().begin(), AWAY, *QUARTER)
    script.see()
    script.see()
    script.robot(Pose2D(x=1.0, y=0.0, yaw=0.0)).see()
    glances = script.asked(do.RecordLook)
    assert [one.pose.x for one in glances] == [0.0, 1.0]
    assert all(one.moving for one in glances)


def test_lost_it_waits_and_chooses_once_it_knows_its_place_again() -> None:
    script = by_belief()
    script.robot(pose=None)
    script.begin(AWAY).wait(10.0)
    assert script.said().count("does not know where it is") == 1
    assert not script.asked(do.PlanCoverage)
    assert script.mission.failures == 0
    assert waiting_for(script.mission, script.now_s) == "localisation: for 35 s at most"
    script.robot().wait(0.2)
    assert len(script.asked(do.PlanCoverage)) == 1


def test_a_place_that_cannot_be_reached_is_told_to_the_next_choice() -> None:
    script = chosen(by_belief().begin(), AWAY, *QUARTER).unreachable()
    assert script.last(do.PlanCoverage).avoid == (AWAY,)


def test_it_ends_when_nothing_is_worth_it_and_says_how_sure_it_is() -> None:
    script = ended(by_belief().begin(), "what is left is not worth a look: 93% sure that it is not here")
    assert (script.mission.outcome, ended_by(script)) == (Outcome.NOT_FOUND, EndCause.ALL_LOOKED)
    assert "93% sure that it is not here" in script.mission.reason


def test_where_a_place_could_not_be_reached_it_did_not_look_everywhere_and_says_so() -> None:
    script = ended(chosen(by_belief().begin(), AWAY, *QUARTER).unreachable(), "what is left is not worth a look")
    assert (script.mission.outcome, ended_by(script)) == (Outcome.NOT_FOUND, EndCause.NO_PLACE_LEFT)
    assert "what is left is not worth a look; 1 place to look from could not be reached" in script.mission.reason


def test_its_recording_replays_as_it_was_decided() -> None:
    script = by_belief()
    header = header_of(script.mission, "m1", script.now_s)
    before = len(script.fed)
    ended(looked(chosen(script.begin(), AWAY, *QUARTER).arrived(), 2), "not worth it")
    again = Script(coverage_rule="belief")
    steps: list[Step] = []
    for event in script.fed[before:]:
        known = len(again.actions)
        again.now_s = 100.0
        again.feed(event)
        steps.append(Step(again.now_s, event, tuple(again.actions[known:]), again.mission.state))
    lines = [header_line(header), *map(step_line, steps)]
    recorded: Recording = read(lines)
    assert all(one.same for one in replay(recorded))
    assert math.isclose(recorded.header.begun_s, 100.0)
