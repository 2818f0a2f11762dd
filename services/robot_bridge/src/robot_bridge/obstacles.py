"""Named sectors round the footprint, from one pass over the laser scan. Pure."""

import math

import numpy as np

from contracts.obstacles import Obstacles
from robot_bridge.safety import SafetyLimits
from robot_bridge.senses import Scan

SECTORS_DEG: dict[str, tuple[float, float]] = {
    "front": (-15.0, 15.0),
    "front_wide": (-45.0, 45.0),
    "front_left": (15.0, 60.0),
    "front_right": (-60.0, -15.0),
    "left": (60.0, 120.0),
    "right": (-120.0, -60.0),
    "back": (150.0, 210.0),
}
"""Bearings from base_link's x axis, counter-clockwise; a sector may pass 180 degrees."""


def obstacles(scan: Scan, limits: SafetyLimits, stamp_s: float) -> Obstacles:
    """The nearest point of each sector, in metres from the footprint."""
    bearing_deg = np.degrees(np.arctan2(scan.points_m[:, 1], scan.points_m[:, 0]))
    clearance_m = np.maximum(0.0, np.hypot(scan.points_m[:, 0], scan.points_m[:, 1]) - limits.footprint_radius_m)
    sectors: dict[str, float | None] = {}
    for name, (low, high) in SECTORS_DEG.items():
        inside = (bearing_deg - low) % 360.0 <= high - low
        sectors[name] = float(clearance_m[inside].min()) if inside.any() else None
    front_m = sectors["front"]
    return Obstacles(
        stamp_s=stamp_s,
        sectors_m=sectors,
        emergency=(front_m if front_m is not None else math.inf) < limits.stop_distance_m,
    )
