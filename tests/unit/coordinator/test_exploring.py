"""EXPLORING: the mission begins an exploration, holds it, and says how it ended."""

import pytest

from contracts.exploration import ExplorationEnd, ExplorationMode
from contracts.geometry import Pose2D
from contracts.mission import EndCause, EventKind, MissionState, Outcome
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core.activities import Paused, UnderExploration
from coordinator.core.motions import PlainMotion
from coordinator.core.rules import CoverageRule, ScanRule
from coordinator.execution.mission_messages import waiting_for
from support.mission_script import ORIGIN, Script, box

E = ExplorationEnd


def exploring(*, pose: Pose2D | None = ORIGIN, docked: bool = False, **rules: object) -> Script:
    script = Script(**rules).robot(pose, docked=docked)
    return script.feed(ev.MotionStarted("m1", "explore", PlainMotion("exploring", limit_s=300.0, explores=True)))


def over(script: Script, end: ExplorationEnd, actions: int = 3, **facts: object) -> Script:
    return script.feed(ev.ExplorationEnded(script.last(do.BeginExploration).call, end, actions, **facts))  # pyright: ignore[reportArgumentType]


def ended(script: Script) -> tuple[Outcome | None, EndCause | None]:
    report = script.mission.report
    return script.mission.outcome, report.ended_by if report is not None else None


def test_it_begins_an_exploration_that_comes_home_to_where_the_robot_stands() -> None:
    script = exploring(pose=Pose2D(x=1.0, y=2.0, yaw=0.5))
    assert script.mission.state is MissionState.EXPLORING
    assert script.last(do.BeginExploration).home == Pose2D(x=1.0, y=2.0, yaw=0.5)
    assert isinstance(script.mission.activity, UnderExploration)


def test_how_long_was_asked_for_is_passed_on() -> None:
    asked = PlainMotion("exploring", explores=True, explore_s=120.0)
    script = Script().robot(ORIGIN).feed(ev.MotionStarted("m1", "explore", asked))
    assert script.last(do.BeginExploration).duration_s == 120.0
    assert exploring().last(do.BeginExploration).duration_s is None


def test_on_the_dock_it_leaves_the_dock_first() -> None:
    script = exploring(docked=True)
    assert not script.asked(do.BeginExploration)
    script.feed(ev.Undocked(script.last(do.Undock).call)).see()
    assert len(script.asked(do.BeginExploration)) == 1


def test_a_robot_that_does_not_know_where_it_is_waits_for_it_and_gives_up_in_time() -> None:
    script = exploring(pose=None, lost_pose_s=20.0).wait(5.0)
    assert not script.asked(do.BeginExploration)
    assert waiting_for(script.mission, script.now_s) == "localisation: for 15 s at most"
    assert len(script.robot(ORIGIN).wait(0.5).asked(do.BeginExploration)) == 1
    lost = exploring(pose=None, lost_pose_s=20.0).wait(21.0)
    assert ended(lost) == (Outcome.ABORTED, EndCause.LOST)


def test_who_leads_it_and_why_are_lines_of_the_timeline() -> None:
    script = exploring()
    call = script.last(do.BeginExploration).call
    script.feed(ev.LeadChanged(call, ExplorationMode.FRONTIERS, "no answer for 11 s"))
    line = script.last(do.Say)
    assert (line.kind, line.text) == (EventKind.NAVIGATION, "exploring, frontiers: no answer for 11 s")
    assert script.mission.activity.call == call


