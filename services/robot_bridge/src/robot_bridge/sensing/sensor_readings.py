"""What the robot perceives, as plain frozen values: no ROS types beyond the adapter."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D, Twist2D
from contracts.motion import Hazard
from contracts.robot import BaseStopState, Battery
from geometry.grids import OccupancyGrid
from mesh.latest_value import LatestValue
from robot_bridge.sensing.blindness import NO_ARCS, Arcs
from robot_bridge.sensing.endpoints import Mismatch
from robot_bridge.sensing.reception import Reception
from robot_bridge.sensing.stamps import Clocks
from robot_bridge.sensing.transform_buffer import PoseBuffer, TransformBuffer


@dataclass(frozen=True, slots=True)
class Scan:
    """A laser scan as points in base_link.

    `points_m` is (n, 2): the beams that hit something.
    """

    stamp_s: float
    points_m: NDArray[np.float64]
    open_rad: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    """(m,) bearings, in base_link, of the beams that met nothing in reach."""
    blind: Arcs = field(default_factory=lambda: NO_ARCS)
    """Where it knows nothing, as seen from `laser_m`."""
    laser_m: tuple[float, float] = (0.0, 0.0)
    """Where in base_link it is mounted."""
    note: str = ""
    """What a person should know of it."""


@dataclass(frozen=True, slots=True)
class Odometry:
    """base_link in odom, and its measured velocity."""

    stamp_s: float
    pose: Pose2D
    twist: Twist2D


@dataclass(frozen=True, slots=True, eq=False)
class ColourImage:
    """`pixels` is (height, width, 3) uint8, BGR."""

    stamp_s: float
    frame_id: str
    pixels: NDArray[np.uint8]

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height."""
        return self.pixels.shape[1], self.pixels.shape[0]


@dataclass(frozen=True, slots=True, eq=False)
class DepthImage:
    """`depth_m` is (height, width) float32 along the optical axis; 0 or NaN where nothing was measured."""

    stamp_s: float
    frame_id: str
    depth_m: NDArray[np.float32]

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height."""
        return self.depth_m.shape[1], self.depth_m.shape[0]


ASPECT_TOLERANCE = 0.02
"""Of a picture that was made smaller: its sides are whole pixels."""


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """A pinhole camera: focal lengths and principal point in pixels of a width_px x height_px image."""

    frame_id: str
    width_px: int
    height_px: int
    fx: float
    fy: float
    cx: float
    cy: float

    def why_not_of(self, width_px: int, height_px: int) -> str:
        """Why no picture of that size is this camera's ('' where it may be): another cut, not just another size."""
        shape, other = self.width_px / self.height_px, width_px / height_px
        if abs(shape / other - 1.0) <= ASPECT_TOLERANCE:
            return ""
        return (
            f"camera_info describes {self.width_px} x {self.height_px} pixels, the picture has {width_px} x {height_px}"
            ": that is another cut, not another size"
        )

    def scaled_to(self, width_px: int, height_px: int) -> "Intrinsics":
        """The same camera delivering another image size."""
        sx, sy = width_px / self.width_px, height_px / self.height_px
        return Intrinsics(self.frame_id, width_px, height_px, self.fx * sx, self.fy * sy, self.cx * sx, self.cy * sy)


@dataclass(frozen=True, eq=False)
class Grid(OccupancyGrid):
    """The robot's map as it was understood."""

    note: str = ""
    """How it differs from what was sent; '' where it does not."""


@dataclass(frozen=True, slots=True)
class DockView:
    """What the base knows of its dock."""

    is_docked: bool
    dock_visible: bool = False


class LatestHazards(LatestValue[frozenset[Hazard]]):
    """The newest vector is the state until another comes; a bump shorter than a tick must not be missed."""

    def __init__(self) -> None:
        super().__init__()
        self._seen_s: dict[Hazard, float] = {}

    def put(self, value: frozenset[Hazard], received_s: float) -> None:
        """A hazard that is no longer among them lasted until now."""
        self._seen_s = self._seen_s | dict.fromkeys(value | (self.value or frozenset()), received_s)
        super().put(value, received_s)

    def active(self, now_s: float, hold_s: float) -> frozenset[Hazard]:
        """Those of the newest message, however old: they come on change only. And those seen within `hold_s`."""
        lately = frozenset(hazard for hazard, seen_s in self._seen_s.items() if now_s - seen_s <= hold_s)
        return lately | (self.value or frozenset())


