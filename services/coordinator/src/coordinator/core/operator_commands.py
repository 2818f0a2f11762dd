"""What a person asks of a mission: start, cancel, pause, resume (requirement A1)."""

from dataclasses import replace
from typing import assert_never

from contracts.intent import WantedAction
from contracts.mission import EndCause, EventKind, MissionKind, MissionState, Outcome
from coordinator.core import events as ev
from coordinator.core.activities import Paused, Starting
from coordinator.core.mission import Mission, Order, Search
from coordinator.core.outcomes import end
from coordinator.core.rules import CoverageRule
from coordinator.core.search import new_scan
from coordinator.core.step_context import StepContext


def handle(
    context: StepContext,
    event: ev.MissionStarted
    | ev.DockingStarted
    | ev.MotionStarted
    | ev.CancelRequested
    | ev.PauseRequested
    | ev.ResumeRequested,
) -> None:
    match event:
        case ev.MissionStarted():
            _start(context, event)
        case ev.DockingStarted():
            _start_docking(context, event)
        case ev.MotionStarted():
            _start_motion(context, event)
        case ev.CancelRequested():
            if context.mission.running:
                end(
                    context,
                    Outcome.CANCELED,
                    "cancelled by the operator",
                    EndCause.PERSON,
                    cause="requested by the operator",
                )
        case ev.PauseRequested():
            _pause(context, event.for_s)
        case ev.ResumeRequested():
            resume(context, "resumed by the operator")
        case _:
            assert_never(event)


def _start(context: StepContext, event: ev.MissionStarted) -> None:
    mission = context.mission
    if mission.state is not MissionState.IDLE:
        return
    by_belief = mission.rules.coverage_rule is CoverageRule.BELIEF
    context.mission = replace(
        _fresh(context, event.mission_id, event.order),
        command=event.command,
        target=event.target,
        parser=event.parser,
        action=event.action,
        last_seen=event.last_seen,
        area=event.area,
        elsewhere=event.elsewhere,
        search=Search(views=() if by_belief else event.views[: mission.rules.memory_views_max]),
    )
    notes = f"; {event.notes}" if event.notes else ""
    looking = f"looking for the {event.target.description} ({event.target.label})"
    looking += f" in {event.area.called} only" if event.area is not None else ""
    context.log_event(EventKind.START, f"'{event.command}': {looking}{notes}")
    if context.search.views:
        places = len(context.search.views)
        where = "one place: driving there" if places == 1 else f"{places} places: driving to the most likely first"
        context.transition_to(MissionState.MEMORY_NAV, f"seen before at {where}")
    elif by_belief:
        new_scan(context, f"weighing {len(event.clues)} clues of memory against what was never looked at")
    else:
        new_scan(context, "nothing remembered: looking around here first")


def _start_docking(context: StepContext, event: ev.DockingStarted) -> None:
    if context.mission.state is not MissionState.IDLE:
        return
    fresh = _fresh(context, event.mission_id, event.order)
    context.mission = replace(fresh, kind=MissionKind.DOCK, action=WantedAction.DOCK, command="dock")
    context.log_event(EventKind.START, f"to the dock: {event.why}")
    context.transition_to(MissionState.MEMORY_NAV, "the dock is a remembered place: driving there")


def _start_motion(context: StepContext, event: ev.MotionStarted) -> None:
    if context.mission.state is not MissionState.IDLE:
        return
    fresh, limit_s = _fresh(context, event.mission_id, event.order), event.motion.limit_s
    context.mission = replace(
        fresh,
        kind=MissionKind.MOVE,
        action=event.motion.action,
        command=event.command,
        motion=event.motion,
        deadline_s=fresh.deadline_s if limit_s is None else min(fresh.deadline_s, context.now_s + limit_s),
    )
    context.log_event(EventKind.START, event.motion.what)
    if event.motion.explores:
        context.transition_to(MissionState.EXPLORING, "going to what the map does not show yet")
    else:
        context.transition_to(MissionState.MOVING, "doing what was asked for")


def _fresh(context: StepContext, mission_id: str, order: Order) -> Mission:
    """A mission that begins now, with nothing of the one before but what is known of the robot."""
    before = context.mission
    return Mission(
        rules=before.rules,
        robot=before.robot,
        calls=before.calls,
        id=mission_id,
        order=order,
        epoch=before.robot.epoch,
        started_s=context.now_s,
        deadline_s=context.now_s + before.rules.mission_timeout_s,
        metres_from=before.robot.odometry,
        map_id=before.robot.map_id,
    )


def resume(context: StepContext, why: str) -> None:
    """Takes the state up again it was paused in; nothing where it is not paused."""
    paused = context.mission.activity
    if not context.mission.running or not isinstance(paused, Paused):
        return
    context.update(deadline_s=context.mission.deadline_s + context.now_s - paused.since_s)
    context.log_event(EventKind.RESUME, f"{why} in {context.mission.state.value}")
    context.set_activity(Starting())


def _pause(context: StepContext, for_s: float | None) -> None:
    """A pause that a person asked for outlasts one for a time, and is neither shortened nor ended by it."""
    activity = context.mission.activity
    paused = activity if isinstance(activity, Paused) else None
    if not context.mission.running or (paused is not None and not paused.resumes):
        return
    if for_s is None:
        context.pause(f"paused by the operator while {context.mission.state.value}")
    elif paused is not None and for_s == 0.0:
        resume(context, "nobody speaks to it any more: going on")
    elif paused is not None:
        context.set_activity(replace(paused, until_s=context.now_s + for_s))
    elif for_s > 0.0:
        context.pause(f"standing still to listen, while {context.mission.state.value}", for_s=for_s)
