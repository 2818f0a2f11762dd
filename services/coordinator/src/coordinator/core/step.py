"""`step(mission, event, now_s) -> (mission, actions)`: all that the coordinator decides, as one pure function."""

from typing import assert_never

from contracts.mission import EndCause, EventKind, MissionKind, MissionState
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core import operator_commands, robot_updates
from coordinator.core.activities import (
    AwaitingFrame,
    BeingExplored,
    Docking,
    Driving,
    Idle,
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
from coordinator.core.outcomes import abort, give_up, retry_or_abort
from coordinator.core.plausibility import checked_arrival, is_of_now
from coordinator.core.search import undock_first, undocked
from coordinator.core.states.table import state_of
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
        if not undock_first(context):
            state_of(context.mission).begin(context)
    return context.mission, tuple(context.actions)


def _apply(context: StepContext, event: ev.Event) -> None:
    match event:
        case ev.RobotUpdated() | ev.StopLatched() | ev.StopReset():
            robot_updates.handle(context, event)
        case (
            ev.MissionStarted()
            | ev.DockingStarted()
            | ev.MotionStarted()
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
            state_of(context.mission).handle(context, event)
        case ev.DetectionsSeen(detections=seen):
            if not is_of_now(context.mission, seen.stamp_s, context.now_s):
                return
            if isinstance(context.mission.activity, Waking):
                context.set_activity(Starting())
            else:
                state_of(context.mission).handle(context, event)
        case _:
            if _awaited(context, event.call):
                _answered(context, event)


def _answered(context: StepContext, event: ev.Answer) -> None:
    match event:
        case ev.CallFailed(service=service, detail=detail) if event.call == context.mission.activity.call:
            _call_failed(context, service, detail, stopped=event.stopped)
        case ev.CallFailed():
            state_of(context.mission).handle(context, event)
        case ev.GoalEnded():
            context.update(failures=0)
            state_of(context.mission).handle(context, checked_arrival(context.mission, event))
        case ev.Undocked():
            context.update(failures=0)
            undocked(context)
        case ev.MotionEnded(end=end) if not end.completed:
            state_of(context.mission).handle(context, event)
        case _:
            context.update(failures=0)
            state_of(context.mission).handle(context, event)


def _awaited(context: StepContext, call: int) -> bool:
    """Answers to calls that were given up are too late."""
    awaited = {context.mission.activity.call, context.approach.votes_call}
    return context.mission.running and call != 0 and call in awaited


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
        if now >= mission.activity.until_s and mission.activity.resumes:
            operator_commands.resume(context, "nobody said more: going on")
        elif now >= mission.activity.until_s:
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
    else:
        state_of(context.mission).handle(context, ev.Tick())


def _out_of_time(context: StepContext) -> None:
    mission = context.mission
    why = f"time limit reached ({mission.deadline_s - mission.started_s:.0f} s)"
    if context.mission.kind is not MissionKind.FIND:
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
            context.set_activity(Starting())
        case AwaitingFrame() | Steering():
            state_of(context.mission).on_timeout(context)
        case Rotating() | Driving() | Navigating() | Undocking() | Docking():
            context.stop_motion()
            _call_failed(context, "robot_bridge", "no answer in time")
        case Validating():
            _call_failed(context, "inference", "no validation in time")
        case PlanningCoverage():
            _call_failed(context, "robot_bridge", "no map in time")
        case Idle() | Starting() | Paused() | BeingExplored():
            pass
        case _:
            assert_never(context.mission.activity)


def _call_failed(context: StepContext, service: str, detail: str, *, stopped: bool = False) -> None:
    judging = isinstance(context.mission.activity, Validating)  # its own number of tries comes first
    last = context.mission.failures + 1 >= context.rules.failures_max
    if (last and not judging) or not state_of(context.mission).on_call_failed(context, detail):
        retry_or_abort(context, service, detail, stopped=stopped)
