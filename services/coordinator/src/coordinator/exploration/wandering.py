"""The careful wander: where the laser alone would go on, away from where it has been."""

import math
from typing import Final

from contracts.exploration import MapPoint
from contracts.geometry import Pose2D
from coordinator.exploration.decision_check import (
    WAY_HALF_RAD,
    Advance,
    BlockedTry,
    CheckLimits,
    speed_for,
    tried_too_often,
)
from coordinator.exploration.surroundings import Surroundings, way_rad
from geometry.poses import wrap

STEP_M: Final = 1.5
SEEN_FAR_M: Final = 3.0
BEEN_M: Final = 0.8
"""Places of its trail this near to where a step would end speak against it."""
TURN_PRICE_M: Final = 0.25
"""What a turn of a whole half costs, in metres of clear way."""
BEEN_PRICE_M: Final = 0.35


def step_from(
    pose: Pose2D,
    scan: Surroundings,
    trail: tuple[MapPoint, ...],
    tries: tuple[BlockedTry, ...],
    now_s: float,
    limits: CheckLimits,
) -> Advance | None:
    """The way that leads farthest into where the robot has not been. None where every way is blocked."""
    best: tuple[float, Advance] | None = None
    for index, clear_m in enumerate(scan.ways_m(limits.half_width_m)):
        bearing = way_rad(index)
        heading = wrap(pose.yaw + bearing)
        if scan.says_nothing_about(bearing, WAY_HALF_RAD):  # as the check of the drive will find
            continue
        if clear_m < limits.reject_m or tried_too_often(tries, heading, now_s, limits):
            continue
        step_m = min(STEP_M, clear_m - limits.keep_m)
        x, y = pose.x + step_m * math.cos(heading), pose.y + step_m * math.sin(heading)
        been = sum(math.hypot(one.x_m - x, one.y_m - y) < BEEN_M for one in trail)
        worth = min(clear_m, SEEN_FAR_M) - TURN_PRICE_M * abs(bearing) / math.pi - BEEN_PRICE_M * been
        if best is None or worth > best[0]:
            best = worth, Advance(bearing, step_m, speed_for(clear_m, step_m, limits))
    return best[1] if best is not None else None
