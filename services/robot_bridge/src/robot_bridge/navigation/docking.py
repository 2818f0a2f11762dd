"""Onto the dock and off it: first in front of the dock with Nav2, then the base by itself (requirement A15)."""

import asyncio
from collections.abc import Coroutine
from enum import StrEnum
from pathlib import Path
from typing import Any

import structlog
from pydantic import Field

from contracts.causes import GoalCause, Refusal
from contracts.geometry import Pose2D
from contracts.motion import BaseEnd, BaseReply
from contracts.robot import CandidatePose, GoalRequest, GoalStatus
from geometry.poses import apart_m, compose
from mesh.clock import Clock
from mesh.errors import ConflictError
from robot_bridge.motion.velocity_mux import VelocityMux
from robot_bridge.navigation.dock_pose import DockPose
from robot_bridge.navigation.goal_executor import GoalExecutor, refuse_while_navigating
from robot_bridge.navigation.initial_pose import InitialPose
from robot_bridge.navigation.map_book import MapBook
from robot_bridge.ports import Robot
from robot_bridge.sensing.snapshot import AgeLimits, Snapshot, take_snapshot

log = structlog.get_logger()

NEAR_M = 0.35
RING_M = 0.3


class DockingLimits(AgeLimits):
    dock_timeout_s: float = Field(default=90.0, gt=0.0, description="the way to the dock included")
    dock_look_s_max: float = Field(default=3.0, ge=0.0, description="for the base to see the dock it stands before")
    dock_pose: Pose2D | None = Field(default=None, description="base_link in map while docked; none = learned")
    initial_pose_from_dock: bool = Field(
        default=True, description="a robot that starts on its dock tells the localiser so, where that is known"
    )
    staging_distance_m: float = Field(default=0.6, gt=0.0, le=2.0, description="in front of the docked pose")


class DockingPhase(StrEnum):
    IDLE = "idle"
    """Nothing is asked for."""
    STAGING = "staging"
    """Nav2 drives in front of the dock."""
    LOOKING = "looking"
    """It waits for the base to see its dock."""
    BASE_DRIVES = "base_drives"
    """The base docks or undocks by itself."""
    ENDING = "ending"
    """Given up: what is under way is being cancelled."""


_P = DockingPhase
FOLLOWS: dict[DockingPhase, frozenset[DockingPhase]] = {
    _P.IDLE: frozenset({_P.STAGING, _P.LOOKING, _P.BASE_DRIVES}),
    _P.STAGING: frozenset({_P.LOOKING, _P.ENDING, _P.IDLE}),
    _P.LOOKING: frozenset({_P.BASE_DRIVES, _P.ENDING, _P.IDLE}),
    _P.BASE_DRIVES: frozenset({_P.ENDING, _P.IDLE}),
    _P.ENDING: frozenset({_P.IDLE}),
}
"""What may come after each phase."""


