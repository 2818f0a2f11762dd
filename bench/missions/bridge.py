"""robot_bridge and the robot, simulated: what it promises on its routes, over a robot that moves kinematically."""

import asyncio
import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar, cast

import numpy as np

from bench.missions.bus import SimulatedBus
from bench.missions.place import InPicture, SimulatedPlace
from bench.missions.wheels import Going, Moving, Straight, Turning, Wheels
from bench.missions.wire import Wire
from bench.world.faults import Faults
from contracts.base import BboxXyxy
from contracts.causes import GoalCause, Refusal
from contracts.description import CameraModel, RobotDescription
from contracts.geometry import Point3D, Pose2D, Twist2D
from contracts.measuring import Measurement, NotMeasured, not_measured
from contracts.motion import BaseEnd, BaseReply, DriveReply, MotionEnd, RotateReply
from contracts.problem import Dependency
from contracts.robot import (
    GOAL_ANSWER_S,
    Battery,
    EmergencyStop,
    Goal,
    GoalRequest,
    GoalStatus,
    Map,
    RobotState,
    VelocityReply,
)
from contracts.topics import ROBOT_DESCRIPTION, ROBOT_EMERGENCY_STOP, ROBOT_NAVIGATION, ROBOT_STATE
from contracts.vision import Detection
from geometry.boxes import iou
from geometry.poses import compose
from mesh.errors import UpstreamError
from robot_bridge.navigation.goal_states import RETRIES
from robot_bridge.navigation.path_check import GoalRegion, PathCheck, PathChecker, best_or_first
from robot_bridge.ports import Path, Robot
from robot_bridge.sensing.sensor_readings import Grid, SensorReadings
from robot_bridge.settings import Settings
from sim.nav.codes import NavigationError
from sim.world.base import SPEED_MAX_M_S, TURN_MAX_RAD_S
from sim.world.robot import CAMERA_X_M, RGB_CAMERA, ROBOT_RADIUS_M

DESCRIPTION = RobotDescription(
    footprint_radius_m=ROBOT_RADIUS_M,
    speed_m_s_max=SPEED_MAX_M_S,
    turn_rad_s_max=TURN_MAX_RAD_S,
    camera=CameraModel(
        width_px=RGB_CAMERA.width_px, height_px=RGB_CAMERA.height_px,
        fx=RGB_CAMERA.fx, fy=RGB_CAMERA.fy, cx=RGB_CAMERA.cx, cy=RGB_CAMERA.cy,
        position_in_base=Point3D(x=RGB_CAMERA.x_m, y=0.0, z=RGB_CAMERA.z_m),
    ),
    depth_noise=Settings().depth_noise,
)  # fmt: skip
NOISE = DESCRIPTION.depth_noise

M = TypeVar("M", bound=Moving)
TICK_S = 0.05
DEPTH_MIN_M, DEPTH_MAX_M = 0.2, 3.0
UNDOCK_S = 6.0
OVER = frozenset(
    {GoalStatus.SUCCEEDED, GoalStatus.CANCELED, GoalStatus.ABORTED, GoalStatus.REJECTED, GoalStatus.TIMED_OUT}
)


@dataclass(frozen=True)
class Frame:
    """A picture that was taken: what stands in which box, where the robot was, and where it believed to be."""

    stamp_s: float
    true_pose: Pose2D
    believed: Pose2D
    boxes: tuple[tuple[Detection, InPicture | None], ...]


