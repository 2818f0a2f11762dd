"""`step(mission, event, now_s) -> (mission, actions)`: all that the coordinator decides, as one pure function."""

from collections.abc import Callable
from types import ModuleType
from typing import assert_never

from contracts.mission import EndCause, EventKind, MissionKind, MissionState
from coordinator.core import actions as do
from coordinator.core import (
    approach,
    approach_straight,
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
    AwaitingFrame,
    CheckingPlace,
    ChoosingPath,
    Docking,
    Driving,
    Idle,
    Measuring,
    Navigating,
    Paused,
    PlanningCoverage,
    Rotating,
    Starting,
    Steering,
    Undocking,
    Validating,
    Waiting,
    Waking,
)  # fmt: skip
from coordinator.core.mission import Mission
from coordinator.core.outcomes import abort, give_up
from coordinator.core.plausibility import checked_arrival, is_of_now
from coordinator.core.rules import ApproachRule
from coordinator.core.step_context import StepContext

BEGINS_MAX = 40


def step(mission: Mission, event: ev.Event, now_s: float) -> tuple[Mission, tuple[do.Action, ...]]:
    """What `event` at `now_s` makes of the mission, and what is to be done about it.

    Pure: the same mission, event and time give the same answer. Raises `ForbiddenTransitionError` when the core would
    leave its table (a bug, which the property tests look for).
    """
    context = StepContext(mission, now_s)
    _apply(context, event)
    for _ in range(BEGINS_MAX):
        if not isinstance(context.mission.activity, Starting):
            break
        _begin(context)
    return context.mission, tuple(context.actions)


def _apply(context: StepContext, event: ev.Event) -> None:
    match event:
        case ev.RobotUpdated() | ev.StopLatched() | ev.StopReset():
            robot_updates.handle(context, event)
        case (
            ev.MissionStarted()
            | ev.DockingStarted()
            | ev.CancelRequested()
            | ev.PauseRequested()
            | ev.ResumeRequested()
        ):
            operator_commands.handle(context, event)
        case ev.CoverageLooked(share=share):
            if context.mission.running:
                context.update_search(explored_fraction=share)
        case ev.Tick():
            _tick(context)
        case ev.LeaseAnswered():
            _handle(context, event)
        case ev.DetectionsSeen(detections=seen):
            if is_of_now(context.mission, seen.stamp_s, context.now_s):
                _handle(context, event)
        case _:
            if _awaited(context, event.call):
                _answered(context, event)


def _answered(context: StepContext, event: ev.Answer) -> None:
    match event:
        case ev.CallFailed(service=service, detail=detail):
            _call_failed(context, service, detail, stopped=event.stopped)
        case ev.GoalEnded():
            context.update(failures=0)
            _handle(context, checked_arrival(context.mission, event))
        case ev.MotionEnded(end=end) if not end.completed:
            _handle(context, event)
        case _:
            context.update(failures=0)
            _handle(context, event)


def _awaited(context: StepContext, call: int) -> bool:
    """Answers to calls that were given up are too late."""
    return context.mission.running and call != 0 and context.mission.activity.call == call


# states


def _approach_module(context: StepContext) -> ModuleType:
    return approach if context.rules.approach_rule is ApproachRule.LOCALIZED else approach_straight


def _begin(context: StepContext) -> None:
    match context.mission.state:
        case MissionState.MEMORY_NAV if context.mission.kind is MissionKind.DOCK:
            docking.begin(context)
        case MissionState.MEMORY_NAV:
            search.begin_memory_nav(context)
        case MissionState.MOVING_TO_SCAN:
            search.begin_moving(context)
        case MissionState.SCANNING:
            scan.begin(context)
        case MissionState.CENTERING:
            centering.begin(context)
        case MissionState.DEPTH_CHECK:
            depth_check.begin(context)
        case MissionState.APPROACHING:
            _approach_module(context).begin(context)
        case MissionState.DRIVING_1M:
            step_drive.begin(context)
        case MissionState.IDLE | MissionState.DONE | MissionState.EMERGENCY_STOP:
            context.set_activity(Idle())
        case _:
            assert_never(context.mission.state)


def _handle(context: StepContext, event: ev.Event) -> None:
    match context.mission.state:
        case MissionState.MEMORY_NAV if context.mission.kind is MissionKind.DOCK:
            docking.handle(context, event)
        case MissionState.MEMORY_NAV | MissionState.MOVING_TO_SCAN:
            search.handle(context, event)
        case MissionState.SCANNING:
            scan.handle(context, event)
        case MissionState.CENTERING:
            centering.handle(context, event)
        case MissionState.DEPTH_CHECK:
            depth_check.handle(context, event)
        case MissionState.APPROACHING:
            _approach_module(context).handle(context, event)
        case MissionState.DRIVING_1M:
            step_drive.handle(context, event)
        case MissionState.IDLE | MissionState.DONE | MissionState.EMERGENCY_STOP:
            pass
        case _:
            assert_never(context.mission.state)


