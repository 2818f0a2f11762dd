"""What the simulated robot measures, what the map is, and the ground truth kept apart for scoring."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D, Twist2D
from sim.world.arm.models import ArmModel

Floats = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Scan:
    """One turn of the lidar in `rplidar_link`, whose pose in base_link is `sim.world.robot.LIDAR`, 0.140 m high.

    `ranges_m[i]` (float32, m, `inf` where nothing was hit) was measured at `angle_min + i * angle_increment`,
    counter-clockwise from the lidar's own heading: it is mounted a quarter turn to the left, so straight ahead of the
    robot is at -pi/2.
    """

    stamp_s: float
    ranges_m: Floats
    angle_min: float
    angle_increment: float
    range_min_m: float
    range_max_m: float


@dataclass(frozen=True, slots=True)
class Odometry:
    """base_link in `odom` (zero where the world began, drifting since) and its velocity, measured."""

    stamp_s: float
    pose: Pose2D
    twist: Twist2D


@dataclass(frozen=True, slots=True)
class PoseEstimate:
    """base_link in `map` as a localiser believes it, with one standard deviation of each coordinate."""

    stamp_s: float
    pose: Pose2D
    sigma_x_m: float
    sigma_y_m: float
    sigma_yaw_rad: float

    @property
    def covariance(self) -> tuple[float, ...]:
        """The 36 numbers of a ROS PoseWithCovariance: x, y, z, roll, pitch, yaw, row by row."""
        cells = [0.0] * 36
        cells[0], cells[7], cells[35] = self.sigma_x_m**2, self.sigma_y_m**2, self.sigma_yaw_rad**2
        return tuple(cells)


@dataclass(frozen=True, slots=True)
class Imu:
    """Heading since the world began (rad, drifting), rates (rad/s) and specific force (m/s^2) in base_link."""

    stamp_s: float
    yaw: float
    angular_velocity: tuple[float, float, float]
    linear_acceleration: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Battery:
    """Charge left in percent (0..100), and whether the dock is filling it."""

    percentage: float
    charging: bool
    voltage_v: float


@dataclass(frozen=True, slots=True)
class DockStatus:
    dock_visible: bool
    is_docked: bool


class Hazard(IntEnum):
    """irobot_create_msgs/HazardDetection types that this world can produce."""

    BACKUP_LIMIT = 0
    BUMP = 1
    STALL = 3


@dataclass(frozen=True, slots=True)
class OccupancyGrid:
    """The recorded map: int8 (H, W), 0 free, 100 occupied, -1 unknown; row 0 at the origin, x along the columns."""

    data: NDArray[np.int8]
    resolution_m: float
    origin_x_m: float
    origin_y_m: float

    def cell(self, x_m: float, y_m: float) -> tuple[int, int]:
        """Row and column that hold a point of the map; they may lie outside the grid."""
        return (
            math.floor((y_m - self.origin_y_m) / self.resolution_m),
            math.floor((x_m - self.origin_x_m) / self.resolution_m),
        )

    def centre(self, row: int, column: int) -> tuple[float, float]:
        """x, y of a cell's middle, m in the map."""
        return (
            self.origin_x_m + (column + 0.5) * self.resolution_m,
            self.origin_y_m + (row + 0.5) * self.resolution_m,
        )

    def centres(self, rows: NDArray[np.int64], columns: NDArray[np.int64]) -> NDArray[np.float64]:
        """(n, 2) middles of many cells, x and y in m."""
        cells = np.stack([columns, rows], axis=1).astype(np.float64)
        return np.array([self.origin_x_m, self.origin_y_m]) + (cells + 0.5) * self.resolution_m

    def at(self, x_m: float, y_m: float) -> int:
        """The cell's value; -1 outside the grid."""
        row, column = self.cell(x_m, y_m)
        inside = 0 <= row < self.data.shape[0] and 0 <= column < self.data.shape[1]
        return int(self.data[row, column]) if inside else -1


@dataclass(frozen=True, slots=True)
class CameraModel:
    """A pinhole camera looking along base_link's x axis from (x_m, 0, z_m); focal lengths and centre in pixels."""

    width_px: int
    height_px: int
    fx: float
    fy: float
    cx: float
    cy: float
    x_m: float
    z_m: float

    @property
    def horizontal_fov_rad(self) -> float:
        return 2 * math.atan(self.width_px / (2 * self.fx))


@dataclass(frozen=True, slots=True)
class ThingTruth:
    """A thing as it really stands: its id (= MuJoCo body name), kind, colour, and the middle of its bounds in m."""

    id: str
    kind: str
    colour: str
    """Empty where the kind comes in its natural colour only."""
    x_m: float
    y_m: float
    z_m: float
    furniture: bool = False


@dataclass(frozen=True, slots=True)
class Truth:
    """Ground truth, for scoring only: nothing a mission may look at."""

    stamp_s: float
    pose: Pose2D
    twist: Twist2D
    path_length_m: float
    moved_at_s: float
    """The newest simulated time at which it moved: faster than 5 mm/s or 0.02 rad/s."""
    collisions: int
    """How often the robot began to touch something."""
    touching: tuple[str, ...]
    """Names of the bodies it touches now."""
    things: tuple[ThingTruth, ...]


@dataclass(frozen=True, slots=True)
class SceneThing:
    """Something a mission may look for; `id` is the name of its MuJoCo body, `colour` may be empty."""

    id: str
    kind: str
    colour: str = ""
    furniture: bool = False


@dataclass(frozen=True)
class Scene:
    """A home with the robot in it, ready to be compiled: what `World` needs to know of a home, and no more."""

    xml: str
    """MJCF that includes the robot of `sim.world.robot`."""
    assets: Mapping[str, Any]
    """Files the MJCF names, by name."""
    dock: Pose2D
    """Where base_link is while the robot is docked, facing the dock."""
    things: tuple[SceneThing, ...] = ()


@dataclass(frozen=True)
class WorldOptions:
    """How imperfect the robot is; the defaults are those of a TurtleBot4 Lite in good order."""

    odometry_scale_sigma: float = 0.006
    """Relative error of distances, one draw for each world."""
    odometry_turn_scale_sigma: float = 0.006
    """Relative error of turns, one draw for each world."""
    odometry_heading_sigma_rad_per_sqrt_m: float = 0.006
    localization_sigma_m: float = 0.022
    localization_sigma_yaw_rad: float = 0.015
    localization_wander_s: float = 12.0
    """Time after which the localiser's error has forgotten itself."""
    scan_sigma_m: float = 0.01
    depth_sigma_m_at_1m: float = 0.012
    depth_sigma_exponent: float = 3.461
    depth_sigma_max_m: float = 0.5
    depth_correlated_share: float = 0.75
    """Share of the depth noise's variance that neighbouring pixels have in common: averaging cannot remove it."""
    depth_min_m: float = 0.2
    depth_max_m: float = 3.0
    rgb_noise_sigma: float = 0.0
    """Grey levels of 255 added to each pixel of the colour picture."""
    light: float = 1.0
    """Share of the home's usual light."""
    battery_percentage: float = 92.0
    base_timeout_s: float = 0.5
    """iRobot's default of `wheels_stop_threshold_sec`: so long the base follows its last command."""
    noise_free: bool = field(default=False)
    """Every sensor tells the truth: for tests of what stands behind the noise."""
    arm: ArmModel | None = None
    """On the robot's deck; none = a TurtleBot4 Lite as it is sold."""
