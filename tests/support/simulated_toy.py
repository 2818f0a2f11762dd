"""The simulated robot in-process, without ROS: robot_bridge's Robot port over `sim.world` and the Nav2 stand-in.

Its controls are the toy's: what a test sets or looks at there, it sets or looks at here. What the world can do is done
by the world; only faults (silence, rejections, giving up) are put in by hand.
"""

import asyncio
import math
import threading
import time
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contracts.geometry import Pose2D, Twist2D
from contracts.motion import Hazard
from contracts.robot import Battery, GoalStatus
from geometry.poses import compose, inverse, quaternion_xyzw
from mesh.clock import SystemClock
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
from sim.nav.codes import NavigationError
from sim.nav.costmap import Costmap
from sim.nav.docking import Docking, Undocking
from sim.nav.navigator import Navigator, Outcome
from sim.nav.planner import plan
from sim.world import World, WorldOptions
from sim.world.robot import CAMERA_X_M, LIDAR, LIDAR_Z_M
from sim.world.types import CameraModel, OccupancyGrid
from support.simulated_room import DOCK, SCENE, WIDTH_M
from support.toy_base_stop import ToyBaseStop
from support.toy_robot import OPTICAL_XYZW, START, ToyRobot

STEP_S = 0.05
PICTURE_EVERY = 4
"""Ticks between pictures: rendering takes a good part of one."""
BOTTLE_X_M, BOTTLE_Y_M, BOTTLE_RADIUS_M = 4.5, 3.0, 0.04


@cache
def recorded_map() -> OccupancyGrid:
    with World(SCENE, start=START, options=WorldOptions(noise_free=True)) as world:
        return world.grid


class SimulatedToy(ToyRobot):
    """The toy's controls over a world. Commands to the world are handed to its thread."""

    def __init__(self) -> None:
        super().__init__(wall_ahead_m=WIDTH_M - START.x, camera_x_m=CAMERA_X_M)
        self.where = START
        self._moves: list[Pose2D] = []

    def put_on_dock(self) -> None:
        self.put(DOCK)

    def put_away(self) -> None:
        self.put(Pose2D(x=1.9, y=2.0, yaw=0.0))

    def put(self, pose: Pose2D) -> None:
        """By hand."""
        self._moves.append(pose)

    def moved_by_hand(self) -> Pose2D | None:
        return self._moves.pop(0) if self._moves else None

    def face_the_thing(self) -> tuple[tuple[float, float, float, float], float, tuple[float, float]]:
        """0.9 m before the red bottle, its axis in the middle of the picture."""
        camera = World.rgb_camera
        depth_m = 0.9
        surface_x = BOTTLE_X_M - BOTTLE_RADIUS_M
        self.put(Pose2D(x=surface_x - depth_m - camera.x_m, y=BOTTLE_Y_M, yaw=0.0))
        half_px = camera.fx * BOTTLE_RADIUS_M / depth_m
        top_px = camera.cy - camera.fy * (0.3 - camera.z_m) / depth_m
        return (camera.cx - half_px, top_px, camera.cx + half_px, top_px + 40.0), depth_m, (surface_x, BOTTLE_Y_M)

    def cells(self) -> np.ndarray:
        return recorded_map().data

    def wall_moved_to(self) -> float | None:
        """The distance asked for, where it is not what it was: the room stays, the robot is put nearer."""
        now_m = WIDTH_M - self.where.x
        return self.wall_ahead_m if abs(self.wall_ahead_m - now_m) > 1e-9 and self.wall_ahead_m < 1.0 else None


class SimulatedGoal:
    def __init__(self, toy: ToyRobot, loop: asyncio.AbstractEventLoop) -> None:
        self._toy = toy
        self._loop = loop
        self._end: asyncio.Future[GoalEnd] = loop.create_future()
        self.cancelled = False

    async def end(self) -> GoalEnd:
        return await asyncio.shield(self._end)

    async def was_preempted(self) -> bool:
        return False

    def finish(self, end: GoalEnd) -> None:
        """From any thread."""
        self._loop.call_soon_threadsafe(lambda: None if self._end.done() else self._end.set_result(end))

    def cancel(self) -> None:
        self._toy.cancelled += 1
        self.cancelled = True
        self.finish(GoalEnd(GoalStatus.CANCELED))


