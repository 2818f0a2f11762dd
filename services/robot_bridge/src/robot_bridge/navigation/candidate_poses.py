"""Poses round a wanted one, where the robot would fit and nearest first: what to ask Nav2 for when it cannot. Pure."""

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Point3D, Pose2D
from geometry.grids import OccupancyGrid

STEP_M = 0.2
BEARINGS = 12


@dataclass(frozen=True, slots=True)
class ClearanceMap:
    """The map as distances: `clearance_m` is (height, width), from each cell to the nearest one that is not free."""

    clearance_m: NDArray[np.float32]
    grid: OccupancyGrid

    def at(self, pose: Pose2D) -> float:
        """Metres to the nearest obstacle or unknown cell; 0 outside the map."""
        cell = self.grid.cell(pose.x, pose.y)
        return float(self.clearance_m[cell]) if cell is not None else 0.0


def candidate_poses(
    wanted: Pose2D, room: ClearanceMap, *, radius_m: float, clearance_m_min: float, look_at: Point3D | None = None
) -> list[Pose2D]:
    """Circles of growing radius up to `radius_m`, each pose clear of the map's obstacles; the nearest first, and on
    one circle the roomiest first. They face `look_at`, or as the wanted pose does."""
    circles = max(1, round(radius_m / STEP_M)) if radius_m > 0.0 else 0
    found: list[tuple[float, float, Pose2D]] = []
    for circle in range(1, circles + 1):
        distance_m = radius_m * circle / circles
        for k in range(BEARINGS):
            bearing = 2.0 * math.pi * k / BEARINGS
            x, y = wanted.x + distance_m * math.cos(bearing), wanted.y + distance_m * math.sin(bearing)
            yaw = math.atan2(look_at.y - y, look_at.x - x) if look_at is not None else wanted.yaw
            pose = Pose2D(x=x, y=y, yaw=yaw)
            clearance_m = room.at(pose)
            if clearance_m >= clearance_m_min:
                found.append((distance_m, -clearance_m, pose))
    return [pose for _, _, pose in sorted(found, key=lambda each: each[:2])]


def by_clearance(poses: list[Pose2D], room: ClearanceMap) -> list[Pose2D]:
    return sorted(poses, key=lambda pose: -room.at(pose))


def length_m(poses: tuple[Pose2D, ...]) -> float:
    return sum(math.hypot(b.x - a.x, b.y - a.y) for a, b in itertools.pairwise(poses))