DEPTH_IMAGES_KEPT = 12
NAV2_SILENCE_S_MAX = 3.0
NO_POINTS: NDArray[np.float64] = np.empty((0, 2))


class DepthHistory:
    """The last few depth images, so that a box can be measured in the image taken with it."""

    def __init__(self) -> None:
        self._images: tuple[DepthImage, ...] = ()

    def add(self, image: DepthImage) -> None:
        self._images = (*self._images[-(DEPTH_IMAGES_KEPT - 1) :], image)

    def nearest(self, stamp_s: float | None) -> DepthImage | None:
        """The image taken closest to `stamp_s`, or the newest."""
        images = self._images
        if not images:
            return None
        if stamp_s is None:
            return images[-1]
        return min(images, key=lambda image: abs(image.stamp_s - stamp_s))


@dataclass(frozen=True, slots=True)
class SensorReadings:
    """Every sensor's newest value. Written by the robot's thread, read by anyone."""

    scan: LatestValue[Scan] = field(default_factory=LatestValue[Scan])
    odometry: LatestValue[Odometry] = field(default_factory=LatestValue[Odometry])
    rgb: LatestValue[ColourImage] = field(default_factory=LatestValue[ColourImage])
    depth: LatestValue[DepthImage] = field(default_factory=LatestValue[DepthImage])
    rgb_intrinsics: LatestValue[Intrinsics] = field(default_factory=LatestValue[Intrinsics])
    depth_intrinsics: LatestValue[Intrinsics] = field(default_factory=LatestValue[Intrinsics])
    map: LatestValue[Grid] = field(default_factory=LatestValue[Grid])
    battery: LatestValue[Battery] = field(default_factory=LatestValue[Battery])
    charging_told: LatestValue[bool] = field(default_factory=LatestValue[bool])
    """Whether the battery says if it is charged; one that does not is charged on the dock."""
    dock: LatestValue[DockView] = field(default_factory=LatestValue[DockView])
    hazards: LatestHazards = field(default_factory=LatestHazards)
    base_stop: LatestValue[BaseStopState] = field(default_factory=LatestValue[BaseStopState])
    """Told about once a second, and whenever the wheels say something."""
    hazards_offered: LatestValue[bool] = field(default_factory=LatestValue[bool])
    """Whether somebody would tell of a hazard if there were one. Told about once a second."""
    other_drivers: LatestValue[tuple[str, ...]] = field(default_factory=LatestValue[tuple[str, ...]])
    """Nodes that publish cmd_vel beside this bridge. Told about once a second."""
    foreign_velocity: LatestValue[tuple[float, float]] = field(default_factory=LatestValue[tuple[float, float]])
    """m/s and rad/s that somebody else has sent the base; never a standstill."""
    localiser_listens: LatestValue[bool] = field(default_factory=LatestValue[bool])
    """Whether somebody takes initial poses. Told about once a second."""
    mismatches: LatestValue[tuple[Mismatch, ...]] = field(default_factory=LatestValue[tuple[Mismatch, ...]])
    """Who else is on the bridge's topics in another type."""
    nav2_missing: LatestValue[str] = field(default_factory=LatestValue[str])
    """What keeps Nav2 from taking goals; '' when nothing does. Told about once a second."""
    depth_history: DepthHistory = field(default_factory=DepthHistory)
    reception: Reception = field(default_factory=Reception)
    clocks: Clocks = field(default_factory=Clocks)
    poses: PoseBuffer = field(default_factory=PoseBuffer)
    frames: TransformBuffer = field(default_factory=TransformBuffer)

    def why_no_nav2(self, now_s: float) -> str:
        """'' while Nav2 is active, by what was heard lately."""
        missing, age_s = self.nav2_missing.value, self.nav2_missing.age_s(now_s)
        if missing is None or age_s is None or age_s > NAV2_SILENCE_S_MAX:
            return "nothing has been heard of it"
        return missing