class SimulatedRobot:
    """The World lives in a thread of its own, at the pace of the wall clock; so do its cameras."""

    def __init__(self, toy: SimulatedToy) -> None:
        self.toy = toy
        self._senses = SensorReadings()
        self._clock = SystemClock()
        self._base_stop = ToyBaseStop(toy, self._senses, self._clock)
        self._closing = threading.Event()
        self._navigator = Navigator(Costmap.from_map(recorded_map()))
        self._goal: SimulatedGoal | None = None
        self._wanted: tuple[SimulatedGoal, Pose2D] | None = None
        self._on_progress: Callable[[float], None] = lambda _: None
        self._behaviour: tuple[Docking | Undocking, Callable[[bool], None]] | None = None
        self._twist = Twist2D()

    @property
    def senses(self) -> SensorReadings:
        return self._senses

    async def start(self, *, tick: Callable[[], None], navigation_velocity: Callable[[float, float], None]) -> None:
        self._loop = asyncio.get_running_loop()
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._live, args=(tick, navigation_velocity), name="world")
        self._thread.start()

    async def close(self) -> None:
        self._closing.set()
        await asyncio.to_thread(self._thread.join)
        if self._error is not None:
            raise self._error

    def send_velocity(self, twist: Twist2D) -> None:
        self.toy.told(twist.linear_x, twist.angular_z)
        self._twist = twist

    def engage_base_stop(self, engaged: bool, *, restored: bool = False) -> None:
        self._base_stop.want(engaged, restored=restored)

    def cancel_all_goals(self) -> None:
        if self._goal is not None:
            self._goal.cancel()

    async def navigate(self, pose: Pose2D, on_progress: Callable[[float], None]) -> SimulatedGoal | None:
        if self.toy.navigation == "rejects":
            return None
        self.toy.goals.append((pose.x, pose.y, pose.yaw))
        goal = SimulatedGoal(self.toy, self._loop)
        if self.toy.gives_up():
            goal.finish(GoalEnd(GoalStatus.ABORTED, self.toy.give_up_code))
        else:
            self._goal, self._on_progress, self._wanted = goal, on_progress, (goal, pose)
        return goal

    async def compute_path(self, goal: Pose2D, start: Pose2D | None) -> Path:
        if code := self.toy.refusal(goal.x, goal.y):
            return Path((), code)
        try:
            found = await asyncio.to_thread(plan, self._navigator.costmap, start or self.toy.where, goal)
        except NavigationError as error:
            return Path((), int(error.code))
        return Path(tuple(found.poses()))

    async def clear_costmaps(self) -> None:
        self._navigator.clear_global()
        self.toy.cleared += 1

    async def dock(self) -> bool:
        return await self._base(Docking())

    async def undock(self) -> bool:
        return await self._base(Undocking())

    def set_initial_pose(self, pose: Pose2D) -> None:
        self.toy.told_where(pose.x, pose.y)

    def celebrate(self, celebration: Celebration) -> None:
        self.toy.notes = [(note.frequency_hz, note.duration_s) for note in celebration.notes]
        self.toy.leds = celebration.led_animation_type, (celebration.led_rgb,) * 6, celebration.led_duration_s

    def record(self, sink: Sink, *, images_hz: float) -> Callable[[], None]:
        """It has no messages of its own."""
        return lambda: None

    async def _base(self, controller: Docking | Undocking) -> bool:
        if not self.toy.can_dock:
            return False
        done: asyncio.Future[bool] = self._loop.create_future()

        def ended(well: bool) -> None:  # in the World's thread
            self._loop.call_soon_threadsafe(lambda: None if done.done() else done.set_result(well))

        self._behaviour = controller, ended
        try:
            return await done
        finally:
            self._behaviour = None

    # --- the World's thread

    def _live(self, tick: Callable[[], None], navigation_velocity: Callable[[float, float], None]) -> None:
        options = WorldOptions(noise_free=True, battery_percentage=80.0)
        try:
            with World(SCENE, start=START, options=options) as world:
                self._set_up(world)
                next_s, count = time.monotonic(), 0
                while not self._closing.is_set():
                    self._step(world, navigation_velocity)
                    self._sense(world, with_pictures=count % PICTURE_EVERY == 0)
                    tick()
                    count += 1
                    next_s = max(next_s + STEP_S, time.monotonic() - STEP_S)
                    self._closing.wait(max(0.0, next_s - time.monotonic()))
        except BaseException as error:
            self._error = error
            raise

    def _set_up(self, world: World) -> None:
        frames, grid, now_s = self._senses.frames, recorded_map(), self._clock.now_s()
        for name, camera in (("rgb", world.rgb_camera), ("depth", world.depth_camera)):
            frames.fix("base_link", name, matrix((camera.x_m, 0.0, camera.z_m), OPTICAL_XYZW))
        frames.fix("base_link", "laser", matrix((LIDAR.x, LIDAR.y, LIDAR_Z_M), quaternion_xyzw(LIDAR.yaw)))
        origin = Pose2D(x=grid.origin_x_m, y=grid.origin_y_m, yaw=0.0)
        if "map" not in self.toy.silent:
            self._senses.map.put(Grid(grid.data, grid.resolution_m, origin), now_s)

    def _step(self, world: World, navigation_velocity: Callable[[float, float], None]) -> None:
        if (by_hand := self.toy.moved_by_hand()) is not None:
            world.teleport(by_hand)
        if (wall_m := self.toy.wall_moved_to()) is not None:
            world.teleport(Pose2D(x=WIDTH_M - wall_m, y=START.y, yaw=0.0))
        self._base_stop.follow()
        if self.toy.base_stop is not None:
            world.set_e_stop(self.toy.base_stop)
        self._navigate(world, navigation_velocity)
        if self._behaviour is None:
            world.command(self._twist.linear_x, self._twist.angular_z)
        else:
            self._let_the_base_drive(world, *self._behaviour)
        world.advance(STEP_S)
        truth = world.truth.pose
        self.toy.where = truth
        self.toy.x, self.toy.y, self.toy.yaw = truth.x - START.x, truth.y - START.y, truth.yaw
        self.toy.docked = world.dock_status().is_docked

    def _let_the_base_drive(self, world: World, controller: Docking | Undocking, ended: Callable[[bool], None]) -> None:
        twist = controller.step(compose(inverse(world.scene.dock), world.truth.pose))
        if twist is None:
            self._behaviour = None
            ended(True)
        else:
            world.command(twist.linear_x, twist.angular_z, behaviour=True)

    def _navigate(self, world: World, navigation_velocity: Callable[[float, float], None]) -> None:
        pose = world.truth.pose
        if self._wanted is not None:
            goal, wanted = self._wanted
            self._wanted = None
            try:
                self._navigator.start(wanted, pose, world.time_s)
            except NavigationError as error:
                goal.finish(GoalEnd(GoalStatus.ABORTED, int(error.code), error.detail))
        goal = self._goal
        if goal is None:
            return
        if goal.cancelled:
            self._navigator.cancel()
            self._goal = None
            return
        progress = self._navigator.step(pose, world.time_s)
        if progress.outcome is Outcome.RUNNING:
            navigation_velocity(progress.twist.linear_x, progress.twist.angular_z)
            self._loop.call_soon_threadsafe(self._on_progress, progress.remaining_m)
            return
        self._goal = None
        status = GoalStatus.SUCCEEDED if progress.outcome is Outcome.SUCCEEDED else GoalStatus.ABORTED
        goal.finish(GoalEnd(status, int(progress.code), progress.detail))

    def _sense(self, world: World, *, with_pictures: bool) -> None:
        toy, senses, now_s, stamp_s = self.toy, self._senses, self._clock.now_s(), time.time()
        if "odom" not in toy.silent:
            odometry = world.odometry()
            senses.poses.add_odometry(stamp_s, odometry.pose)
            senses.odometry.put(Odometry(stamp_s, odometry.pose, odometry.twist), now_s)
            if "pose" not in toy.silent:
                correction = compose(world.localization().pose, inverse(odometry.pose))
                senses.poses.add_map_to_odom(stamp_s, correction, received_s=now_s)
        if "scan" not in toy.silent:
            self._scan(world, stamp_s, now_s)
        if with_pictures and "rgb" not in toy.silent:
            pixels = np.ascontiguousarray(world.rgb()[:, :, ::-1])
            senses.rgb_intrinsics.put(_intrinsics("rgb", world.rgb_camera), now_s)
            senses.rgb.put(ColourImage(stamp_s, "rgb", pixels), now_s)
        if with_pictures and "depth" not in toy.silent:
            image = DepthImage(stamp_s, "depth", world.depth())
            senses.depth_intrinsics.put(_intrinsics("depth", world.depth_camera), now_s)
            senses.depth_history.add(image)
            senses.depth.put(image, now_s)
        battery, dock = world.battery(), world.dock_status()
        senses.battery.put(Battery(percentage=battery.percentage, charging=battery.charging), now_s)
        visible = dock.dock_visible and self.toy.dock_visible  # somebody may stand before it
        senses.dock.put(DockView(dock.is_docked, visible), now_s)
        found = {Hazard(hazard.name) for hazard in world.hazards()} | {Hazard(name) for name in toy.hazards}
        senses.hazards.put(frozenset(found), now_s)
        senses.nav2_missing.put("bt_navigator not active" if toy.navigation == "is_inactive" else "", now_s)

    def _scan(self, world: World, stamp_s: float, now_s: float) -> None:
        measured = world.scan()
        laser = compose(world.truth.pose, LIDAR)
        self._navigator.observe(measured, laser)
        bearings = LIDAR.yaw + measured.angle_min + measured.angle_increment * np.arange(measured.ranges_m.size)
        ranges = measured.ranges_m.astype(np.float64)
        hit = np.isfinite(ranges) & (ranges >= measured.range_min_m)
        x, y = ranges[hit] * np.cos(bearings[hit]) + LIDAR.x, ranges[hit] * np.sin(bearings[hit])
        open_rad = np.array([math.remainder(b, math.tau) for b in bearings[np.isinf(ranges)]])
        self._senses.scan.put(Scan(stamp_s, np.stack([x, y], axis=1), open_rad=open_rad), now_s)


def _intrinsics(frame_id: str, camera: CameraModel) -> Intrinsics:
    values: Any = camera
    return Intrinsics(frame_id, camera.width_px, camera.height_px, values.fx, values.fy, values.cx, values.cy)
