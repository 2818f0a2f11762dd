"""The newest scan as one who explores reads it: how far a way is clear, which ways are open, what place this is."""

import math
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from geometry.poses import wrap

WAYS: Final = 24
"""Directions that are looked at round the robot: one each 15 degrees."""
OPEN_M: Final = 1.5
"""A way that is clear so far is open."""
NARROW_M: Final = 0.75
"""Walls this near on both sides, with a way ahead and a way back, are a doorway's."""
DEAD_END_M: Final = 1.0


class PlaceKind(StrEnum):
    """What the shape of the scan says of where the robot stands."""

    ROOM = "room"
    DOORWAY = "doorway"
    JUNCTION = "junction"
    """Three ways or more lead on."""
    DEAD_END = "dead_end"
    """Only the way back is open."""


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """`points_m` is (n, 2) in base_link: the beams that hit something."""

    stamp_s: float
    points_m: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2)))
    silent_rad: tuple[tuple[float, float], ...] = ()
    """Bearings (from, to; counter-clockwise) about which no beam says anything."""

    def clear_m(self, bearing_rad: float, half_width_m: float) -> float:
        """How far a disc of that radius round base_link goes that way until it touches something; inf = nothing in
        reach. The path has the width of the footprint, and its front is round."""
        c, s = math.cos(bearing_rad), math.sin(bearing_rad)
        ahead = c * self.points_m[:, 0] + s * self.points_m[:, 1]
        aside = c * self.points_m[:, 1] - s * self.points_m[:, 0]
        touched = (np.abs(aside) < half_width_m) & (ahead > 0.0)
        if not touched.any():
            return math.inf
        reach = ahead[touched] - np.sqrt(half_width_m**2 - aside[touched] ** 2)
        return max(0.0, float(reach.min()))

    def nearest_m(self, x_m: float = 0.0, y_m: float = 0.0) -> float:
        """From a point of base_link to the nearest that the laser met; inf = nothing in reach."""
        if not len(self.points_m):
            return math.inf
        return float(np.hypot(self.points_m[:, 0] - x_m, self.points_m[:, 1] - y_m).min())

    def says_nothing_about(self, bearing_rad: float, half_rad: float = 0.0) -> bool:
        """True where any of the bearings within `half_rad` of it is silent."""
        return any(
            (bearing_rad + half_rad - low) % (2 * math.pi) <= (high - low) % (2 * math.pi) + 2 * half_rad
            for low, high in self.silent_rad
        )

    def ways_m(self, half_width_m: float) -> tuple[float, ...]:
        """How far each of the `WAYS` is clear, the first straight ahead, the next ones to its left."""
        return tuple(
            0.0 if self.says_nothing_about(bearing) else self.clear_m(bearing, half_width_m)
            for bearing in map(way_rad, range(WAYS))
        )

    def place_kind(self, half_width_m: float) -> PlaceKind:
        ways_m = self.ways_m(half_width_m)
        beside = WAYS // 4
        left_m, right_m = ways_m[beside], ways_m[-beside]
        ahead_m, back_m = _most(ways_m, 0), _most(ways_m, WAYS // 2)
        if max(left_m, right_m) < NARROW_M and min(ahead_m, back_m) >= OPEN_M:
            return PlaceKind.DOORWAY
        if max(_most(ways_m, k) for k in range(-beside, beside + 1)) < DEAD_END_M:
            return PlaceKind.DEAD_END
        if _openings(ways_m) >= 3:
            return PlaceKind.JUNCTION
        return PlaceKind.ROOM


def way_rad(index: int) -> float:
    """The bearing of one of the `WAYS`."""
    return wrap(index * 2 * math.pi / WAYS)


def _most(ways_m: tuple[float, ...], index: int) -> float:
    """Of a way and the two beside it."""
    return max(ways_m[(index + k) % WAYS] for k in (-1, 0, 1))


def _openings(ways_m: tuple[float, ...]) -> int:
    """Groups of neighbouring open ways, counted round."""
    opened = [one >= OPEN_M for one in ways_m]
    return sum(now and not opened[k - 1] for k, now in enumerate(opened))
