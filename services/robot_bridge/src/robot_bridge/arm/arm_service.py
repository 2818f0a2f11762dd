"""The arm as the routes see it: the wheels' rules of epoch and session, joints' limits, and an end to everything.

A stop cancels whatever the controllers do, by whomever: they leave the joints where they are, and a jaw that holds
something goes on holding it (`ON_STOP`). Nothing is resumed. While the stop is latched all is cancelled again and
again: somebody else may begin something.
"""

import asyncio
import math
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

import structlog
from pydantic import BaseModel, Field

from contracts.arm import (
    ArmEnd,
    ArmHomeRequest,
    ArmJoint,
    ArmPart,
    ArmRefusal,
    ArmReply,
    ArmState,
    ArmTrajectoryRequest,
    GripperReply,
    GripperRequest,
)
from contracts.problem import Dependency, DependencyState
from mesh.clock import Clock
from mesh.errors import ConflictError, UnavailableError, UnprocessableError
from mesh.tasks import Tasks
from robot_bridge.arm.joint_states import JointStates
from robot_bridge.arm.port import ArmGoal, RobotArm
from robot_bridge.arm.trajectories import home, in_order, why_refused
from robot_bridge.motion.velocity_mux import VelocityMux

log = structlog.get_logger()

MOVING_RAD_S: Final = 0.1
"""A joint that is slower trembles."""
WATCH_S: Final = 0.1
AGAIN_S: Final = 0.5
"""Between two cancels while the stop is latched and no joint is seen to move."""
GRIPPER_S_MAX: Final = 15.0


class OnStop(StrEnum):
    """What a stop does with a part."""

    HOLD = "hold"
    """What is under way ends; it stays where it is, and goes on holding what it holds."""


ON_STOP: Final[dict[ArmPart, OnStop]] = {ArmPart.ARM: OnStop.HOLD, ArmPart.GRIPPER: OnStop.HOLD}
"""Never limp and never open: an arm that falls or a glass that is dropped is worse than one that stays."""


class ArmLimits(BaseModel):
    arm_speed_rad_s_max: float = Field(default=1.0, gt=0.0, le=10.0, description="of any joint, beside its own limit")
    arm_effort_share_max: float = Field(
        default=0.5, gt=0.0, le=1.0, description="of the jaw's own most that it is ever asked to press with"
    )
    arm_joints_age_s_max: float = Field(default=0.5, gt=0.0, description="older joint_states are not acted on")
    arm_late_s_max: float = Field(
        default=5.0, gt=0.0, description="a controller may end a trajectory so long after its last point"
    )


@dataclass(slots=True)
class _Active:
    """One part's motion; `given_up` is set to end it from outside."""

    session_id: str | None
    given_up: "asyncio.Future[ArmEnd]" = field(default_factory=lambda: asyncio.get_running_loop().create_future())

    def give_up(self, end: ArmEnd) -> None:
        if not self.given_up.done():
            self.given_up.set_result(end)