@pytest.mark.parametrize(
    ("end", "ending"),
    [
        (E.EXPLORED, (Outcome.DONE, None)),
        (E.TIME_UP, (Outcome.DONE, None)),
        (E.MODEL_SILENT, (Outcome.ABORTED, EndCause.SERVICE)),
        (E.HOME_NOT_REACHED, (Outcome.ABORTED, EndCause.NAVIGATION)),
        (E.MOTION_FAILED, (Outcome.ABORTED, EndCause.SERVICE)),
        (E.ANOTHER_MAP, (Outcome.ABORTED, EndCause.MAP)),
        (E.STOPPED, (Outcome.ABORTED, EndCause.STOPPED)),
        (E.CANCELED, (Outcome.CANCELED, EndCause.PERSON)),
    ],
)
def test_each_end_of_it_is_an_ending(end: ExplorationEnd, ending: tuple[Outcome, EndCause | None]) -> None:
    script = over(exploring(), end)
    assert ended(script) == ending
    assert script.mission.state is MissionState.IDLE


def test_the_ending_says_what_was_done_and_found() -> None:
    script = exploring().see(box(label="chair"))
    over(script, E.EXPLORED, 12, calls=4, discoveries=("a red rug", "stairs down"))
    assert "12 drives and turns; the model was asked 4 times" in script.mission.reason
    assert "discovered: a red rug, stairs down; seen: red chair" in script.mission.reason


@pytest.mark.parametrize("for_s", [None, 30.0])
def test_a_pause_holds_it_and_it_goes_on_afterwards(for_s: float | None) -> None:
    script = exploring()
    first = script.last(do.BeginExploration).call
    script.feed(ev.PauseRequested(for_s))
    assert isinstance(script.mission.activity, Paused)
    assert isinstance(script.actions[-2], do.StopMotion)
    script.feed(ev.LeadChanged(first, ExplorationMode.LISTENING, "somebody speaks"))
    script.feed(ev.ExplorationEnded(first, E.EXPLORED, 3))
    assert isinstance(script.mission.activity, Paused), "what the held exploration says is too late"
    script.feed(ev.ResumeRequested()) if for_s is None else script.wait(31.0)
    assert len(script.asked(do.BeginExploration)) == 2
    assert script.mission.activity.call == script.last(do.BeginExploration).call != first


def test_the_emergency_stop_ends_it_and_a_reset_lets_nothing_go_on() -> None:
    script = exploring().feed(ev.StopLatched(1, "pressed"))
    assert ended(script) == (Outcome.ABORTED, EndCause.STOPPED)
    script.feed(ev.StopReset(1)).wait(5.0)
    assert (script.mission.state, len(script.asked(do.BeginExploration))) == (MissionState.IDLE, 1)


def test_it_ends_with_the_time_that_the_action_may_take() -> None:
    script = exploring().wait(301.0)
    assert ended(script) == (Outcome.ABORTED, EndCause.TIME_UP)
    assert isinstance(script.actions[-2], do.StopMotion)


@pytest.mark.parametrize(("actions", "all_known", "looks"), [(0, False, True), (1, True, True), (1, False, False)])
def test_where_no_map_had_anything_unknown_it_looks_though_it_moved(actions: int, all_known: bool, looks: bool) -> None:
    script = over(exploring(), E.EXPLORED, actions, all_known=all_known)
    assert (script.mission.outcome is None) is looks


@pytest.mark.parametrize("coverage", CoverageRule)
@pytest.mark.parametrize("scan", ScanRule)
def test_where_nothing_unknown_is_left_it_looks_from_place_to_place_and_says_what_it_saw(
    coverage: CoverageRule, scan: ScanRule
) -> None:
    script = over(exploring(coverage_rule=coverage, scan_rule=scan), E.EXPLORED, 0)
    place, planned = Pose2D(x=2.0, y=0.0, yaw=0.0), 0
    for _ in range(200):
        activity = type(script.mission.activity).__name__
        if activity == "Rotating":
            script.turned()
        elif activity == "AwaitingFrame":
            script.see(box(label="chair"))
        elif activity == "PlanningCoverage":
            script.feed(ev.CoverageLooked(0.9)).planned(*((place,) if planned == 0 else ()))
            planned += 1
        elif activity == "Navigating":
            script.arrived()
    assert ended(script) == (Outcome.DONE, None)
    assert "90 % of the free space searched from 2 places; seen: red chair" in script.mission.reason
    assert script.mission.search.visited[1] == place
