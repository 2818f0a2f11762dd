"""A laser scan: what it hit, and what it does not know."""

import math
from typing import Any

import numpy as np
from sensor_msgs.msg import LaserScan

from robot_bridge.adapters.ros.convert.poses import stamp_s
from robot_bridge.senses import Scan
from robot_bridge.transforms import Matrix

BEAMS_MAX = 20_000
BLIND_COSINE = 0.5


def scan(message: LaserScan, laser_in_base: Matrix) -> Scan:
    """Hits as points in base_link; a beam that says neither a range nor 'nothing' (inf) is unknown."""
    ranges = np.asarray(message.ranges, dtype=np.float64)
    if ranges.size == 0 or ranges.size > BEAMS_MAX:
        raise ValueError("no scan has so many beams")
    if not (math.isfinite(message.angle_min) and math.isfinite(message.angle_increment)):
        raise ValueError("the scan's angles are no numbers")
    near, far = message.range_min, message.range_max
    hit = np.isfinite(ranges) & (ranges >= near) & (ranges <= far)
    nothing = (ranges == np.inf) | (np.isfinite(ranges) & (ranges > far))
    angles = message.angle_min + message.angle_increment * np.flatnonzero(hit)
    r = ranges[hit]
    local = np.stack([r * np.cos(angles), r * np.sin(angles), np.zeros_like(r), np.ones_like(r)])
    points = (laser_in_base @ local)[:2].T
    ahead, behind = _known(hit | nothing, message, laser_in_base)
    heading = math.atan2(float(laser_in_base[1, 0]), float(laser_in_base[0, 0]))
    away = message.angle_min + message.angle_increment * np.flatnonzero(nothing) + heading
    open_rad = np.asarray((away + math.pi) % (2.0 * math.pi) - math.pi, dtype=np.float64)
    return Scan(stamp_s(message.header.stamp), np.ascontiguousarray(points), ahead, behind, open_rad)


def _known(said: "np.ndarray[Any, Any]", message: LaserScan, laser_in_base: Matrix) -> tuple[float, float]:
    """Of the beams within 60 degrees of base_link's x axis, and of its opposite: the part that said anything."""
    bearings = message.angle_min + message.angle_increment * np.arange(said.size)
    forward = np.stack([np.cos(bearings), np.sin(bearings)], axis=1) @ laser_in_base[0, :2]
    parts = [said[there] for there in (forward >= BLIND_COSINE, forward <= -BLIND_COSINE)]
    return tuple(float(part.mean()) if part.size else 0.0 for part in parts)  # type: ignore[return-value]