class ArmService:
    """Lives in asyncio. Without an arm it says so, and nothing else."""

    def __init__(self, arm: RobotArm | None, *, wheels: VelocityMux, clock: Clock, limits: ArmLimits) -> None:
        self._arm = arm
        self._wheels = wheels
        self._clock = clock
        self._limits = limits
        self._active: dict[ArmPart, _Active] = {}
        self._cancelled_s = -math.inf

    def state(self) -> ArmState:
        if (arm := self._arm) is None:
            return ArmState(fitted=False)
        now_s, model, told = self._clock.now_s(), arm.model, arm.joints.value
        fresh = self._fresh(arm)
        positions, velocities, efforts = (
            (told.positions, told.velocities, told.efforts) if told is not None else ({}, {}, {})
        )
        jaw = fresh.positions.get(model.jaw.joint) if fresh is not None else None
        return ArmState(
            fitted=True,
            model=model.name,
            joints=tuple(
                ArmJoint(
                    name=joint.name,
                    lower_rad=joint.lower_rad,
                    upper_rad=joint.upper_rad,
                    speed_rad_s_max=min(joint.speed_rad_s_max, self._limits.arm_speed_rad_s_max),
                    position_rad=positions.get(joint.name),
                    velocity_rad_s=velocities.get(joint.name),
                    effort_nm=efforts.get(joint.name),
                )
                for joint in model.joints
            ),
            opening=model.jaw.opening(jaw) if jaw is not None else None,
            age_s=max((max(0.0, now_s - at_s) for at_s in told.told_s.values()), default=None) if told else None,
            moving=_moves(fresh) if fresh is not None else None,
            under_way=tuple(self._active),
        )

    async def follow(self, request: ArmTrajectoryRequest) -> ArmReply:
        """Drives a trajectory to its end. Raises `ConflictError`, `UnavailableError` or `UnprocessableError` where it
        does not begin."""
        arm = self._may_begin(ArmPart.ARM, request.epoch, request.session_id)
        now_rad = self._at_rest(arm)
        limit = self._limits.arm_speed_rad_s_max
        if (refused := why_refused(request, arm.model, now_rad, speed_rad_s_max=limit)) is not None:
            raise UnprocessableError(refused.text, code=refused.code)
        points = in_order(request, arm.model)
        within_s = points[-1].time_s + self._limits.arm_late_s_max
        end = await self._run(arm, ArmPart.ARM, request.session_id, lambda: arm.follow(points), within_s)
        return ArmReply(end=end, text=end.sentence)

    async def home(self, request: ArmHomeRequest) -> ArmReply:
        """Folds the arm, from wherever it is. Raises as `follow` does."""
        arm = self._may_begin(ArmPart.ARM, request.epoch, request.session_id)
        speed = request.speed_share * self._limits.arm_speed_rad_s_max
        points = home(arm.model, self._at_rest(arm), speed_rad_s_max=speed)
        return await self.follow(
            ArmTrajectoryRequest(
                joints=arm.model.names, points=points, epoch=request.epoch, session_id=request.session_id
            )
        )

    async def grip(self, request: GripperRequest) -> GripperReply:
        """Moves the jaw until it is there or stalls. Raises `ConflictError` or `UnavailableError` where it does not
        begin."""
        arm = self._may_begin(ArmPart.GRIPPER, request.epoch, request.session_id)
        jaw = arm.model.jaw
        self._told_of(arm, (jaw.joint,))
        effort = min(request.effort_share, self._limits.arm_effort_share_max) * jaw.effort_max
        position = jaw.position(request.opening)
        end = await self._run(
            arm, ArmPart.GRIPPER, request.session_id, lambda: arm.grip(position, effort), GRIPPER_S_MAX
        )
        return GripperReply(end=end, opening=self.state().opening, text=end.sentence)

    def stop(self, end: ArmEnd) -> tuple[ArmPart, ...]:
        """Ends what is under way, and whatever else the controllers do; nothing is waited for."""
        if self._arm is None:
            return ()
        self._cancel_all(self._arm)
        for active in self._active.values():
            active.give_up(end)
        return tuple(self._active)

    def end_session(self, session_id: str) -> None:
        for active in self._active.values():
            if active.session_id == session_id:
                active.give_up(ArmEnd.SESSION_ENDED)

    def dependencies(self) -> list[Dependency]:
        """A line for `/ready` where there is an arm; a robot searches without, so it is a warning at most."""
        if (arm := self._arm) is None:
            return []
        missing = arm.missing() or ("" if self._fresh(arm) is not None else "no fresh joint_states")
        state = DependencyState.WARNING if missing else DependencyState.READY
        return [Dependency(name="arm", state=state, detail=missing or f"{arm.model.name}: its joints are told")]

    def start(self, tasks: Tasks) -> None:
        """Begins to watch the joints, where there are any."""
        if self._arm is not None:
            tasks.start("watch-arm", self._watch(self._arm))

    async def _watch(self, arm: RobotArm) -> None:
        """While the stop is latched all is cancelled again and again, and at once where a joint is seen to move.

        Joints may tell nothing, or too little: what moves slowly is not told from what trembles.
        """
        moved = False
        while True:
            await self._clock.sleep(WATCH_S)
            if not self._wheels.stop_state.latched:
                moved = False
                continue
            fresh = self._fresh(arm)
            moves = fresh is not None and _moves(fresh)
            if moves and not moved:
                log.warning("the arm moves during a stop: what its controllers do is cancelled again")
            moved = moves
            if moves or self._clock.now_s() - self._cancelled_s >= AGAIN_S:
                self._cancel_all(arm)

    def _cancel_all(self, arm: RobotArm) -> None:
        self._cancelled_s = self._clock.now_s()
        for part in ArmPart:
            arm.cancel(part)

    def _may_begin(self, part: ArmPart, epoch: int, session_id: str | None) -> RobotArm:
        if (arm := self._arm) is None:
            raise ConflictError("this robot has no arm", code=ArmRefusal.NO_ARM)
        self._wheels.check(epoch, session_id)
        if part in self._active:
            raise ConflictError(f"the {part} is moving already", code=ArmRefusal.ARM_MOTION_UNDER_WAY)
        if arm.owes_cancel(part):
            text = f"the {part}'s controller has not answered yet that its goals are cancelled"
            raise UnavailableError("arm", text, code=ArmRefusal.CANCEL_OWED)
        return arm

    async def _run(
        self,
        arm: RobotArm,
        part: ArmPart,
        session_id: str | None,
        begin: Callable[[], Awaitable[ArmGoal | None]],
        within_s: float,
    ) -> ArmEnd:
        """From the request to the controller's end, or until it is given up; then what the part does is cancelled."""
        active = self._active[part] = _Active(session_id)
        ending: asyncio.Future[ArmEnd] | None = None
        end: ArmEnd | None = None
        try:
            if (goal := await begin()) is None:
                end = ArmEnd.REJECTED
                return end
            ending = asyncio.ensure_future(goal.end())
            await asyncio.wait({ending, active.given_up}, timeout=within_s, return_when=asyncio.FIRST_COMPLETED)
            if active.given_up.done():
                return active.given_up.result()
            if not ending.done():
                return ArmEnd.TIMED_OUT
            end = ending.result()
            return end
        finally:
            del self._active[part]
            if end is None:  # given up, out of time, whoever asked has gone, or nobody knows whether it was accepted
                arm.cancel(part)
            if ending is not None:
                ending.cancel()

    def _fresh(self, arm: RobotArm) -> JointStates | None:
        """Of the joints that told lately; none where none did."""
        told = arm.joints.value
        return told.since(self._clock.now_s() - self._limits.arm_joints_age_s_max) if told is not None else None

    def _at_rest(self, arm: RobotArm) -> tuple[float, ...]:
        """Where the joints are, in the model's order. Raises `UnavailableError` where that is not known, and
        `ConflictError` while one moves: a controller begins a trajectory with the joints' speed."""
        names = arm.model.names
        told = self._told_of(arm, names)
        if moving := [name for name in names if abs(told.velocities.get(name, math.inf)) > MOVING_RAD_S]:
            text = f"{', '.join(moving)}: moves, or its speed is not known yet"
            raise ConflictError(text, code=ArmRefusal.JOINT_MOVES)
        return tuple(told.positions[name] for name in names)

    def _told_of(self, arm: RobotArm, names: tuple[str, ...]) -> JointStates:
        """What is known of these joints. Raises `UnavailableError` where one has not told lately."""
        told = self._fresh(arm)
        absent = [name for name in names if told is None or name not in told.positions]
        if told is None or absent:
            text = f"joint_states say nothing of {', '.join(absent)}" if told is not None else "no fresh joint_states"
            raise UnavailableError("arm", text, code=ArmRefusal.NO_JOINT_STATES)
        return told


def _moves(told: JointStates) -> bool:
    return any(abs(rate) > MOVING_RAD_S for rate in told.velocities.values())