# time


def _tick(context: StepContext) -> None:
    mission, now = context.mission, context.now_s
    if mission.state is MissionState.DONE:
        if now >= mission.activity.until_s:
            context.transition_to(MissionState.IDLE, "the mission is over")
            context.set_activity(Idle())
        return
    if not mission.running:
        return
    if isinstance(mission.activity, Paused):
        if now >= mission.activity.until_s:
            abort(
                context,
                EndCause.STAYED_PAUSED,
                f"paused for more than {mission.rules.pause_timeout_s:.0f} s ({mission.activity.why})",
            )
        return
    if now >= mission.deadline_s:
        _out_of_time(context)
    elif now - max(mission.robot.received_s, mission.started_s) > mission.rules.robot_silent_s:
        abort(
            context,
            EndCause.BRIDGE_SILENT,
            f"no data from the robot for {mission.rules.robot_silent_s:.0f} s: robot_bridge or Redis is down",
        )
    elif now - max(mission.robot.localized_s, mission.started_s) > mission.rules.lost_pose_s:
        abort(
            context,
            EndCause.LOST,
            f"the robot has not known its position on the map for {mission.rules.lost_pose_s:.0f} s",
        )
    elif now >= mission.activity.until_s:
        _overdue(context)
    elif mission.state is MissionState.APPROACHING and now >= context.approach.until_s:
        approach.on_overtime(context)
    else:
        _handle(context, ev.Tick())


def _out_of_time(context: StepContext) -> None:
    why = f"time limit reached ({context.rules.mission_timeout_s:.0f} s)"
    if context.mission.kind is MissionKind.DOCK:
        abort(context, EndCause.TIME_UP, why)
    else:
        give_up(context, EndCause.TIME_UP, why)


def _overdue(context: StepContext) -> None:
    """The activity's own limit passed without what it waited for."""
    match context.mission.activity:
        case Waiting():
            context.set_activity(Starting())
        case Waking():
            context.log_event(
                EventKind.FAILURE,
                f"no camera picture {context.rules.wake_s_max:.0f} s after undocking: continuing without it",
            )
            search.awake(context)
        case AwaitingFrame():
            _look_timeouts()[context.mission.state](context)
        case Steering():
            module = step_drive if context.mission.state is MissionState.DRIVING_1M else approach_straight
            module.on_steering_end(context)
        case Rotating() | Driving() | Navigating() | Undocking() | Docking() | ChoosingPath():
            context.stop_motion()
            _call_failed(context, "robot_bridge", "no answer in time")
        case Measuring() | CheckingPlace():
            _call_failed(context, "robot_bridge", "no measurement in time")
        case Validating():
            _call_failed(context, "inference", "no validation in time")
        case PlanningCoverage():
            _call_failed(context, "robot_bridge", "no map in time")
        case Idle() | Starting() | Paused():
            pass
        case _:
            assert_never(context.mission.activity)


def _look_timeouts() -> dict[MissionState, Callable[[StepContext], None]]:
    return {
        MissionState.SCANNING: scan.on_look_timeout,
        MissionState.CENTERING: centering.on_look_timeout,
        MissionState.DEPTH_CHECK: depth_check.on_look_timeout,
        MissionState.APPROACHING: approach.on_look_timeout,
    }


def _call_failed(context: StepContext, service: str, detail: str, *, stopped: bool = False) -> None:
    """Waits and takes the state up again; many failures in a row end the mission, with the cause."""
    mission = context.mission
    if isinstance(mission.activity, Validating) and depth_check.given_up_judging(context, detail):
        return
    if mission.failures + 1 >= mission.rules.failures_max:
        abort(context, EndCause.SERVICE, f"{service} failed {mission.failures + 1} times in a row: {detail}")
        return
    if mission.kind is MissionKind.DOCK and docking.on_failure(context, detail):
        return
    if mission.state is MissionState.APPROACHING and isinstance(mission.activity, Measuring | Steering):
        context.update(failures=mission.failures + 1)
        _approach_module(context).on_failure(context)
        return
    searching = mission.kind is MissionKind.FIND
    driving = mission.state in {MissionState.MEMORY_NAV, MissionState.MOVING_TO_SCAN}
    if searching and driving and search.skip_after_failure(context):
        context.update(failures=mission.failures + 1)
        return
    context.retry_later(service, detail, stopped=stopped)
