"""How the simulated base docks and undocks by itself, as a Create 3 does: no map, only where the dock is seen to be."""

import math
from enum import StrEnum
from typing import Final

from contracts.geometry import Pose2D, Twist2D
from geometry.poses import wrap

_STAGING_M: Final = 0.5
_SPEED_M_S: Final = 0.12
_DOCKED_WITHIN_M: Final = 0.02


class _Phase(StrEnum):
    APPROACH = "approach"
    """To a place half a metre in front of the dock."""
    FACE = "face"
    ENTER = "enter"


class Docking:
    """`step` with base_link in the frame of the docked robot (x forward, at the dock 0, 0, 0) until it says none."""

    def __init__(self) -> None:
        self._phase = _Phase.APPROACH

    def step(self, seen: Pose2D) -> Twist2D | None:
        """`seen` is where base_link is, relative to where it is when docked; none = it is in."""
        if seen.x > -_DOCKED_WITHIN_M and abs(seen.y) < 0.05 and abs(seen.yaw) < 0.2:
            return None
        if self._phase is _Phase.APPROACH:
            staging_x, staging_y = -_STAGING_M - seen.x, -seen.y
            off_axis = abs(seen.y) > 0.03 or abs(seen.x) > 2 * _STAGING_M
            if off_axis and math.hypot(staging_x, staging_y) > 0.04:
                return _toward(math.atan2(staging_y, staging_x) - seen.yaw)
            self._phase = _Phase.FACE
        if self._phase is _Phase.FACE:
            if abs(seen.yaw) > 0.04:
                return Twist2D(angular_z=math.copysign(min(max(1.5 * abs(seen.yaw), 0.15), 0.8), -seen.yaw))
            self._phase = _Phase.ENTER
        return Twist2D(linear_x=_SPEED_M_S, angular_z=max(-0.6, min(0.6, -2.0 * seen.yaw - 3.0 * seen.y)))


class Undocking:
    """Backs off the dock and turns round, as a Create 3 does."""

    def __init__(self, *, back_m: float = 0.45) -> None:
        self._back_m = back_m
        self._backing = True

    def step(self, seen: Pose2D) -> Twist2D | None:
        """As for `Docking`; none = undocked and turned round."""
        self._backing = self._backing and seen.x > -self._back_m
        if self._backing:
            return Twist2D(linear_x=-_SPEED_M_S)
        left = wrap(math.pi - seen.yaw)
        if abs(left) < 0.08:
            return None
        return Twist2D(angular_z=math.copysign(min(max(1.5 * abs(left), 0.2), 1.0), left))


def _toward(bearing: float) -> Twist2D:
    error = wrap(bearing)
    if abs(error) > 0.3:
        return Twist2D(angular_z=math.copysign(0.8, error))
    return Twist2D(linear_x=_SPEED_M_S, angular_z=1.5 * error)
