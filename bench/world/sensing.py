"""What the simulated robot tells robot_bridge: each sensor's newest value, as the ROS adapter would have read it."""

import math
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from contracts.motion import Hazard
from contracts.robot import Battery
from robot_bridge.navigation import maps
from robot_bridge.sensing import sensor_readings as read
from robot_bridge.sensing.transforms import matrix
from sim import world as sim_world
from sim.world import CameraModel, OccupancyGrid, World
from sim.world.robot import LIDAR
from sim.world.world import Moment, Pixels

RGB_OPTICAL, STEREO_OPTICAL = "oakd_rgb_camera_optical_frame", "oakd_stereo_camera_optical_frame"
OPTICAL_XYZW = (-0.5, 0.5, -0.5, 0.5)
CORRECTION_AHEAD_S = 1.0
"""AMCL's transform_tolerance."""
HAZARDS = {
    sim_world.Hazard.BACKUP_LIMIT: Hazard.BACKUP_LIMIT,
    sim_world.Hazard.BUMP: Hazard.BUMP,
    sim_world.Hazard.STALL: Hazard.STALL,
}


class ColourAt(read.ColourImage):
    """A colour picture that is taken when somebody looks at it."""

    def __init__(self, stamp_s: float, moment: Moment, camera: CameraModel) -> None:
        vars(self).update(_moment=moment, _size_px=(camera.width_px, camera.height_px))
        object.__setattr__(self, "stamp_s", stamp_s)
        object.__setattr__(self, "frame_id", RGB_OPTICAL)

    @cached_property
    def pixels(self) -> Pixels:  # pyright: ignore[reportIncompatibleVariableOverride]
        moment: Moment = vars(self)["_moment"]
        return np.asarray(cv2.cvtColor(moment.rgb(), cv2.COLOR_RGB2BGR), np.uint8)

    @property
    def size_px(self) -> tuple[int, int]:
        return vars(self)["_size_px"]


class DepthAt(read.DepthImage):
    """A depth picture that is taken when somebody looks at it, in whole millimetres."""

    def __init__(self, stamp_s: float, moment: Moment, camera: CameraModel) -> None:
        vars(self).update(_moment=moment, _size_px=(camera.width_px, camera.height_px))
        object.__setattr__(self, "stamp_s", stamp_s)
        object.__setattr__(self, "frame_id", STEREO_OPTICAL)

    @cached_property
    def depth_m(self) -> NDArray[np.float32]:  # pyright: ignore[reportIncompatibleVariableOverride]
        moment: Moment = vars(self)["_moment"]
        return (np.rint(moment.depth() * 1000.0) / 1000.0).astype(np.float32)

    @property
    def size_px(self) -> tuple[int, int]:
        return vars(self)["_size_px"]


class Sensing:
    """Fills `senses` from the World; `now_s` is when it is told."""

    def __init__(self, senses: read.SensorReadings) -> None:
        self.senses = senses
        self._told: dict[str, object] = {}

    def begin(self, world: World, recorded: OccupancyGrid, now_s: float) -> None:
        """What is told once: where the sensors sit, the cameras, the map."""
        senses = self.senses
        cameras = {RGB_OPTICAL: world.rgb_camera, STEREO_OPTICAL: world.depth_camera}
        for frame, camera in cameras.items():
            senses.frames.fix("base_link", frame, matrix((camera.x_m, 0.0, camera.z_m), OPTICAL_XYZW))
        senses.rgb_intrinsics.put(_intrinsics(RGB_OPTICAL, world.rgb_camera), now_s)
        senses.depth_intrinsics.put(_intrinsics(STEREO_OPTICAL, world.depth_camera), now_s)
        self.map(recorded, now_s)
        senses.localiser_listens.put(True, now_s)
        self.alive(now_s)

    def map(self, recorded: OccupancyGrid, now_s: float) -> None:
        height, width = recorded.data.shape
        origin = Pose2D(x=recorded.origin_x_m, y=recorded.origin_y_m, yaw=0.0)
        grid = maps.understood(recorded.data.ravel().tolist(), width, height, recorded.resolution_m, origin)
        self.senses.map.put(grid, now_s)

    def alive(self, now_s: float) -> None:
        """Once a second."""
        self.senses.nav2_missing.put("", now_s)
        self.senses.hazards_offered.put(True, now_s)

    def scan(self, world: World, correction: Pose2D | None, now_s: float) -> sim_world.Scan:
        """One turn of the laser, and the localiser's word on it."""
        measured = world.scan()
        angles = LIDAR.yaw + measured.angle_min + measured.angle_increment * np.arange(len(measured.ranges_m))
        hit = np.isfinite(measured.ranges_m)
        ranges = measured.ranges_m[hit].astype(np.float64)
        points = np.stack([ranges * np.cos(angles[hit]) + LIDAR.x, ranges * np.sin(angles[hit])], axis=1)
        open_rad = np.arctan2(np.sin(angles[~hit]), np.cos(angles[~hit]))
        self.senses.scan.put(read.Scan(now_s, points, open_rad=open_rad, laser_m=(LIDAR.x, LIDAR.y)), now_s)
        if correction is not None:
            self.senses.poses.add_map_to_odom(now_s + CORRECTION_AHEAD_S, correction, received_s=now_s)
        return measured

    def odometry(self, world: World, now_s: float) -> Pose2D:
        measured = world.odometry()
        self.senses.poses.add_odometry(now_s, measured.pose)
        self.senses.odometry.put(read.Odometry(now_s, measured.pose, measured.twist), now_s)
        return measured.pose

    def base(self, world: World, now_s: float) -> None:
        """Told on change only."""
        dock, found = world.dock_status(), world.hazards()
        if self._changed("dock", dock):
            self.senses.dock.put(read.DockView(dock.is_docked, dock.dock_visible), now_s)
        if self._changed("hazards", found):
            self.senses.hazards.put(frozenset(HAZARDS[one] for one in found), now_s)

    def battery(self, world: World, now_s: float) -> None:
        measured = world.battery()
        percentage = round(measured.percentage)
        if self._changed("battery", (percentage, measured.charging)):
            self.senses.charging_told.put(True, now_s)
            self.senses.battery.put(Battery(percentage=float(percentage), charging=measured.charging), now_s)

    def colour(self, world: World, now_s: float) -> None:
        self.senses.rgb.put(ColourAt(now_s, world.moment(), world.rgb_camera), now_s)

    def depth(self, world: World, now_s: float) -> None:
        image = DepthAt(now_s, world.moment(), world.depth_camera)
        self.senses.depth_history.add(image)
        self.senses.depth.put(image, now_s)

    def _changed(self, what: str, now: object) -> bool:
        before = self._told.get(what, math.nan)
        self._told[what] = now
        return before != now


def _intrinsics(frame: str, camera: CameraModel) -> read.Intrinsics:
    return read.Intrinsics(
        frame, camera.width_px, camera.height_px, camera.fx, camera.fy, camera.cx, camera.cy
    )  # fmt: skip
