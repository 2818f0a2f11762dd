"""robot_bridge's Robot port without ROS. Its twin is tests/integration/robot_bridge: one suite runs over both."""

import asyncio
import contextlib
import math
import time
from collections.abc import Callable

import numpy as np

from contracts.geometry import Pose2D, Twist2D
from contracts.motion import Hazard
from contracts.robot import Battery, GoalStatus
from mesh.clock import SystemClock
from mesh.errors import UnavailableError
from robot_bridge.ports import Celebration, GoalEnd, Path, Sink
from robot_bridge.sensing.sensor_readings import (
    ColourImage,
    DepthImage,
    DockView,
    Grid,
    Intrinsics,
    Odometry,
    Scan,
    SensorReadings,
)
from robot_bridge.sensing.transforms import matrix
from support.toy_base_stop import ToyBaseStop
from support.toy_robot import CAMERA_X_M, CAMERA_Z_M, FX, OPTICAL_XYZW, START, ToyRobot

STEP_S = 0.05


class FakeGoal:
    def __init__(self, toy: ToyRobot) -> None:
        self._toy = toy
        self._end: asyncio.Future[GoalEnd] = asyncio.get_running_loop().create_future()

    async def end(self) -> GoalEnd:
        return await asyncio.shield(self._end)

    def finish(self, end: GoalEnd) -> None:
        if not self._end.done():
            self._end.set_result(end)

    async def was_preempted(self) -> bool:
        return self._toy.preempted

    def cancel(self) -> None:
        self._toy.cancelled += 1
        self.finish(GoalEnd(GoalStatus.CANCELED))


