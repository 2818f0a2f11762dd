"""Cancel, pause, resume, the emergency stop, a silent robot: from every state, and nothing resumes by itself."""

from collections.abc import Callable

import pytest

from contracts.causes import GoalCause
from contracts.geometry import Pose2D
from contracts.mission import EventKind, MissionState, Outcome
from contracts.motion import MotionEnd
from contracts.robot import GoalStatus
from contracts.vision import Verdict
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core.actions import MOTION
from support.mission_script import Script, box

S = MissionState
VIEW = Pose2D(x=3.0, y=0.0, yaw=1.0)


def exploring() -> Script:
    script = Script().begin(VIEW).unreachable()
    for _ in range(11):
        script.see()
        if isinstance(script.actions[-1], do.Rotate):
            script.turned()
    return script.planned(VIEW, Pose2D(x=1.0, y=1.0, yaw=0.0))


REACH: dict[MissionState, Callable[[], Script]] = {
    S.MEMORY_NAV: lambda: Script().begin(VIEW),
    S.SCANNING: lambda: Script().begin(),
    S.MOVING_TO_SCAN: exploring,
    S.CENTERING: lambda: Script().begin().see(box(40)).see(box(40)),
    S.DEPTH_CHECK: lambda: Script().begin().centred(),
    S.APPROACHING: lambda: Script().begin().centred().measured(1.2, 3).voted(Verdict.YES),
    S.DRIVING_1M: lambda: Script().begin().centred().measured(2.8),
}


@pytest.mark.parametrize("state", REACH)
def test_a_stop_reaches_every_running_state_and_aborts_the_mission(state: MissionState) -> None:
    script = REACH[state]()
    assert script.mission.state is state
    script.feed(ev.StopLatched(1, "a person pressed it"))
    assert script.mission.state is S.EMERGENCY_STOP
    assert script.mission.outcome is Outcome.ABORTED
    assert "a person pressed it" in script.mission.reason


@pytest.mark.parametrize("state", REACH)
def test_after_a_reset_it_is_idle_and_asks_for_no_motion(state: MissionState) -> None:
    script = REACH[state]().feed(ev.StopLatched(1, "stop"))
    before = len([a for a in script.actions if isinstance(a, MOTION)])
    script.feed(ev.StopReset(1)).wait(5.0)
    assert script.mission.state is S.IDLE
    assert len([a for a in script.actions if isinstance(a, MOTION)]) == before


@pytest.mark.parametrize("state", REACH)
def test_cancel_ends_it_at_once_and_stops(state: MissionState) -> None:
    script = REACH[state]().feed(ev.CancelRequested())
    assert script.mission.outcome is Outcome.CANCELED
    assert script.mission.state is S.IDLE
    assert isinstance(script.asked(do.StopMotion)[-1], do.StopMotion)


@pytest.mark.parametrize("state", REACH)
def test_a_pause_stops_and_resume_goes_on_in_the_same_state(state: MissionState) -> None:
    script = REACH[state]().feed(ev.PauseRequested())
    assert script.mission.paused
    asked = len([a for a in script.actions if isinstance(a, MOTION)])
    script.wait(2.0).see(box(20))
    assert len([a for a in script.actions if isinstance(a, MOTION)]) == asked
    assert script.mission.state is state
    script.feed(ev.ResumeRequested())
    assert not script.mission.paused
    assert script.mission.running


@pytest.mark.parametrize("state", REACH)
def test_a_pause_to_listen_ends_by_itself_in_the_same_state(state: MissionState) -> None:
    script = REACH[state]().feed(ev.PauseRequested(5.0))
    assert script.mission.listening
    assert isinstance(script.asked(do.StopMotion)[-1], do.StopMotion)
    script.wait(4.5)
    assert script.mission.paused
    script.wait(0.7)
    assert not script.mission.paused
    assert [line.state for line in script.asked(do.Say) if line.kind is EventKind.RESUME] == [state]


