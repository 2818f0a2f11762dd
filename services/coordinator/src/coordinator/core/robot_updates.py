"""What the bridge says: where the robot is, how far it drove, and the emergency stop (requirements A12, A14)."""

from dataclasses import replace
from typing import assert_never

from contracts.mission import EndCause, EventKind, MapTrouble, MissionState, Outcome
from coordinator.core import events as ev
from coordinator.core.activities import Nothing
from coordinator.core.geometry import distance_m
from coordinator.core.mission import Robot
from coordinator.core.outcomes import abort_for_the_map, close
from coordinator.core.reactions import lifted
from coordinator.core.step_context import Draft

ODOMETRY_JUMP_M = 0.5
ODOMETRY_STEP_M = 0.005
LATE_STATE_S = 1.0


def handle(draft: Draft, event: ev.RobotUpdated | ev.StopLatched | ev.StopReset) -> None:
    match event:
        case ev.RobotUpdated():
            _robot_updated(draft, event)
        case ev.StopLatched(epoch=epoch, reason=reason):
            _stopped(draft, epoch, reason)
        case ev.StopReset(epoch=epoch):
            _reset(draft, epoch)
        case _:
            assert_never(event)


def _stopped(draft: Draft, epoch: int, reason: str) -> None:
    """The bridge may tell of a stop before it knows why ('' then): the reason is written in when it comes."""
    draft.set(robot=replace(draft.mission.robot, stopped=True, epoch=epoch, epoch_s=draft.now_s))
    why = f"emergency stop: {reason}" if reason else "emergency stop"
    if draft.mission.state is MissionState.EMERGENCY_STOP:
        if reason and draft.mission.stop_unexplained:
            draft.set(stop_unexplained=False)
            close(draft, Outcome.ABORTED, why, EndCause.STOPPED, why)
            draft.say(EventKind.STOP, why)
        return
    draft.stop_motion()
    if draft.mission.running:
        close(draft, Outcome.ABORTED, why, EndCause.STOPPED, why)
        draft.set(candidate=None, approach=None, stop_unexplained=not reason)
        draft.say(EventKind.END, f"aborted: {why}", outcome=Outcome.ABORTED.value)
    draft.go(MissionState.EMERGENCY_STOP, why)
    draft.be(Nothing())


def _reset(draft: Draft, epoch: int) -> None:
    known = draft.mission.robot
    told_s = draft.now_s if epoch > known.epoch else known.epoch_s
    draft.set(robot=replace(known, stopped=False, epoch=epoch, epoch_s=told_s))
    if draft.mission.state is MissionState.EMERGENCY_STOP:
        draft.go(MissionState.IDLE, "the emergency stop was reset: idle, nothing resumes by itself")
        draft.be(Nothing())


def _robot_updated(draft: Draft, event: ev.RobotUpdated) -> None:
    mission = draft.mission
    missed_a_stop = mission.running and event.epoch > mission.epoch
    told_s = mission.robot.epoch_s
    if event.epoch < mission.robot.epoch and told_s is not None and draft.now_s - told_s < LATE_STATE_S:
        return  # published before a stop that is known already
    draft.set(
        robot=Robot(
            pose=event.pose,
            odometry=event.odometry,
            docked=event.docked,
            speed_m_s=event.speed_m_s,
            stopped=event.stopped,
            epoch=event.epoch,
            epoch_s=mission.robot.epoch_s,
            received_s=draft.now_s,
            offset_s=event.stamp_s - draft.now_s,
            localized_s=draft.now_s if event.pose is not None else mission.robot.localized_s,
            map_id=event.map_id or mission.robot.map_id,
            lifted_s=(mission.robot.lifted_s or draft.now_s) if event.lifted else None,
        )
    )
    _count_metres(draft)
    if event.stopped:
        _stopped(draft, event.epoch, event.stop_reason)
    elif missed_a_stop:
        _stopped(draft, event.epoch, "it came and went unseen")
    if not event.stopped:
        _reset(draft, event.epoch)
    _check_the_map(draft)
    _lifted(draft)


def _check_the_map(draft: Draft) -> None:
    """Its places, what it has looked at and where it stands mean nothing in another map."""
    mission = draft.mission
    if not mission.running or mission.robot.map_id is None:
        return
    if mission.map_id is None:
        draft.set(map_id=mission.robot.map_id)
    elif mission.map_id != mission.robot.map_id:
        abort_for_the_map(draft, MapTrouble.ANOTHER_MAP)


def _lifted(draft: Draft) -> None:
    """In whatever state it is: a robot that was carried must not drive off by itself when it is put down."""
    mission, since_s = draft.mission, draft.mission.robot.lifted_s
    lasts = since_s is not None and draft.now_s - since_s >= mission.rules.lifted_s
    if lasts and mission.running and not mission.paused:
        lifted(draft)


def _count_metres(draft: Draft) -> None:
    here, before = draft.mission.robot.odometry, draft.mission.metres_from
    if not draft.mission.running or here is None:
        return
    if before is None:
        draft.set(metres_from=here)
        return
    moved = distance_m(here, before)
    if moved >= ODOMETRY_STEP_M:
        counted = moved if moved < ODOMETRY_JUMP_M else 0.0
        draft.set(metres_from=here, metres_m=draft.mission.metres_m + counted)