class Docking:
    """One request at a time: the base is busy meanwhile. Ends with the awaiting task, its session, or `stop`."""

    def __init__(
        self,
        *,
        robot: Robot,
        wheels: VelocityMux,
        navigator: GoalExecutor,
        maps: MapBook,
        clock: Clock,
        state_dir: Path,
        limits: DockingLimits,
    ) -> None:
        self._place = DockPose(state_dir, limits.dock_pose)
        self._maps = maps
        self._robot = robot
        self._wheels = wheels
        self._navigator = navigator
        self._clock = clock
        self._limits = limits
        self.phase = DockingPhase.IDLE
        self._patience: asyncio.Timeout
        """Set while something is under way."""
        self._session_id: str | None = None
        self._given_up = BaseEnd.TIMED_OUT
        self._initial_pose = InitialPose()

    @property
    def dock_pose(self) -> Pose2D | None:
        """base_link in the map of now while docked; none where that is not known."""
        return self._place.in_map(self._maps.current)

    async def watch(self) -> None:
        """Learns where the dock is, and tells it the localiser that knows no pose; runs as a background task."""
        while True:
            snapshot = self._look()
            self._place.learn(snapshot, self._maps.current)
            self._tell_the_localiser(snapshot)
            await self._clock.sleep(1.0)

    def _tell_the_localiser(self, snapshot: Snapshot) -> None:
        senses, pose = self._robot.senses, self.dock_pose
        docked = snapshot.dock is not None and snapshot.dock.is_docked
        localised = senses.poses.age_s(snapshot.taken_s) is not None
        due = self._initial_pose.due(
            snapshot.taken_s,
            wanted=self._limits.initial_pose_from_dock and docked and not localised and pose is not None,
            listens=bool(senses.localiser_listens.value),
            laser_turns=snapshot.scan is not None,
        )
        if due and pose is not None:
            log.info("docked and not localised: the localiser is told where the dock is", x=pose.x, y=pose.y)
            self._robot.set_initial_pose(pose)

    async def dock(self, session_id: str | None) -> BaseReply:
        """Raises `ConflictError` with the reason where it cannot even begin."""
        self._check("docking", session_id)
        snapshot = self._look()
        if snapshot.dock is not None and snapshot.dock.is_docked:
            return _reply(BaseEnd.ALREADY_THERE)
        before = self._staging_pose(snapshot)
        return await self._bounded(session_id, self._onto_the_dock(before, session_id))

    async def undock(self, session_id: str | None) -> BaseReply:
        self._check("undocking", session_id)
        snapshot = self._look()
        if snapshot.dock is None:
            raise ConflictError("the base does not tell whether it is docked", code=Refusal.NO_DOCK_STATUS)
        if not snapshot.dock.is_docked:
            raise ConflictError("it is not docked", code=Refusal.NOT_DOCKED)
        return await self._bounded(session_id, self._base_drives(docking=False))

    def stop(self, end: BaseEnd) -> None:
        """Gives up what is under way, Nav2's goal or what the base does by itself (emergency stop)."""
        if DockingPhase.ENDING in FOLLOWS[self.phase] and not self._patience.expired():
            self._enter(DockingPhase.ENDING)
            self._given_up = end
            self._patience.reschedule(asyncio.get_running_loop().time())

    def end_session(self, session_id: str) -> None:
        if self._session_id == session_id:
            self.stop(BaseEnd.SESSION_ENDED)

    async def _bounded(self, session_id: str | None, work: Coroutine[Any, Any, BaseReply]) -> BaseReply:
        """Its reply, or why it was given up: past its time, or by `stop`."""
        self._session_id, self._given_up = session_id, BaseEnd.TIMED_OUT
        try:
            async with asyncio.timeout(self._limits.dock_timeout_s) as self._patience:
                reply = await work
            return _reply(self._given_up) if self.phase is DockingPhase.ENDING else reply
        except TimeoutError:
            return _reply(self._given_up)
        finally:
            self._enter(DockingPhase.IDLE)
            self._session_id = None

    def _enter(self, phase: DockingPhase) -> None:
        """Raises `TimeoutError` where it was given up meanwhile, `ValueError` for a step the table does not have."""
        if self.phase is DockingPhase.ENDING and phase is not DockingPhase.IDLE:
            raise TimeoutError
        if phase not in FOLLOWS[self.phase]:
            raise ValueError(f"{self.phase} cannot become {phase}")
        self.phase = phase

    async def _onto_the_dock(self, before: Pose2D | None, session_id: str | None) -> BaseReply:
        if before is not None:
            self._enter(DockingPhase.STAGING)
            if why := await self._drive_to(before, session_id):
                return _reply(BaseEnd.NOT_BEFORE_DOCK, why)
        self._enter(DockingPhase.LOOKING)
        if (end := await self._why_not_asked()) is not None:
            return _reply(end)
        return await self._base_drives(docking=True)

    async def _why_not_asked(self) -> BaseEnd | None:
        """None where the base will take the request. What it would reject it is not asked for: a rejection ends
        create3_republisher, and with it everything that reaches the base."""
        told = self._robot.senses.dock
        seen = await told.wait_for(lambda dock: dock.value.dock_visible, self._limits.dock_look_s_max)
        if (dock := self._look().dock) is not None and dock.is_docked:
            return BaseEnd.ALREADY_THERE
        return None if seen is not None and dock is not None else BaseEnd.DOCK_NOT_SEEN

    def _look(self) -> Snapshot:
        return take_snapshot(self._robot.senses, self._limits, self._clock.now_s())

    def _check(self, what: str, session_id: str | None) -> None:
        self._wheels.check(self._wheels.stop_state.epoch, session_id)
        refuse_while_navigating(self._navigator, what)
        if self.phase is not DockingPhase.IDLE:
            raise ConflictError("it is docking or undocking already", code=Refusal.DOCKING_UNDER_WAY)

    def _staging_pose(self, snapshot: Snapshot) -> Pose2D | None:
        """The pose to drive to first; none where the base can see its dock and had better go from where it is."""
        visible = snapshot.dock is not None and snapshot.dock.dock_visible
        dock = self.dock_pose
        if dock is None:
            if visible:
                return None
            elsewhere = " in this map (it was learned in another one)"
            where = elsewhere if self._place.is_known_elsewhere(self._maps.current) else ""
            raise ConflictError(
                f"where the dock is, is not known{where}, and the base does not see it: "
                "put the robot on its dock once, or set ROBOT_BRIDGE_DOCK_POSE",
                code=Refusal.DOCK_UNKNOWN,
            )
        before = compose(dock, Pose2D(x=-self._limits.staging_distance_m, y=0.0, yaw=0.0))
        missing = "its place on the map is not known" if snapshot.pose is None else ""
        missing = missing or self._robot.senses.why_no_nav2(snapshot.taken_s)
        if missing:
            if visible:
                return None
            why = f"the dock is out of sight and it cannot drive there: {missing}"
            raise ConflictError(why, code=Refusal.DOCK_OUT_OF_REACH)
        near = snapshot.pose is not None and apart_m(before, snapshot.pose) < NEAR_M
        return None if near and visible else before

    async def _drive_to(self, before: Pose2D, session_id: str | None) -> str:
        """'' when it is there, else why not."""
        request = GoalRequest(
            candidates=(CandidatePose(pose=before),),
            epoch=self._wheels.stop_state.epoch,
            timeout_s=self._limits.dock_timeout_s,
            ring_radius_m=RING_M,
            session_id=session_id,
        )
        goal = await self._navigator.send(request)
        try:
            goal = await self._navigator.over(goal.id)
        except asyncio.CancelledError:
            self._navigator.stop(GoalCause.DOCKING_ENDED)
            raise
        if goal.status is GoalStatus.SUCCEEDED:
            return ""
        return f"it did not get in front of the dock: {goal.status} {goal.error_msg}".strip()

    async def _base_drives(self, *, docking: bool) -> BaseReply:
        self._enter(DockingPhase.BASE_DRIVES)
        self._wheels.set_base_busy(True)
        try:
            done = await (self._robot.dock() if docking else self._robot.undock())
        finally:
            self._wheels.set_base_busy(False)
        return _reply(BaseEnd.COMPLETED if done else self._gave_up(docking))

    def _gave_up(self, docking: bool) -> BaseEnd:
        dock = self._look().dock
        unseen = docking and dock is not None and not dock.dock_visible
        return BaseEnd.DOCK_NOT_SEEN if unseen else BaseEnd.GAVE_UP


def _reply(end: BaseEnd, text: str = "") -> BaseReply:
    return BaseReply(end=end, text=text or end.sentence)
