"""What the bridge says: where the robot is, how far it drove, and the emergency stop (requirements A12, A14)."""

from dataclasses import replace
from typing import assert_never

from contracts.mission import EndCause, EventFacts, EventKind, MapTrouble, MissionState, Outcome
from coordinator.core import events as ev
from coordinator.core.activities import Idle
from coordinator.core.mission import RobotSnapshot
from coordinator.core.outcomes import abort_for_the_map, close
from coordinator.core.reactions import lifted
from coordinator.core.step_context import StepContext
from geometry.poses import apart_m

ODOMETRY_JUMP_M = 0.5
ODOMETRY_STEP_M = 0.005
LATE_STATE_S = 1.0


def handle(context: StepContext, event: ev.RobotUpdated | ev.StopLatched | ev.StopReset) -> None:
    match event:
        case ev.RobotUpdated():
            _robot_updated(context, event)
        case ev.StopLatched(epoch=epoch, reason=reason):
            _stopped(context, epoch, reason)
        case ev.StopReset(epoch=epoch):
            _reset(context, epoch)
        case _:
            assert_never(event)


def _stopped(context: StepContext, epoch: int, reason: str) -> None:
    """The bridge may tell of a stop before it knows why ('' then): the reason is written in when it comes."""
    context.update(robot=replace(context.mission.robot, stopped=True, epoch=epoch, epoch_s=context.now_s))
    why = f"emergency stop: {reason}" if reason else "emergency stop"
    if context.mission.state is MissionState.EMERGENCY_STOP:
        if reason and context.mission.stop_unexplained:
            context.update(stop_unexplained=False)
            close(context, Outcome.ABORTED, why, EndCause.STOPPED, why)
            context.log_event(EventKind.STOP, why)
        return
    context.stop_motion()
    if context.mission.running:
        close(context, Outcome.ABORTED, why, EndCause.STOPPED, why)
        context.update(candidate=None, approach=None, stop_unexplained=not reason)
        context.log_event(EventKind.END, f"aborted: {why}", EventFacts(outcome=Outcome.ABORTED))
    context.transition_to(MissionState.EMERGENCY_STOP, why)
    context.set_activity(Idle())


def _reset(context: StepContext, epoch: int) -> None:
    known = context.mission.robot
    told_s = context.now_s if epoch > known.epoch else known.epoch_s
    context.update(robot=replace(known, stopped=False, epoch=epoch, epoch_s=told_s))
    if context.mission.state is MissionState.EMERGENCY_STOP:
        context.transition_to(
            MissionState.IDLE, "emergency stop reset: the robot is idle and nothing resumes by itself"
        )
        context.set_activity(Idle())


def _robot_updated(context: StepContext, event: ev.RobotUpdated) -> None:
    mission = context.mission
    missed_a_stop = mission.running and event.epoch > mission.epoch
    told_s = mission.robot.epoch_s
    if event.epoch < mission.robot.epoch and told_s is not None and context.now_s - told_s < LATE_STATE_S:
        return  # published before a stop that is known already
    context.update(
        robot=RobotSnapshot(
            pose=event.pose,
            odometry=event.odometry,
            docked=event.docked,
            speed_m_s=event.speed_m_s,
            stopped=event.stopped,
            epoch=event.epoch,
            epoch_s=mission.robot.epoch_s,
            received_s=context.now_s,
            offset_s=event.stamp_s - context.now_s,
            localized_s=context.now_s if event.pose is not None else mission.robot.localized_s,
            map_id=event.map_id or mission.robot.map_id,
            lifted_s=(mission.robot.lifted_s or context.now_s) if event.lifted else None,
        )
    )
    _count_metres(context)
    if event.stopped:
        _stopped(context, event.epoch, event.stop_reason)
    elif missed_a_stop:
        _stopped(context, event.epoch, "it came and went unseen")
    if not event.stopped:
        _reset(context, event.epoch)
    _check_the_map(context)
    _lifted(context)


def _check_the_map(context: StepContext) -> None:
    """Its places, what it has looked at and where it stands mean nothing in another map."""
    mission = context.mission
    if not mission.running or mission.robot.map_id is None:
        return
    places_of = mission.motion.map_id if mission.motion is not None else None
    begun_in = mission.map_id or places_of  # it may have begun before the robot's first map was told
    if begun_in is None or begun_in == mission.robot.map_id:
        context.update(map_id=mission.robot.map_id)
    else:
        abort_for_the_map(context, MapTrouble.ANOTHER_MAP)


def _lifted(context: StepContext) -> None:
    """In whatever state it is: a robot that was carried must not drive off by itself when it is put down, nor when a
    pause to listen, which ends by itself, is over.
    """
    mission, since_s = context.mission, context.mission.robot.lifted_s
    lasts = since_s is not None and context.now_s - since_s >= mission.rules.lifted_s
    if lasts and mission.running and (not mission.paused or mission.listening):
        lifted(context)


def _count_metres(context: StepContext) -> None:
    here, before = context.mission.robot.odometry, context.mission.metres_from
    if not context.mission.running or here is None:
        return
    if before is None:
        context.update(metres_from=here)
        return
    moved = apart_m(here, before)
    if moved >= ODOMETRY_STEP_M:
        counted = moved if moved < ODOMETRY_JUMP_M else 0.0
        context.update(metres_from=here, metres_m=context.mission.metres_m + counted)