def test_who_speaks_on_holds_it_for_longer_and_one_line_tells_of_it() -> None:
    script = Script().begin()
    before = script.mission.deadline_s
    script.feed(ev.PauseRequested(5.0)).wait(4.0).feed(ev.PauseRequested(5.0)).wait(4.0)
    assert script.mission.listening
    assert [line.kind for line in script.asked(do.Say)].count(EventKind.PAUSE) == 1
    script.feed(ev.PauseRequested(0.0))
    assert not script.mission.paused
    assert script.mission.deadline_s == pytest.approx(before + 8.0, abs=0.2)


def test_a_pause_that_a_person_asked_for_outlasts_one_to_listen() -> None:
    script = Script().begin().feed(ev.PauseRequested(5.0)).feed(ev.PauseRequested())
    script.feed(ev.PauseRequested(0.0)).feed(ev.PauseRequested(5.0)).wait(30.0)
    assert script.mission.paused
    assert not script.mission.listening


def test_nothing_is_let_go_that_is_not_held() -> None:
    script = Script().begin()
    lines = len(script.asked(do.Say))
    script.feed(ev.PauseRequested(0.0))
    assert not script.mission.paused
    assert len(script.asked(do.Say)) == lines


@pytest.mark.parametrize("state", REACH)
def test_lifted_while_it_listens_it_stands_until_a_person_says(state: MissionState) -> None:
    script = REACH[state]().feed(ev.PauseRequested(5.0))

    def hangs(lifted: bool) -> None:
        pose = script.mission.robot.pose
        script.feed(ev.RobotUpdated(script.now_s, pose, pose, False, 0.0, False, 0, lifted=lifted))

    hangs(True)
    script.now_s += script.mission.rules.lifted_s
    hangs(True)
    hangs(False)
    asked = len([a for a in script.actions if isinstance(a, MOTION)])
    script.wait(6.0).feed(ev.PauseRequested(0.0))
    assert script.mission.paused
    assert not script.mission.listening
    assert len([a for a in script.actions if isinstance(a, MOTION)]) == asked
    assert not script.feed(ev.ResumeRequested()).mission.paused


def test_listening_undoes_no_stop() -> None:
    script = Script().begin().feed(ev.PauseRequested(5.0)).feed(ev.StopLatched(1, "test")).feed(ev.PauseRequested(0.0))
    assert script.mission.state is S.EMERGENCY_STOP
    assert not script.mission.running


def test_time_spent_paused_does_not_count_against_the_deadline() -> None:
    script = Script().begin()
    before = script.mission.deadline_s
    script.feed(ev.PauseRequested()).wait(30.0).feed(ev.ResumeRequested())
    assert script.mission.deadline_s == pytest.approx(before + 30.0)


def test_a_mission_paused_for_too_long_is_aborted() -> None:
    script = Script(pause_timeout_s=5.0).begin().feed(ev.PauseRequested()).wait(5.2)
    assert script.mission.outcome is Outcome.ABORTED


def test_a_stop_that_came_and_went_unseen_still_aborts() -> None:
    script = Script().begin().robot(epoch=1)
    assert script.mission.outcome is Outcome.ABORTED
    assert script.mission.state is S.IDLE


def test_a_stop_seen_only_after_its_reset_is_not_explained_by_the_reset() -> None:
    script = Script().begin().robot(epoch=1, reason="RESUME confirmed")
    assert script.mission.reason == "emergency stop: it came and went unseen"


def test_why_it_was_stopped_is_written_in_when_it_becomes_known() -> None:
    script = Script().begin().feed(ev.StopLatched(1, ""))
    assert (script.mission.state, script.mission.outcome) == (S.EMERGENCY_STOP, Outcome.ABORTED)
    assert script.mission.reason == "emergency stop"
    said = len(script.asked(do.Say))
    for _ in range(2):
        script.feed(ev.StopLatched(1, "Esc pressed"))
    assert script.mission.reason == "emergency stop: Esc pressed"
    assert script.mission.report is not None
    assert script.mission.report.text == "emergency stop: Esc pressed"
    assert [one.text for one in script.asked(do.Say)[said:]] == ["emergency stop: Esc pressed"]


