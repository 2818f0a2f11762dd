"""How a robot that stands too near something gets room again: one turn on the spot, one short straight drive. Pure."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Twist2D
from robot_bridge.safety.collision_monitor import SafetyLimits, free_travel_m

ROOM_M: Final = 0.25
"""How far it drives at most: Nav2's own BackUp takes 0.30 m."""
LEAST_M: Final = 0.08
"""Less gives no room worth a drive."""
HEADINGS: Final = 24
BACK: Final = Twist2D(linear_x=-0.1)
AHEAD: Final = Twist2D(linear_x=0.1)


@dataclass(frozen=True, slots=True)
class RecoveryMotion:
    """Turn by `turn_rad`, then drive `distance_m`; below 0 backwards, and then without a turn."""

    turn_rad: float
    distance_m: float


def is_crowded(points_m: NDArray[np.float64], limits: SafetyLimits) -> bool:
    """Something of `points_m` (n, 2, base_link) is so near that the safety filter may hold a robot that faces it."""
    near_m = limits.footprint_radius_m + limits.side_margin_m + limits.stop_distance_m
    return bool((np.hypot(points_m[:, 0], points_m[:, 1]) < near_m).any())


def recovery_motion(
    points_m: NDArray[np.float64],
    unseen_m: NDArray[np.float64],
    limits: SafetyLimits,
    *,
    may_reverse: bool,
    bumped: bool,
) -> RecoveryMotion | None:
    """The shortest way to more room: `points_m` (n, 2) is what the laser sees, `unseen_m` (n, 2) where something could
    stand that it does not see, both in base_link. None where there is no way.

    Straight back, as far as that goes: it came from there. Else the heading with most room, the nearest of equals. Who
    has `bumped` into what no laser sees goes back or stays.
    """
    back_m = room_m(np.concatenate([points_m, unseen_m]), BACK, limits) if may_reverse else 0.0
    if back_m >= ROOM_M or (bumped and back_m >= LEAST_M):
        return RecoveryMotion(0.0, -back_m)
    if bumped:
        return None
    headings = sorted((math.remainder(k * math.tau / HEADINGS, math.tau) for k in range(HEADINGS)), key=abs)
    best = max(headings, key=lambda heading: room_m(_turned(points_m, heading), AHEAD, limits))
    ahead_m = room_m(_turned(points_m, best), AHEAD, limits)
    if max(ahead_m, back_m) < LEAST_M:
        return None
    return RecoveryMotion(best, ahead_m) if ahead_m > back_m else RecoveryMotion(0.0, -back_m)


def room_m(points_m: NDArray[np.float64], twist: Twist2D, limits: SafetyLimits) -> float:
    """How far the safety filter would let it go, at most `ROOM_M`."""
    free_m = free_travel_m(points_m, twist, limits.footprint_radius_m + limits.side_margin_m)
    return min(ROOM_M, max(0.0, free_m - limits.stop_distance_m))


def _turned(points_m: NDArray[np.float64], heading_rad: float) -> NDArray[np.float64]:
    """(n, 2) as seen by the robot once it has turned by `heading_rad`."""
    cosine, sine = math.cos(heading_rad), math.sin(heading_rad)
    return points_m @ np.array([[cosine, -sine], [sine, cosine]])
