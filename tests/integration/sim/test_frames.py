"""What the simulated robot says of its lidar, its tf included, as robot_bridge understands it."""

import math

import numpy as np
import pytest

from contracts.geometry import Pose2D
from robot_bridge.adapters.ros.convert import laser
from robot_bridge.sensing.transforms import matrix
from sim.ros import messages
from sim.world.robot import DEPTH_CAMERA, LIDAR, LIDAR_Z_M, RGB_CAMERA
from support.simulated_room import world_at


@pytest.mark.parametrize(
    ("bearing_rad", "x_m", "y_m"), [(0.0, 3.0, 0.0), (math.pi / 2, LIDAR.x, 2.6), (-math.pi / 2, LIDAR.x, -1.4)]
)
def test_the_walls_are_where_they_are_however_the_lidar_is_mounted(bearing_rad: float, x_m: float, y_m: float) -> None:
    fixed = messages.fixed_frames(RGB_CAMERA, DEPTH_CAMERA, LIDAR, LIDAR_Z_M, 0)
    mounted = next(t.transform for t in fixed.transforms if t.child_frame_id == messages.LASER)
    at, turned = mounted.translation, mounted.rotation
    in_base = matrix((at.x, at.y, at.z), (turned.x, turned.y, turned.z, turned.w))
    seen = laser.scan(messages.laser_scan(world_at(Pose2D(x=3.0, y=1.4, yaw=0.0)).scan(), 0.1, 0), in_base, 0.0)
    bearings = np.arctan2(seen.points_m[:, 1], seen.points_m[:, 0] - LIDAR.x)
    nearest = seen.points_m[np.argmin(np.abs(bearings - bearing_rad))]
    assert nearest == pytest.approx((x_m, y_m), abs=0.03)