def test_a_later_stop_does_not_rewrite_why_the_mission_ended() -> None:
    script = Script().begin().feed(ev.StopLatched(1, "Esc pressed")).feed(ev.StopLatched(2, "curl"))
    assert script.mission.reason == "emergency stop: Esc pressed"


def test_a_state_published_before_the_stop_does_not_lift_it() -> None:
    script = Script().begin().feed(ev.StopLatched(1, "stop")).robot(epoch=0)
    assert script.mission.state is S.EMERGENCY_STOP


def test_while_stopped_no_mission_begins() -> None:
    script = Script().feed(ev.StopLatched(1, "stop")).begin()
    assert script.mission.state is S.EMERGENCY_STOP
    assert not script.mission.running


def test_a_second_mission_is_not_begun_while_one_runs() -> None:
    script = Script().begin()
    script.feed(ev.MissionStarted("m2", "x", script.mission.target, "rules", ()))  # type: ignore[arg-type]
    assert script.mission.id == "m1"


def test_done_becomes_idle_after_two_seconds_and_the_outcome_stays() -> None:
    script = Script().begin().centred().measured(0.4, 3).voted(Verdict.YES)
    assert script.mission.state is S.DONE
    assert len(script.asked(do.Celebrate)) == 1
    assert script.wait(1.8).mission.state is S.DONE
    assert script.wait(0.4).mission.state is S.IDLE
    assert script.mission.outcome is Outcome.FOUND


def test_a_robot_that_falls_silent_aborts_the_mission() -> None:
    script = Script(robot_silent_s=3.0).begin()
    for _ in range(40):
        script.now_s += 0.1
        script.feed(ev.Tick())
    assert script.mission.outcome is Outcome.ABORTED
    assert "robot_bridge" in script.mission.reason


def test_answers_to_calls_given_up_are_ignored() -> None:
    script = Script().begin(VIEW)
    late = script.last(do.Navigate).call
    script.feed(ev.PauseRequested()).feed(ev.ResumeRequested())
    assert script.feed(ev.CallFailed(late, "robot_bridge", "late")).mission.failures == 0


def test_a_call_without_an_answer_is_given_up_in_time() -> None:
    script = Script(turn_timeout_s=2.0).begin().see().wait(5.5)
    assert "no answer in time" in script.said()
    assert script.mission.running


def test_metres_are_counted_by_odometry_and_jumps_are_not() -> None:
    script = Script().begin()
    for x in (0.1, 0.2, 0.3):
        script.robot(Pose2D(x=x, y=0.0, yaw=0.0))
    script.robot(Pose2D(x=9.0, y=0.0, yaw=0.0)).robot(Pose2D(x=9.1, y=0.0, yaw=0.0))
    assert script.mission.metres_m == pytest.approx(0.4)


@pytest.mark.parametrize("state", [S.MEMORY_NAV, S.MOVING_TO_SCAN, S.APPROACHING])
def test_a_goal_that_a_stop_cancelled_is_not_said_to_be_tried_again(state: MissionState) -> None:
    script = REACH[state]()
    call = script.last(do.Navigate).call
    script.feed(ev.GoalEnded(call, GoalStatus.CANCELED, cause=GoalCause.STOPPED)).feed(ev.StopLatched(1, "a person"))
    assert "navigation: cut off by the emergency stop" in script.said()
    assert "trying again" not in script.said()
    assert script.mission.reason == "emergency stop: a person"


@pytest.mark.parametrize("state", [S.SCANNING, S.APPROACHING])
def test_a_motion_that_a_stop_cut_off_is_not_said_to_be_tried_again(state: MissionState) -> None:
    script = {
        S.SCANNING: lambda: REACH[S.SCANNING]().see(),
        S.APPROACHING: lambda: REACH[S.APPROACHING]().arrived().wait(3.0),
    }[state]()
    assert script.mission.state is state
    script.feed(ev.MotionEnded(script.mission.activity.call, MotionEnd.STOPPED, turned_rad=0.1))
    assert "robot_bridge: " in script.said()
    assert "trying again" not in script.said()
    script.wait(1.0)
    assert script.mission.running
