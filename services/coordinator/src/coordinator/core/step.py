"""`step(mission, event, now_s) -> (mission, actions)`: all that the coordinator decides, as one pure function."""

from collections.abc import Callable
from types import ModuleType
from typing import assert_never

from contracts.mission import EndCause, EventKind, MissionKind, MissionState
from coordinator.core import actions as do
from coordinator.core import (
    approach,
    approach_seeds,
    centering,
    depth_check,
    docking,
    operator_commands,
    robot_updates,
    scan,
    search,
    step_drive,
)
from coordinator.core import events as ev
from coordinator.core.activities import (
    CheckingPlace,
    ChoosingPath,
    Docking,
    Driving,
    Entering,
    Going,
    Looking,
    Measuring,
    Nothing,
    Paused,
    PlanningCoverage,
    Steering,
    Turning,
    Undocking,
    Validating,
    Waiting,
    Waking,
)  # fmt: skip
from coordinator.core.mission import Mission
from coordinator.core.outcomes import abort, give_up
from coordinator.core.plausibility import checked_arrival, is_of_now
from coordinator.core.rules import ApproachRule
from coordinator.core.step_context import Draft

BEGINS_MAX = 40


def step(mission: Mission, event: ev.Event, now_s: float) -> tuple[Mission, tuple[do.Action, ...]]:
    """What `event` at `now_s` makes of the mission, and what is to be done about it.

    Pure: the same mission, event and time give the same answer. Raises `ForbiddenTransitionError` when the core would
    leave its table (a bug, which the property tests look for).
    """
    draft = Draft(mission, now_s)
    _apply(draft, event)
    for _ in range(BEGINS_MAX):
        if not isinstance(draft.mission.activity, Entering):
            break
        _begin(draft)
    return draft.mission, tuple(draft.actions)


def _apply(draft: Draft, event: ev.Event) -> None:
    match event:
        case ev.RobotUpdated() | ev.StopLatched() | ev.StopReset():
            robot_updates.handle(draft, event)
        case ev.MissionStarted() | ev.DockingStarted() | ev.CancelAsked() | ev.PauseAsked() | ev.ResumeAsked():
            operator_commands.handle(draft, event)
        case ev.CoverageLooked(share=share):
            if draft.mission.running:
                draft.set_search(share=share)
        case ev.Tick():
            _tick(draft)
        case ev.LeaseAnswered():
            _handle(draft, event)
        case ev.DetectionsSeen(detections=seen):
            if is_of_now(draft.mission, seen.stamp_s, draft.now_s):
                _handle(draft, event)
        case _:
            if _awaited(draft, event.call):
                _answered(draft, event)


def _answered(draft: Draft, event: ev.Answer) -> None:
    match event:
        case ev.CallFailed(service=service, detail=detail):
            _call_failed(draft, service, detail, stopped=event.stopped)
        case ev.GoalEnded():
            draft.set(failures=0)
            _handle(draft, checked_arrival(draft.mission, event))
        case ev.MotionEnded(end=end) if not end.completed:
            _handle(draft, event)
        case _:
            draft.set(failures=0)
            _handle(draft, event)


def _awaited(draft: Draft, call: int) -> bool:
    """Answers to calls that were given up are too late."""
    return draft.mission.running and call != 0 and draft.mission.activity.call == call


# states


def _approach_module(draft: Draft) -> ModuleType:
    return approach if draft.rules.approach_rule is ApproachRule.LOCALIZED else approach_seeds


def _begin(draft: Draft) -> None:
    match draft.mission.state:
        case MissionState.MEMORY_NAV if draft.mission.kind is MissionKind.DOCK:
            docking.begin(draft)
        case MissionState.MEMORY_NAV:
            search.begin_memory_nav(draft)
        case MissionState.MOVING_TO_SCAN:
            search.begin_moving(draft)
        case MissionState.SCANNING:
            scan.begin(draft)
        case MissionState.CENTERING:
            centering.begin(draft)
        case MissionState.DEPTH_CHECK:
            depth_check.begin(draft)
        case MissionState.APPROACHING:
            _approach_module(draft).begin(draft)
        case MissionState.DRIVING_1M:
            step_drive.begin(draft)
        case MissionState.IDLE | MissionState.DONE | MissionState.EMERGENCY_STOP:
            draft.be(Nothing())
        case _:
            assert_never(draft.mission.state)


def _handle(draft: Draft, event: ev.Event) -> None:
    match draft.mission.state:
        case MissionState.MEMORY_NAV if draft.mission.kind is MissionKind.DOCK:
            docking.handle(draft, event)
        case MissionState.MEMORY_NAV | MissionState.MOVING_TO_SCAN:
            search.handle(draft, event)
        case MissionState.SCANNING:
            scan.handle(draft, event)
        case MissionState.CENTERING:
            centering.handle(draft, event)
        case MissionState.DEPTH_CHECK:
            depth_check.handle(draft, event)
        case MissionState.APPROACHING:
            _approach_module(draft).handle(draft, event)
        case MissionState.DRIVING_1M:
            step_drive.handle(draft, event)
        case MissionState.IDLE | MissionState.DONE | MissionState.EMERGENCY_STOP:
            pass
        case _:
            assert_never(draft.mission.state)


