"""Openings between things in one laser scan, wide enough to be doorways (requirement C4). Pure.

An opening begins where neighbouring beams jump in depth: the near end of the jump is an edge (a door jamb, say). Its
other side is whatever stands nearest to that edge beyond the jump: the other jamb, or the next wall.
"""

import math

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from contracts.obstacles import Gap
from robot_bridge.sensing.sensor_readings import Scan

GAPS_MAX = 20
FAR_M = 12.0
"""Where a beam that met nothing is taken to end."""
JUMP_M = 0.4
"""A depth step that makes an edge."""
EDGE_M_MAX = 6.0
"""Beams further apart than this no longer show edges."""
BLIND_RAD = 0.1
"""Neighbouring beams further apart than this have something unknown between them."""


class GapLimits(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    gap_width_m_min: float = Field(default=0.7, gt=0.0, description="what is narrower is no doorway")
    gap_width_m_max: float = Field(default=2.5, gt=0.0, description="what is wider is open space")
    gap_behind_m: float = Field(default=0.3, ge=0.0, description="what is seen through less far is an alcove")


def gaps(scan: Scan, limits: GapLimits) -> tuple[Gap, ...]:
    """Nearest first. Bearings and distances are of the middle of the opening, from base_link."""
    points = _round_view(scan)
    if len(points) < 3:
        return ()
    found: list[Gap] = []
    for gap in sorted(_candidates(points, limits), key=lambda each: each.width_m):
        if not any(_same(gap, other) for other in found):
            found.append(gap)
    return tuple(sorted(found, key=lambda each: each.distance_m)[:GAPS_MAX])


def _round_view(scan: Scan) -> NDArray[np.float64]:
    """(n, 2) where each beam ended, in the order of their bearings."""
    away = FAR_M * np.stack([np.cos(scan.open_rad), np.sin(scan.open_rad)], axis=1)
    points = np.concatenate([scan.points_m, away])
    return points[np.argsort(np.arctan2(points[:, 1], points[:, 0]), kind="stable")]


def _candidates(points: NDArray[np.float64], limits: GapLimits) -> list[Gap]:
    """Each edge, seen from its right (the opening is to the left of it) and, mirrored, from its left."""
    mirrored = points[::-1] * np.array([1.0, -1.0])
    left = [_beyond(points, index, limits) for index in _edges(points)]
    right = [_beyond(mirrored, index, limits) for index in _edges(mirrored)]
    turned = [gap.model_copy(update={"bearing_rad": -gap.bearing_rad}) for gap in right if gap is not None]
    return [gap for gap in left if gap is not None] + turned


def _edges(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Indices of points whose next neighbour (counter-clockwise) is much farther away."""
    depth = np.hypot(points[:, 0], points[:, 1])
    bearing = np.arctan2(points[:, 1], points[:, 0])
    step = np.roll(bearing, -1) - bearing
    seen = np.abs((step + math.pi) % (2.0 * math.pi) - math.pi) <= BLIND_RAD
    return np.flatnonzero((np.roll(depth, -1) - depth > JUMP_M) & seen & (depth <= EDGE_M_MAX))


def _beyond(points: NDArray[np.float64], edge: int, limits: GapLimits) -> Gap | None:
    """The opening to the left of the edge; none where it is too narrow, too wide, or not seen through."""
    turned = np.roll(points, -edge, axis=0)  # the edge first, then counter-clockwise
    bearing = np.arctan2(turned[:, 1], turned[:, 0])
    swept = (bearing - bearing[0]) % (2.0 * math.pi)
    reach = int(np.searchsorted(swept, math.radians(150.0)))
    if reach < 3:
        return None
    steps = np.diff(swept[:reach])
    if (steps > BLIND_RAD).any():
        reach = int(np.argmax(steps > BLIND_RAD)) + 1
        if reach < 3:
            return None
    jamb, others = turned[0], turned[1:reach]
    apart = np.hypot(*(others - jamb).T)
    closest = int(np.argmin(apart))
    width_m = float(apart[closest])
    if not limits.gap_width_m_min <= width_m <= limits.gap_width_m_max or closest == 0:
        return None
    other, between = others[closest], others[:closest]
    beyond_m = _depth_behind(jamb, other, between)
    if (beyond_m < -0.05).any() or float(np.median(beyond_m)) < limits.gap_behind_m:
        return None
    middle = (jamb + other) / 2.0
    return Gap(
        bearing_rad=math.atan2(float(middle[1]), float(middle[0])),
        distance_m=math.hypot(float(middle[0]), float(middle[1])),
        width_m=width_m,
    )


def _depth_behind(
    jamb: NDArray[np.float64], other: NDArray[np.float64], between: NDArray[np.float64]
) -> NDArray[np.float64]:
    """How far beyond the line through the opening each point between its sides lies; negative is before it, m."""
    along = other - jamb
    normal = np.array([along[1], -along[0]]) / np.hypot(*along)
    if normal @ jamb < 0.0:  # away from the robot
        normal = -normal
    return (between - jamb) @ normal


def _same(a: Gap, b: Gap) -> bool:
    ax, ay = a.distance_m * math.cos(a.bearing_rad), a.distance_m * math.sin(a.bearing_rad)
    bx, by = b.distance_m * math.cos(b.bearing_rad), b.distance_m * math.sin(b.bearing_rad)
    return math.hypot(ax - bx, ay - by) < 0.35
