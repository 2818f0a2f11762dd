"""The world: a robot in a home, advanced step by step on a simulated clock; everything a TurtleBot4 Lite would say."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from geometry.poses import compose, wrap
from sim.home import Home
from sim.world.base import Base
from sim.world.body import Body
from sim.world.occupancy import record_map
from sim.world.rendering import DepthRenderer, open_renderer, render_rgb
from sim.world.robot import DEPTH_CAMERA, RGB_CAMERA, TIMESTEP_S
from sim.world.scenes import scene_of
from sim.world.sensors import (
    SCAN_RANGE_MAX_M,
    SCAN_RANGE_MIN_M,
    SCAN_RAYS,
    BatteryModel,
    DepthNoise,
    LocalizationError,
    OdometryDrift,
    noisy_scan,
)
from sim.world.solids import Volume, volumes_of_body
from sim.world.types import (
    Battery,
    CameraModel,
    DockStatus,
    Floats,
    Hazard,
    Imu,
    OccupancyGrid,
    Odometry,
    PoseEstimate,
    Scan,
    Scene,
    SceneThing,
    ThingTruth,
    Truth,
    WorldOptions,
)

Pixels = NDArray[np.uint8]
Qpos = NDArray[np.float64]

_SLOW_EVERY = 10
"""Physics steps (5 ms) between updates of odometry, battery and localiser."""
_STALL_AFTER_S = 0.6
_STILL_M_S, _STILL_RAD_S = 0.005, 0.02
_DOCKED_WITHIN_M, _DOCKED_WITHIN_RAD = 0.06, 0.25
_DOCK_SEEN_WITHIN_M, _DOCK_SEEN_WITHIN_RAD = 2.0, 1.0
_SCAN_ANGLES = -math.pi + np.arange(SCAN_RAYS) * (2 * math.pi / SCAN_RAYS)


@dataclass(frozen=True)
class Moment:
    """What the cameras would have seen then; noise is drawn when a picture is taken."""

    _take_rgb: Callable[[Qpos], Pixels]
    _take_depth: Callable[[Qpos], Floats]
    _qpos: Qpos

    def rgb(self) -> Pixels:
        """As `World.rgb`."""
        return self._take_rgb(self._qpos)

    def depth(self) -> Floats:
        """As `World.depth`."""
        return self._take_depth(self._qpos)


class World:
    """A simulated TurtleBot4 Lite in a home; deterministic given home (or scene), seed and the calls made.

    Nothing here knows wall time, threads or ROS. All calls come from one thread: the cameras' GL contexts belong to it.
    Ground truth is `truth` and `volumes`; every other reading has the sensor's own error.
    """

    rgb_camera: CameraModel = RGB_CAMERA
    depth_camera: CameraModel = DEPTH_CAMERA

    def __init__(
        self,
        home: Home | Scene,
        *,
        seed: int = 0,
        start: Pose2D | None = None,
        options: WorldOptions | None = None,
    ) -> None:
        """`start` is base_link in the map; none = docked. Cameras open when a picture is first asked for."""
        self.scene: Scene = home if isinstance(home, Scene) else scene_of(home)
        self.options = options or WorldOptions()
        streams = np.random.SeedSequence(seed).spawn(6)
        odometry, localization, self._scan_rng, self._depth_rng, self._imu_rng, self._rgb_rng = (
            np.random.Generator(np.random.SFC64(stream)) for stream in streams
        )
        self._body = Body(self.scene, start or self.scene.dock, light=self.options.light, arm=self.options.arm)
        self.arm = self._body.arm
        self._base = Base(self.options.base_timeout_s)
        self._odometry = OdometryDrift(self.options, odometry)
        self._localization = LocalizationError(self.options, localization)
        self._battery = BatteryModel(self.options.battery_percentage)
        self._steps, self._owed_s = 0, 0.0
        self._last = self._counted = self._body.pose()
        self._path_m, self._collisions, self._stalled_s, self._moved_at_s = 0.0, 0, 0.0, 0.0
        self._touching: tuple[str, ...] = ()
        self._rgb_renderer: mujoco.Renderer | None = None
        self._depth: tuple[DepthRenderer, DepthNoise] | None = None
        self._update_dock()

    # --- time and motion

    @property
    def time_s(self) -> float:
        """Simulated seconds since the world began."""
        return self._steps * TIMESTEP_S

    def advance(self, seconds: float) -> None:
        """Let time pass, in whole steps of 5 ms; what is left over is added to the next call."""
        if not (math.isfinite(seconds) and seconds >= 0.0):
            raise ValueError(f"time passes forward, not by {seconds} s")
        self._owed_s += seconds
        steps = math.floor(self._owed_s / TIMESTEP_S + 1e-6)
        self._owed_s -= steps * TIMESTEP_S
        for _ in range(steps):
            self._step()

    def command(self, linear_x: float, angular_z: float, *, behaviour: bool = False) -> bool:
        """Like one message on `cmd_vel` (m/s, rad/s): clipped to the base's limits, good for `base_timeout_s`.

        False = refused: not finite, or the e-stop is on. Reversing ends after 0.15 m (hazard BACKUP_LIMIT) unless it is
        the base's own `behaviour`, such as backing off the dock.
        """
        return self._base.command(linear_x, angular_z, self.time_s, behaviour=behaviour)

    def set_e_stop(self, on: bool) -> None:
        """The base's own stop: it brakes and takes no command until it is off again."""
        self._base.set_e_stop(on)

    @property
    def e_stop_on(self) -> bool:
        return self._base.e_stop_on

    def teleport(self, pose: Pose2D) -> None:
        """Put the robot somewhere at rest, for evaluation and tours; no way is counted and odometry does not notice."""
        self._body.place(pose)
        self._base = self._base.at_rest()
        self._last = self._counted = self._body.pose()
        self._touching, self._stalled_s = self._body.touching(), 0.0
        self._update_dock()

    def move_thing(self, thing_id: str, x_m: float, y_m: float, z_m: float, yaw: float) -> None:
        """Somebody carries a thing: its base's centre is there from now on. KeyError for an unknown id."""
        self._body.move(thing_id, (x_m, y_m, z_m), yaw)
        for read_before in ("grid", "_things"):
            self.__dict__.pop(read_before, None)

    # --- sensors

    def rgb(self) -> Pixels:
        """The colour preview: uint8 (250, 250, 3), RGB. Raises RenderingUnavailableError."""
        return self._rgb(self._body.data)

    def depth(self) -> Floats:
        """Stereo depth: float32 (400, 640), m along the optical axis, 0.0 = no return; an array of its own.

        Raises RenderingUnavailableError.
        """
        return self._depth_image(self._body.data)

    def moment(self) -> "Moment":
        """The World as it is now: its pictures can be taken at any later time."""
        return Moment(
            lambda qpos: self._rgb(self._body.data_at(qpos)),
            lambda qpos: self._depth_image(self._body.data_at(qpos)),
            self._body.data.qpos.copy(),
        )

    def _rgb(self, data: mujoco.MjData) -> Pixels:
        if self._rgb_renderer is None:
            self._rgb_renderer = open_renderer(self._body.model, RGB_CAMERA.width_px, RGB_CAMERA.height_px)
        picture = render_rgb(self._rgb_renderer, data, "rgb")
        if self.options.rgb_noise_sigma > 0.0:
            grain = self.options.rgb_noise_sigma * self._rgb_rng.standard_normal(picture.shape, dtype=np.float32)
            picture = np.clip(picture + grain, 0, 255).astype(np.uint8)
        return picture

    def _depth_image(self, data: mujoco.MjData) -> Floats:
        if self._depth is None:
            size = DEPTH_CAMERA.height_px, DEPTH_CAMERA.width_px
            self._depth = DepthRenderer(self._body.model, *size), DepthNoise(*size, self.options, self._depth_rng)
        renderer, noise = self._depth
        return noise.apply(renderer.render(data, "depth"), self._depth_rng)

    def scan(self) -> Scan:
        """One turn of the lidar, taken at one instant; see `Scan` for its frame."""
        sigma_m = 0.0 if self.options.noise_free else self.options.scan_sigma_m
        distances = self._body.ranges(_SCAN_ANGLES, SCAN_RANGE_MAX_M)
        return Scan(
            self.time_s,
            noisy_scan(distances, self._scan_rng, sigma_m),
            -math.pi,
            2 * math.pi / SCAN_RAYS,
            SCAN_RANGE_MIN_M,
            SCAN_RANGE_MAX_M,
        )

    def odometry(self) -> Odometry:
        """Dead reckoning from where the world began; updated at 20 Hz."""
        return Odometry(self.time_s, self._odometry.pose, self._body.twist())

    def localization(self) -> PoseEstimate:
        """What a localiser would say: the true pose plus an error that wanders over seconds."""
        truth, (x, y, yaw) = self._body.pose(), self._localization.value
        pose = Pose2D(x=truth.x + x, y=truth.y + y, yaw=wrap(truth.yaw + yaw))
        options = self.options
        sigma_m, sigma_yaw = options.localization_sigma_m, options.localization_sigma_yaw_rad
        return PoseEstimate(self.time_s, pose, sigma_m, sigma_m, sigma_yaw)

    def imu(self) -> Imu:
        """Rates and specific force with white noise; the heading is odometry's."""
        rate, force = self._body.imu()
        if not self.options.noise_free:
            rate = rate + 0.003 * self._imu_rng.standard_normal(3)
            force = force + 0.05 * self._imu_rng.standard_normal(3)
        return Imu(self.time_s, self._odometry.pose.yaw, tuple(rate.tolist()), tuple(force.tolist()))

    def battery(self) -> Battery:
        return Battery(self._battery.percentage, self._battery.charging, self._battery.voltage_v)

    def dock_status(self) -> DockStatus:
        """`dock_visible`: within 2 m and 57 degrees ahead of the docked robot's place."""
        return DockStatus(self._dock_visible, self._docked)

    def hazards(self) -> tuple[Hazard, ...]:
        """What the base complains of now, lowest type first."""
        active = {
            Hazard.BACKUP_LIMIT: self._base.backup_limited,
            Hazard.BUMP: self._body.bumped(),
            Hazard.STALL: self._stalled_s >= _STALL_AFTER_S,
        }
        return tuple(hazard for hazard, on in active.items() if on)

    # --- map and truth

    @cached_property
    def grid(self) -> OccupancyGrid:
        """The map somebody recorded with SLAM: see `sim.world.occupancy.record_map`."""
        out_of_dock = compose(self.scene.dock, Pose2D(x=-0.4, y=0.0, yaw=0.0))
        return record_map(self._body.model, self._body.data, out_of_dock, self._body.root)

    @property
    def truth(self) -> Truth:
        """Ground truth, for scoring only."""
        return Truth(
            self.time_s,
            self._body.pose(),
            self._body.twist(),
            self._path_m,
            self._moved_at_s,
            self._collisions,
            self._touching,
            self._things,
        )

    def volumes(self, thing_id: str) -> tuple[Volume, ...]:
        """Truth: the oriented boxes round a thing's parts, in the map; KeyError for an unknown id."""
        model, data = self._body.model, self._body.data
        return volumes_of_body(model, data, model.body(thing_id).id)

    def first_hit(self, start: NDArray[np.float64], target: NDArray[np.float64]) -> tuple[str, float]:
        """Truth: name of the body a ray from `start` to `target` (3,) meets first, and how far away, m; "" for none."""
        return self._body.first_hit(start, target)

    def close(self) -> None:
        """Release the cameras; a closed world must not render again."""
        if self._rgb_renderer is not None:
            self._rgb_renderer.close()
        if self._depth is not None:
            self._depth[0].close()
        self._rgb_renderer = self._depth = None

    def __enter__(self) -> "World":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- one step

    @cached_property
    def _things(self) -> tuple[ThingTruth, ...]:
        """Things never move, so this is computed once."""
        return tuple(self._thing(thing) for thing in self.scene.things)

    def _thing(self, thing: SceneThing) -> ThingTruth:
        corners = np.concatenate([volume.corners() for volume in self.volumes(thing.id)])
        x, y, z = ((corners.min(0) + corners.max(0)) / 2).tolist()
        return ThingTruth(thing.id, thing.kind, thing.colour, x, y, z, thing.furniture)

    def _step(self) -> None:
        forward_m_s, turn_rad_s = self._body.speeds()
        if abs(forward_m_s) >= _STILL_M_S or abs(turn_rad_s) >= _STILL_RAD_S:
            self._moved_at_s = self.time_s
        wheels = self._base.tick(self.time_s, forward_m_s * TIMESTEP_S, TIMESTEP_S)
        self._body.step(*wheels.rad_s)
        self._steps += 1
        if self._steps % _SLOW_EVERY == 0:
            self._update()

    def _update(self) -> None:
        dt_s = _SLOW_EVERY * TIMESTEP_S
        pose, last = self._body.pose(), self._last
        x, y, cos, sin = pose.x - last.x, pose.y - last.y, math.cos(last.yaw), math.sin(last.yaw)
        self._odometry.move(cos * x + sin * y, cos * y - sin * x, wrap(pose.yaw - last.yaw))
        self._last = pose
        way_m = math.hypot(pose.x - self._counted.x, pose.y - self._counted.y)
        if way_m >= 0.005:  # standing, the body trembles by micrometres: that is no way
            self._path_m, self._counted = self._path_m + way_m, pose
        self._localization.tick(dt_s)
        self._battery.tick(dt_s, self._body.twist().linear_x, self._docked)
        now = self._body.touching()
        self._collisions += len(set(now) - set(self._touching))
        self._touching = now
        self._update_stall(dt_s)
        self._update_dock()

    def _update_stall(self, dt_s: float) -> None:
        """Stalled: told to move for a while and not moving."""
        twist, wheels = self._body.twist(), self._base.wheels
        wanted = max(abs(wheels.left_m_s), abs(wheels.right_m_s))
        moving = abs(twist.linear_x) + 0.1165 * abs(twist.angular_z)
        self._stalled_s = self._stalled_s + dt_s if wanted > 0.03 and moving < 0.25 * wanted else 0.0

    def _update_dock(self) -> None:
        pose, dock = self._body.pose(), self.scene.dock
        away_m = math.hypot(dock.x - pose.x, dock.y - pose.y)
        self._docked = away_m < _DOCKED_WITHIN_M and abs(wrap(pose.yaw - dock.yaw)) < _DOCKED_WITHIN_RAD
        nose_x, nose_y = dock.x + 0.2 * math.cos(dock.yaw), dock.y + 0.2 * math.sin(dock.yaw)
        bearing = wrap(math.atan2(nose_y - pose.y, nose_x - pose.x) - pose.yaw)
        self._dock_visible = self._docked or (away_m < _DOCK_SEEN_WITHIN_M and abs(bearing) < _DOCK_SEEN_WITHIN_RAD)
