"""Stamps, poses and transforms."""

import math
from typing import Any

from geometry_msgs.msg import Pose, PoseStamped, PoseWithCovarianceStamped, Transform

from contracts.geometry import Pose2D
from geometry.poses import quaternion_xyzw
from robot_bridge.sensing.transforms import Matrix, matrix, planar

NORM_TOLERANCE = 0.01
"""Of a quaternion's length, as tf2 has it."""
FAR_M = 10_000.0
LEVEL_COSINE = math.cos(math.radians(45.0))


def stamp_s(stamp: Any) -> float:
    """builtin_interfaces/Time in seconds; 0 where it is none."""
    return float(stamp.sec) + float(stamp.nanosec) * 1e-9 if stamp.nanosec < 1_000_000_000 else 0.0


def pose(message: Pose) -> Pose2D:
    """On the floor. Raises `ValueError` for what is no pose, and for a robot on its side."""
    p, q = message.position, message.orientation
    placed = _matrix((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))
    if placed[2, 2] < LEVEL_COSINE:
        raise ValueError("its orientation lays the robot on its side")
    return planar(placed)


def localisation(message: PoseWithCovarianceStamped, map_frame: str) -> Pose2D:
    """base_link in map."""
    frame = message.header.frame_id
    if frame.lstrip("/") != map_frame:
        raise ValueError(f"it is in the frame {frame or '(unnamed)'}, not in {map_frame}")
    if not all(map(math.isfinite, message.pose.covariance)):
        raise ValueError("its covariance is no number: the localiser has lost itself")
    return pose(message.pose.pose)


def transform(message: Transform) -> Matrix:
    t, q = message.translation, message.rotation
    return _matrix((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))


def _matrix(position_m: tuple[float, float, float], xyzw: tuple[float, float, float, float]) -> Matrix:
    if not all(map(math.isfinite, position_m)) or max(map(abs, position_m)) > FAR_M:
        raise ValueError(f"its position is ({', '.join(f'{value:g}' for value in position_m)}) m")
    norm = math.hypot(*xyzw)
    if not abs(norm - 1.0) <= NORM_TOLERANCE:
        raise ValueError(f"its quaternion is {norm:g} long, not 1")
    return matrix(position_m, xyzw)


def pose_stamped(value: Pose2D, frame_id: str) -> PoseStamped:
    """Unstamped: 'the newest transform', whatever the clocks say."""
    message = PoseStamped()
    message.header.frame_id = frame_id
    _fill(message.pose, value)
    return message


DOCKED_SIGMA_M, DOCKED_SIGMA_RAD = 0.1, 0.1
"""How well a remembered dock says where the robot stands."""


def initial_pose(value: Pose2D, frame_id: str, stamp: Any) -> PoseWithCovarianceStamped:
    message = PoseWithCovarianceStamped()
    message.header.frame_id, message.header.stamp = frame_id, stamp
    _fill(message.pose.pose, value)
    covariance = message.pose.covariance
    covariance[0] = covariance[7] = DOCKED_SIGMA_M**2
    covariance[35] = DOCKED_SIGMA_RAD**2
    return message


def _fill(message: Pose, value: Pose2D) -> None:
    message.position.x, message.position.y = value.x, value.y
    q = message.orientation
    q.x, q.y, q.z, q.w = quaternion_xyzw(value.yaw)