class SimulatedBridge:
    """The port `Robot` of the coordinator. `asked` is told of every request that would move the robot."""

    def __init__(self, place: SimulatedPlace, start: Pose2D, faults: Faults, bus: SimulatedBus, seed: int, *,
                 docked: bool = False, battery: float = 90.0) -> None:  # fmt: skip
        self.rng = np.random.default_rng([seed, 21])
        self.place = place
        self.wire = Wire("robot_bridge", faults, np.random.default_rng([seed, 22]))
        self.wheels = Wheels(place, start, seed)
        self.frames: deque[Frame] = deque(maxlen=60)
        self.stop = EmergencyStop(latched=False, epoch=0)
        self.docked = docked
        self.battery = battery
        self.asked: Callable[[str], None] = lambda _: None
        self.celebrations = 0
        self._faults = faults
        self._bus = bus
        bus.keep(ROBOT_DESCRIPTION, DESCRIPTION)
        self._sessions = 0
        self.senses = SensorReadings()
        self.senses.map.put(Grid(place.grid.data, place.grid.resolution_m, place.map_message.origin), 0.0)
        self._paths = PathChecker(cast("Robot", self), Settings())
        self._goals: dict[str, Goal] = {}
        self._goal_id: str | None = None
        self._goal_until_s = math.inf
        self._was_down = False

    # --- the process

    async def run(self) -> None:
        """20 Hz: moves, and says where it is at 10 Hz."""
        count = 0
        while True:
            await asyncio.sleep(TICK_S)
            now_s = asyncio.get_running_loop().time()
            if self.wire.down:
                self._fall()
            else:
                self._was_down = False
                self.wheels.tick(TICK_S, now_s)
                await self._watch_goal(now_s)
                count += 1
                if count % 2 == 0:
                    await self._bus.publish(ROBOT_STATE, self.state(now_s))

    def _fall(self) -> None:
        """A crash: everything it did ends, and its goals are forgotten. The stop is on disk."""
        if not self._was_down:
            self._was_down = True
            self.wheels.end(MotionEnd.SHUT_DOWN)
            self._goals.clear()
            self._goal_id = None

    def state(self, now_s: float) -> RobotState:
        return RobotState(
            stamp_s=now_s,
            pose=self.wheels.believed(),
            odometry=self.wheels.odometry(),
            twist=self.wheels.twist,
            docked=self.docked,
            battery=Battery(percentage=self.battery, charging=self.docked),
            emergency_stop=self.stop,
        )

    async def latch(self, reason: str) -> None:
        now_s = asyncio.get_running_loop().time()
        self.stop = EmergencyStop(latched=True, epoch=self.stop.epoch + 1, reason=reason, since_s=now_s)
        self.wheels.end(MotionEnd.STOPPED)
        await self._end_goal(GoalStatus.CANCELED, GoalCause.STOPPED)
        await self._bus.publish(ROBOT_EMERGENCY_STOP, self.stop)

    async def reset(self) -> None:
        self.stop = EmergencyStop(latched=False, epoch=self.stop.epoch)
        await self._bus.publish(ROBOT_EMERGENCY_STOP, self.stop)

    # --- the port

    @property
    def session_held(self) -> bool:
        return self._sessions > 0 and not self.wire.down

    async def hold_session(self) -> None:
        self._sessions += 1
        try:
            await asyncio.Event().wait()
        finally:
            self._sessions -= 1
            if self._sessions == 0:
                self.wheels.end(MotionEnd.SESSION_ENDED)
                await self._end_goal(GoalStatus.CANCELED, GoalCause.SESSION_ENDED)

    async def drop_session(self) -> None:
        """Nothing of it goes over the wire: a session that is silent ends as well."""
        self.wheels.end(MotionEnd.SESSION_ENDED)
        await self._end_goal(GoalStatus.CANCELED, GoalCause.SESSION_ENDED)

    async def map(self) -> Map:
        async def work() -> Map:
            return self.place.map_message

        return await self.wire.call(work)

    async def navigate(self, request: GoalRequest) -> Goal:
        self.asked("navigate")

        async def work() -> Goal:
            self._may_move(request.epoch)
            await self._end_goal(GoalStatus.CANCELED, GoalCause.PREEMPTED)
            await asyncio.sleep(1.5)  # the costmaps are cleared first
            radius_m = Settings().ring_radius_m if request.ring_radius_m is None else request.ring_radius_m
            checked = await best_or_first(self._paths, GoalRegion(request.candidates, radius_m))
            self._may_move(request.epoch)
            return await self._accept(checked, request)

        return await self.wire.call(work, timeout_s=GOAL_ANSWER_S)

    async def compute_path(self, goal: Pose2D, start: Pose2D | None) -> Path:
        """As Nav2's planner answers the bridge."""
        if self._faults.path_lie and self.rng.random() < self._faults.path_lie:
            return Path((), 208)
        try:
            way = self.place.way(start or self.wheels.believed(), goal)
        except NavigationError as error:
            return Path((), int(error.code))
        return Path((*(Pose2D(x=x, y=y, yaw=0.0) for x, y in way[:-1].tolist()), goal))

    async def goal(self, goal_id: str) -> Goal:
        async def work() -> Goal:
            return self._known(goal_id)

        return await self.wire.call(work)

    async def cancel_goal(self, goal_id: str) -> Goal:
        async def work() -> Goal:
            goal = self._known(goal_id)
            if goal_id == self._goal_id:
                self.wheels.end(MotionEnd.CANCELED)
                await self._end_goal(GoalStatus.CANCELED, GoalCause.CANCELED)
                goal = self._known(goal_id)
            return goal

        return await self.wire.call(work)

    async def rotate(self, angle_rad: float, *, speed_rad_s: float, timeout_s: float, epoch: int) -> RotateReply:
        self.asked("rotate")
        motion, end = await self._motion(lambda: Turning(angle_rad, speed_rad_s), timeout_s, epoch)
        return motion.reply(end)

    async def drive(self, distance_m: float, *, speed_m_s: float, timeout_s: float, epoch: int) -> DriveReply:
        self.asked("drive")
        motion, end = await self._motion(lambda: Straight(distance_m, speed_m_s), timeout_s, epoch)
        return motion.reply(end)

    async def velocity(self, twist: Twist2D, *, duration_s: float, epoch: int) -> VelocityReply:
        if twist.linear_x or twist.angular_z:
            self.asked("velocity")

        async def work() -> VelocityReply:
            self._may_move(epoch)
            self.wheels.lease(twist, asyncio.get_running_loop().time() + duration_s)
            return VelocityReply(accepted=True, sent=twist)

        return await self.wire.call(work, timeout_s=1.0)

    async def end_motion(self) -> None:
        async def work() -> None:
            if self._goal_id is None:
                self.wheels.end(MotionEnd.CANCELED)

        await self.wire.call(work)

    async def halt(self) -> EmergencyStop:
        async def work() -> EmergencyStop:
            self.stop = self.stop.model_copy(update={"epoch": self.stop.epoch + 1})
            self.wheels.end(MotionEnd.CANCELED)
            await self._end_goal(GoalStatus.CANCELED, GoalCause.CANCELED)
            return self.stop

        return await self.wire.call(work, timeout_s=1.0)

    async def emergency_stop(self, reason: str) -> EmergencyStop:
        async def work() -> EmergencyStop:
            await self.latch(reason)
            return self.stop

        return await self.wire.call(work, timeout_s=1.0)

    async def undock(self, *, timeout_s: float) -> BaseReply:
        self.asked("undock")

        async def work() -> BaseReply:
            self._may_move(self.stop.epoch)
            await asyncio.sleep(UNDOCK_S)
            self._may_move(self.stop.epoch)
            if self.docked:
                self.wheels.put(self.place.off_dock)
                self.docked = False
            return BaseReply(end=BaseEnd.COMPLETED)

        return await self.wire.call(work, timeout_s=timeout_s)

    async def dock(self, *, timeout_s: float) -> BaseReply:
        self.asked("dock")

        async def work() -> BaseReply:
            self._may_move(self.stop.epoch)
            await asyncio.sleep(UNDOCK_S)
            self._may_move(self.stop.epoch)
            self.wheels.put(self.place.dock)
            self.docked = True
            return BaseReply(end=BaseEnd.COMPLETED)

        return await self.wire.call(work, timeout_s=timeout_s)

    async def celebrate(self) -> None:
        self.celebrations += 1

    async def dependency(self) -> Dependency:
        return Dependency.of("robot_bridge", ok=not self.wire.down)

    # --- goals and motions

    def _may_move(self, epoch: int) -> None:
        if self.stop.latched:
            raise UpstreamError("robot_bridge", 409, "the emergency stop is latched", code=Refusal.STOPPED)
        if epoch != self.stop.epoch:
            raise UpstreamError("robot_bridge", 409, f"the epoch is {self.stop.epoch} now", code=Refusal.OLD_EPOCH)
        if self._sessions == 0:
            raise UpstreamError("robot_bridge", 409, "no session is held", code=Refusal.SESSION_OVER)

    def _known(self, goal_id: str) -> Goal:
        if goal_id not in self._goals:
            raise UpstreamError("robot_bridge", 404, f"no goal {goal_id}")
        return self._goals[goal_id]

    async def _accept(self, checked: PathCheck, request: GoalRequest) -> Goal:
        now_s, pose = asyncio.get_running_loop().time(), checked.pose or request.candidates[0].pose
        goal = Goal(
            id=f"goal-{now_s:.2f}", pose=pose, candidate=checked.candidate, status=GoalStatus.EXECUTING, stamp_s=now_s
        )
        if self.rng.random() < self._faults.goal_rejected:
            cause = GoalCause.REJECTED
            over = {"status": GoalStatus.REJECTED, "cause": cause, "error_msg": cause.sentence}
            goal = goal.model_copy(update=over)
            self._goals[goal.id] = goal
            return goal
        self._goals[goal.id], self._goal_id, self._goal_until_s = goal, goal.id, now_s + request.timeout_s
        if checked.unreachable:
            await self._end_goal(GoalStatus.ABORTED, GoalCause.UNREACHABLE, checked.error_code, checked.reason)
        else:
            await self._set_out(goal)
        return self._goals[goal.id]

    async def _set_out(self, goal: Goal) -> None:
        """Once more where the planner fails, as the bridge does."""
        code, retries = int(self.rng.choice([202, 207, 208])), 1
        if all(self.rng.random() < self._faults.goal_aborted_2xx for _ in range(1 + retries)):
            await self._end_goal(GoalStatus.ABORTED, GoalCause.NAV2, code, "the planner failed")
            return
        try:
            way = self.place.way(self.wheels.believed(), goal.pose)
        except NavigationError as error:
            await self._end_goal(GoalStatus.ABORTED, GoalCause.NAV2, int(error.code), error.detail)
            return
        patience = float(self.rng.uniform(0.05, 0.9)) if self.rng.random() < self._faults.goal_aborted_104 else None
        soon = float(self.rng.uniform(0.3, 0.9)) if self.rng.random() < self._faults.goal_false_success else None
        self.wheels.begin(Going(way, goal.pose.yaw, gives_up_after=patience, claims_after=soon))

    async def _watch_goal(self, now_s: float) -> None:
        goal = self._goals.get(self._goal_id or "")
        if goal is None or goal.status in OVER:
            return
        ending = self.wheels.goal_ending
        if ending and goal.attempt <= RETRIES.get(ending, 0):
            self._goals[goal.id] = goal.model_copy(update={"attempt": goal.attempt + 1})
            await self._set_out(self._goals[goal.id])
        elif ending is not None:
            status, cause = (GoalStatus.ABORTED, GoalCause.NAV2) if ending else (GoalStatus.SUCCEEDED, None)
            await self._end_goal(status, cause, ending, "the controller lost its patience" if ending else "")
        elif now_s > self._goal_until_s:
            self.wheels.end(MotionEnd.TIMED_OUT)
            await self._end_goal(GoalStatus.TIMED_OUT, GoalCause.TIMED_OUT)

    async def _end_goal(self, status: GoalStatus, cause: GoalCause | None, code: int = 0, message: str = "") -> None:
        goal = self._goals.get(self._goal_id or "")
        if goal is None or goal.status in OVER:
            return
        message = message or (cause.sentence if cause is not None else "")
        over = goal.model_copy(update={"status": status, "cause": cause, "error_code": code, "error_msg": message})
        self._goals[goal.id], self._goal_id = over, None
        await self._bus.publish(ROBOT_NAVIGATION, over)

    async def _motion(self, make: Callable[[], M], timeout_s: float, epoch: int) -> tuple[M, MotionEnd]:
        async def work() -> tuple[M, MotionEnd]:
            self._may_move(epoch)
            motion = make()
            if self.rng.random() < self._faults.motion_cut:
                motion.cut_after = float(self.rng.uniform(0.1, 0.9))
            self.wheels.begin(motion)
            try:
                async with asyncio.timeout(timeout_s):
                    return motion, await motion.ended
            except TimeoutError:
                self.wheels.end(MotionEnd.TIMED_OUT)
                return motion, MotionEnd.TIMED_OUT
            finally:
                if not motion.ended.done() or motion.ended.cancelled():
                    self.wheels.end(MotionEnd.CLIENT_LEFT)

        return await self.wire.call(work, timeout_s=timeout_s + 2.0)

    # --- depth

    def localize(self, frame: Frame, boxes: Sequence[BboxXyxy]) -> tuple[Measurement, ...]:
        """All boxes of one picture in one call."""
        return tuple(self._measured(frame, box) for box in boxes)

    def _measured(self, frame: Frame, box: BboxXyxy) -> Measurement:
        u, v = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
        bearing = math.atan2(RGB_CAMERA.cx - u, RGB_CAMERA.fx)
        seen = shown_in(frame, box)
        distance = seen.distance_m if seen is not None else self.place.depth_at(frame.true_pose, u, v)
        if math.isfinite(distance):
            distance += float(self.rng.normal(0.0, min(0.5, NOISE.sigma_m(distance))))
        if self._faults.depth_lie and self.rng.random() < self._faults.depth_lie:
            distance *= float(self.rng.choice([0.5, 0.65, 1.5, 2.0]))
        if not DEPTH_MIN_M <= distance <= DEPTH_MAX_M:
            return not_measured(NotMeasured.NO_DEPTH, "no depth in the box")
        x, y = CAMERA_X_M + distance * math.cos(bearing), distance * math.sin(bearing)
        there = compose(frame.believed, Pose2D(x=x, y=y, yaw=0.0))
        return Measurement(
            distance_m=distance,
            depth_m=distance * math.cos(bearing),
            sigma_m=NOISE.sigma_m(distance),
            bearing_rad=math.atan2(y, x),
            base_point=Point3D(x=x, y=y, z=0.2),
            map_point=Point3D(x=there.x, y=there.y, z=0.2),
        )


def shown_in(frame: Frame, bbox: tuple[float, float, float, float]) -> InPicture | None:
    """What a box of a picture shows: the thing whose box overlaps it best, none when none does by half."""
    overlap, found = max(
        ((iou(bbox, detection.bbox_xyxy), k) for k, (detection, _) in enumerate(frame.boxes)), default=(0.0, -1)
    )
    return frame.boxes[found][1] if overlap >= 0.5 else None
