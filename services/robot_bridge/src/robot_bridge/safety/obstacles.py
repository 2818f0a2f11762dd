"""What stands round the footprint: named sectors, a ring of twelve, and how well one could drive where (C4). Pure."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from contracts.obstacles import Affordances, Obstacles, RingSector, SectorLabel
from robot_bridge.safety.collision_monitor import SafetyLimits
from robot_bridge.safety.gaps import GapLimits, gaps
from robot_bridge.sensing.sensor_readings import Scan

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

DIRECTIONS_DEG = {
    "forward": 0.0,
    "forward_left": 45.0,
    "left": 90.0,
    "backward": 180.0,
    "right": -90.0,
    "forward_right": -45.0,
}
"""The six ways to go; each looks 22.5 degrees to both sides."""

RING_SECTORS = 12
RING_PERCENTILE = 10.0
BLOCKED_M, FREE_M = 0.2, 2.0
"""From the footprint: up to the first an affordance is 0.1, from the second on 1.0."""


class ObstacleLimits(SafetyLimits, GapLimits):
    """What a distance from the footprint means."""

    sector_wall_m: float = Field(default=0.25, gt=0.0, description="a ring sector nearer than this is a WALL")
    sector_obstacle_m: float = Field(default=0.5, gt=0.0, description="nearer than this: OBSTACLE")
    sector_near_m: float = Field(default=1.0, gt=0.0, description="nearer than this: NEAR, else CLEAR")


@dataclass(frozen=True, slots=True)
class Beams:
    """Every beam that said something: its bearing (deg, from base_link) and its distance from the footprint, m.

    A beam that met nothing in reach has the distance inf.
    """

    bearing_deg: NDArray[np.float64]
    clearance_m: NDArray[np.float64]

    def within(self, low_deg: float, high_deg: float) -> NDArray[np.float64]:
        """Distances between two bearings, counter-clockwise from the first to the second."""
        return self.clearance_m[(self.bearing_deg - low_deg) % 360.0 <= high_deg - low_deg]


def obstacles(scan: Scan, limits: ObstacleLimits) -> Obstacles:
    """All of requirement C4 from one scan; distances are from the footprint."""
    beams = beams_of(scan, limits.footprint_radius_m)
    sectors = {name: _finite(_nearest(beams.within(*span))) for name, span in SECTORS_DEG.items()}
    front_m = sectors["front"]
    return Obstacles(
        stamp_s=scan.stamp_s,
        sectors_m=sectors,
        ring=tuple(_ring_sector(beams, index, limits) for index in range(RING_SECTORS)),
        gaps=gaps(scan, limits),
        affordances=Affordances(**{name: _affordance(beams, deg) for name, deg in DIRECTIONS_DEG.items()}),
        emergency=front_m is not None and front_m < limits.stop_distance_m,
    )


def beams_of(scan: Scan, footprint_radius_m: float) -> Beams:
    hit_deg = np.degrees(np.arctan2(scan.points_m[:, 1], scan.points_m[:, 0]))
    hit_m = np.maximum(0.0, np.hypot(scan.points_m[:, 0], scan.points_m[:, 1]) - footprint_radius_m)
    return Beams(
        np.concatenate([hit_deg, np.degrees(scan.open_rad)]),
        np.concatenate([hit_m, np.full(scan.open_rad.shape, np.inf)]),
    )


def label(distance_m: float, limits: ObstacleLimits) -> SectorLabel:
    for below_m, name in (
        (limits.sector_wall_m, SectorLabel.WALL),
        (limits.sector_obstacle_m, SectorLabel.OBSTACLE),
        (limits.sector_near_m, SectorLabel.NEAR),
    ):
        if distance_m < below_m:
            return name
    return SectorLabel.CLEAR


def _ring_sector(beams: Beams, index: int, limits: ObstacleLimits) -> RingSector:
    width_deg = 360.0 / RING_SECTORS
    middle_deg = (index * width_deg + 180.0) % 360.0 - 180.0
    bearing_rad = math.radians(middle_deg)
    low_deg = middle_deg - width_deg / 2.0
    inside = (beams.bearing_deg - low_deg) % 360.0 < width_deg  # half-open: a beam belongs to one sector
    found = beams.clearance_m[inside]
    if not found.size:
        return RingSector(bearing_rad=bearing_rad)
    distance_m = float(np.percentile(found, RING_PERCENTILE, method="inverted_cdf"))
    return RingSector(bearing_rad=bearing_rad, distance_m=_finite(distance_m), label=label(distance_m, limits))


def _affordance(beams: Beams, middle_deg: float) -> float:
    """0.1 to 1.0, linear between blocked and free; what no beam speaks of is as good as blocked."""
    inside = beams.within(middle_deg - 22.5, middle_deg + 22.5)
    if not inside.size:
        return 0.1
    part = (_nearest(inside) - BLOCKED_M) / (FREE_M - BLOCKED_M)
    return round(0.1 + 0.9 * min(1.0, max(0.0, part)), 3)


def _nearest(clearance_m: NDArray[np.float64]) -> float:
    return float(clearance_m.min()) if clearance_m.size else math.inf


def _finite(distance_m: float) -> float | None:
    return distance_m if math.isfinite(distance_m) else None