class FakeRobot:
    """Ticks in asyncio; `toy` is there to set and look at."""

    def __init__(self, toy: ToyRobot) -> None:
        self.toy = toy
        self._senses = SensorReadings()
        self._clock = SystemClock()
        self._base_stop = ToyBaseStop(toy, self._senses, self._clock)
        self._goal: FakeGoal | None = None
        self._on_progress: Callable[[float], None] = lambda _: None

    @property
    def senses(self) -> SensorReadings:
        return self._senses

    async def start(self, *, tick: Callable[[], None], navigation_velocity: Callable[[float, float], None]) -> None:
        optical = matrix((CAMERA_X_M, 0.0, CAMERA_Z_M), OPTICAL_XYZW)
        self._senses.frames.fix("base_link", "optical", optical)
        self._sense()
        self._life = asyncio.create_task(self._live(tick, navigation_velocity), name="fake-robot")

    async def close(self) -> None:
        self._life.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await self._life

    def send_velocity(self, twist: Twist2D) -> None:
        self.toy.told(twist.linear_x, twist.angular_z)

    def engage_base_stop(self, engaged: bool, *, restored: bool = False) -> None:
        self._base_stop.want(engaged, restored=restored)

    def cancel_all_goals(self) -> None:
        if self._goal is not None:
            self._goal.cancel()

    async def navigate(self, pose: Pose2D, on_progress: Callable[[float], None]) -> FakeGoal | None:
        if self.toy.navigation == "rejects":
            return None
        self.toy.goals.append((pose.x, pose.y, pose.yaw))
        if "nav2" in self.toy.thinking:
            await asyncio.Event().wait()
        self._goal, self._on_progress = FakeGoal(self.toy), on_progress
        if self.toy.gives_up():
            self._goal.finish(GoalEnd(GoalStatus.ABORTED, self.toy.give_up_code))
        elif self.toy.navigation == "succeeds":
            self._goal.finish(GoalEnd(GoalStatus.SUCCEEDED))
        return self._goal

    async def compute_path(self, goal: Pose2D, start: Pose2D | None) -> Path:
        if code := self.toy.plan_code(goal.x, goal.y):
            return Path((), code)
        begin = start or START
        return Path((begin, Pose2D(x=goal.x, y=begin.y, yaw=0.0), goal))

    async def clear_costmaps(self) -> None:
        self.toy.cleared += 1
        if "costmaps" in self.toy.thinking:
            await asyncio.Event().wait()

    async def dock(self) -> bool:
        return await self._base_drives(docked=True)

    async def undock(self) -> bool:
        return await self._base_drives(docked=False)

    def set_initial_pose(self, pose: Pose2D) -> None:
        self.toy.told_where(pose.x, pose.y)

    def celebrate(self, celebration: Celebration) -> None:
        self.toy.notes = [(note.frequency_hz, note.duration_s) for note in celebration.notes]
        self.toy.leds = celebration.led_animation_type, (celebration.led_rgb,) * 6, celebration.led_duration_s

    def record(self, sink: Sink, *, images_hz: float) -> Callable[[], None]:
        """It has no messages of its own."""
        return lambda: None

    async def _base_drives(self, *, docked: bool) -> bool:
        if "base" in self.toy.silent:
            raise UnavailableError("base", "is not there")
        if "base" in self.toy.thinking:
            self.toy.docking += 1
            try:
                await asyncio.Event().wait()
            finally:
                self.toy.docking -= 1
        if self.toy.can_dock:
            self.toy.drive_onto_dock(docked)
        return self.toy.can_dock

    async def _live(self, tick: Callable[[], None], navigation_velocity: Callable[[float, float], None]) -> None:
        while True:
            self.toy.step(STEP_S)
            self._sense()
            if self._goal is not None and self.toy.navigation == "drives":
                navigation_velocity(0.2, 0.0)
                self._on_progress(self.toy.distance_left_m)
            tick()
            await asyncio.sleep(STEP_S)

    def _sense(self) -> None:
        self._base_stop.follow()
        toy, senses, now_s, stamp_s = self.toy, self._senses, self._clock.now_s(), time.time()
        if "scan" not in toy.silent:
            bearings, ranges = toy.bearings_and_ranges()
            points = np.stack([ranges * np.cos(bearings), ranges * np.sin(bearings)], axis=1)
            senses.scan.put(Scan(stamp_s, points), now_s)
        if "odom" not in toy.silent:
            pose = Pose2D(x=toy.x, y=toy.y, yaw=toy.yaw)
            senses.poses.add_odometry(stamp_s, pose)
            senses.odometry.put(Odometry(stamp_s, pose, Twist2D(linear_x=toy.linear_x, angular_z=toy.angular_z)), now_s)
        if "pose" not in toy.silent:
            senses.poses.add_map_to_odom(stamp_s, START, received_s=now_s)
        if "rgb" not in toy.silent:
            senses.rgb.put(ColourImage(stamp_s, "optical", toy.picture()), now_s)
            senses.rgb_intrinsics.put(Intrinsics("optical", 250, 250, FX, FX, 125.0, 125.0), now_s)
        if "depth" not in toy.silent:
            image = DepthImage(stamp_s, "optical", toy.depths_m())
            senses.depth_history.add(image)
            senses.depth.put(image, now_s)
            senses.depth_intrinsics.put(Intrinsics("optical", 640, 400, 2 * FX, 2 * FX, 320.0, 200.0), now_s)
        if "map" not in toy.silent and senses.map.newest is None:
            senses.map.put(Grid(toy.cells(), 0.1, Pose2D(x=0.0, y=0.0, yaw=0.0)), now_s)
        senses.battery.put(Battery(percentage=80.0), now_s)
        senses.dock.put(DockView(toy.docked, toy.dock_visible), now_s)
        senses.hazards.put(frozenset(Hazard(name) for name in toy.hazards), now_s)
        senses.localiser_listens.put(True, now_s)
        senses.nav2_missing.put("bt_navigator not active" if toy.navigation == "is_inactive" else "", now_s)


def distance_m(toy: ToyRobot) -> float:
    """From where it began."""
    return math.hypot(toy.x, toy.y)
