"""Bearings, and poses round a point."""

import math
from dataclasses import dataclass

from contracts.geometry import Pose2D
from geometry.poses import apart_m, wrap


def near_any(pose: Pose2D, others: tuple[Pose2D, ...], within_m: float) -> bool:
    return any(apart_m(pose, other) <= within_m for other in others)


def pixel_bearing_rad(u_px: float, width_px: int, hfov_rad: float) -> float:
    """Of an image column from the camera's axis, counter-clockwise positive (left of the middle is positive)."""
    focal_px = width_px / 2 / math.tan(hfov_rad / 2)
    return math.atan2(width_px / 2 - u_px, focal_px)


@dataclass(frozen=True, slots=True)
class Relative:
    """A point as seen from base_link: `distance_m` from the base's centre, `bearing_rad` from its x axis."""

    distance_m: float
    bearing_rad: float


def relative(point_x: float, point_y: float, base: Pose2D) -> Relative:
    dx, dy = point_x - base.x, point_y - base.y
    return Relative(math.hypot(dx, dy), wrap(math.atan2(dy, dx) - base.yaw))