# time


def _tick(draft: Draft) -> None:
    mission, now = draft.mission, draft.now_s
    if mission.state is MissionState.DONE:
        if now >= mission.activity.until_s:
            draft.go(MissionState.IDLE, "the mission is over")
            draft.be(Nothing())
        return
    if not mission.running:
        return
    if isinstance(mission.activity, Paused):
        if now >= mission.activity.until_s:
            abort(
                draft,
                EndCause.STAYED_PAUSED,
                f"it stayed paused for {mission.rules.pause_timeout_s:.0f} s ({mission.activity.why})",
            )
        return
    if now >= mission.deadline_s:
        _out_of_time(draft)
    elif now - max(mission.robot.received_s, mission.started_s) > mission.rules.robot_silent_s:
        abort(
            draft,
            EndCause.BRIDGE_SILENT,
            f"robot_bridge has said nothing for {mission.rules.robot_silent_s:.0f} s: it or Redis is away",
        )
    elif now - max(mission.robot.localized_s, mission.started_s) > mission.rules.lost_pose_s:
        abort(
            draft, EndCause.LOST, f"the robot has not known its place in the map for {mission.rules.lost_pose_s:.0f} s"
        )
    elif now >= mission.activity.until_s:
        _overdue(draft)
    elif mission.state is MissionState.APPROACHING and now >= draft.approach.until_s:
        approach.on_overtime(draft)
    else:
        _handle(draft, ev.Tick())


def _out_of_time(draft: Draft) -> None:
    why = f"the time is up ({draft.rules.mission_timeout_s:.0f} s)"
    if draft.mission.kind is MissionKind.DOCK:
        abort(draft, EndCause.TIME_UP, why)
    else:
        give_up(draft, EndCause.TIME_UP, why)


def _overdue(draft: Draft) -> None:
    """The activity's own limit passed without what it waited for."""
    match draft.mission.activity:
        case Waiting():
            draft.be(Entering())
        case Waking():
            draft.say(
                EventKind.FAILURE,
                f"no picture came for {draft.rules.wake_s_max:.0f} s after the dock: going on without one",
            )
            search.awake(draft)
        case Looking():
            _look_timeouts()[draft.mission.state](draft)
        case Steering():
            module = step_drive if draft.mission.state is MissionState.DRIVING_1M else approach_seeds
            module.on_steering_end(draft)
        case Turning() | Driving() | Going() | Undocking() | Docking() | ChoosingPath():
            draft.stop_motion()
            _call_failed(draft, "robot_bridge", "no answer in time")
        case Measuring() | CheckingPlace():
            _call_failed(draft, "robot_bridge", "no measurement in time")
        case Validating():
            _call_failed(draft, "inference", "no validation in time")
        case PlanningCoverage():
            _call_failed(draft, "robot_bridge", "no map in time")
        case Nothing() | Entering() | Paused():
            pass
        case _:
            assert_never(draft.mission.activity)


def _look_timeouts() -> dict[MissionState, Callable[[Draft], None]]:
    return {
        MissionState.SCANNING: scan.on_look_timeout,
        MissionState.CENTERING: centering.on_look_timeout,
        MissionState.DEPTH_CHECK: depth_check.on_look_timeout,
        MissionState.APPROACHING: approach.on_look_timeout,
    }


def _call_failed(draft: Draft, service: str, detail: str, *, stopped: bool = False) -> None:
    """Waits and takes the state up again; many failures in a row end the mission, with the cause."""
    mission = draft.mission
    if isinstance(mission.activity, Validating) and depth_check.given_up_judging(draft, detail):
        return
    if mission.failures + 1 >= mission.rules.failures_max:
        abort(draft, EndCause.SERVICE, f"{service} failed {mission.failures + 1} times in a row: {detail}")
        return
    if mission.kind is MissionKind.DOCK and docking.on_failure(draft, detail):
        return
    if mission.state is MissionState.APPROACHING and isinstance(mission.activity, Measuring | Steering):
        draft.set(failures=mission.failures + 1)
        _approach_module(draft).on_failure(draft)
        return
    searching = mission.kind is MissionKind.FIND
    driving = mission.state in {MissionState.MEMORY_NAV, MissionState.MOVING_TO_SCAN}
    if searching and driving and search.skip_after_failure(draft):
        draft.set(failures=mission.failures + 1)
        return
    draft.fail(service, detail, stopped=stopped)
