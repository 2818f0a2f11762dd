"""Planar poses: m and rad, yaw counter-clockwise (REP-103)."""

import math

from contracts.geometry import Pose2D


def wrap(angle_rad: float) -> float:
    """The same angle in (-pi, pi]."""
    return -((math.pi - angle_rad) % (2.0 * math.pi) - math.pi)


def compose(a: Pose2D, b: Pose2D) -> Pose2D:
    """`b`, given in the frame that `a` places, in the frame `a` is given in."""
    c, s = math.cos(a.yaw), math.sin(a.yaw)
    return Pose2D(x=a.x + c * b.x - s * b.y, y=a.y + s * b.x + c * b.y, yaw=wrap(a.yaw + b.yaw))


def inverse(pose: Pose2D) -> Pose2D:
    """What undoes `pose`: composed with it, either way round, nothing is left."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    return Pose2D(x=-c * pose.x - s * pose.y, y=s * pose.x - c * pose.y, yaw=wrap(-pose.yaw))


def apart_m(a: Pose2D, b: Pose2D) -> float:
    """From one to the other, as the crow flies."""
    return math.hypot(b.x - a.x, b.y - a.y)


def quaternion_xyzw(yaw: float) -> tuple[float, float, float, float]:
    """A heading as ROS wants it."""
    return 0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0)


def yaw_of(x: float, y: float, z: float, w: float) -> float:
    """The heading of a quaternion, in (-pi, pi]."""
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
