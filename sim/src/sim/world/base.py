"""The Create 3 base: what it makes of a velocity command, on its own clock and without physics."""

import math
from dataclasses import dataclass
from typing import Final

from contracts.geometry import Twist2D
from sim.world.robot import WHEEL_BASE_M, WHEEL_RADIUS_M

SPEED_MAX_M_S: Final = 0.306
TURN_MAX_RAD_S: Final = 1.9
ACCELERATION_M_S2: Final = 0.9
"""Of each wheel's rim."""
BACKUP_LIMIT_M: Final = 0.15
"""How far it reverses before it has to have driven forward again: there are no cliff sensors at its back."""


@dataclass(frozen=True, slots=True)
class WheelSpeeds:
    """Rim speeds, m/s."""

    left_m_s: float = 0.0
    right_m_s: float = 0.0

    @property
    def rad_s(self) -> tuple[float, float]:
        """What the wheel motors are asked for, left and right."""
        return self.left_m_s / WHEEL_RADIUS_M, self.right_m_s / WHEEL_RADIUS_M


class Base:
    """Limits, times out, ramps; `wheels` is what the motors follow."""

    def __init__(self, timeout_s: float) -> None:
        """`timeout_s`: without a newer command for so long the base stops by itself (`wheels_stop_threshold_sec`)."""
        self._timeout_s = timeout_s
        self.wheels = WheelSpeeds()
        self.e_stop_on = False
        self.backup_limited = False
        self._wanted = Twist2D()
        self._wanted_at_s = -math.inf
        self._may_reverse = False
        self._reversed_m = 0.0

    def command(self, linear_x: float, angular_z: float, now_s: float, *, behaviour: bool = False) -> bool:
        """Take a velocity (m/s, rad/s), clipped to the base's limits; False when it is refused.

        Refused are numbers that are not finite and everything while the e-stop is on. `behaviour` marks the base's own
        motions (undocking), which the backup limit does not bind.
        """
        if self.e_stop_on or not (math.isfinite(linear_x) and math.isfinite(angular_z)):
            return False
        self._wanted = Twist2D(
            linear_x=_clip(linear_x, SPEED_MAX_M_S),
            angular_z=_clip(angular_z, TURN_MAX_RAD_S),
        )
        self._wanted_at_s = now_s
        self._may_reverse = behaviour
        return True

    def at_rest(self) -> "Base":
        """A base that stands still and was told nothing; the e-stop stays as it is."""
        base = Base(self._timeout_s)
        base.e_stop_on = self.e_stop_on
        return base

    def set_e_stop(self, on: bool) -> None:
        """On: stop and take no command. Off: commands are taken again, none is resumed."""
        self.e_stop_on = on
        self._wanted_at_s = -math.inf

    def tick(self, now_s: float, forward_m: float, dt_s: float) -> WheelSpeeds:
        """One step of `dt_s`, of which the robot moved `forward_m`: the rim speeds to ask for next."""
        self._reversed_m = max(0.0, self._reversed_m - forward_m)
        wanted = self._wanted if now_s - self._wanted_at_s <= self._timeout_s and not self.e_stop_on else Twist2D()
        if self._may_reverse:
            self._reversed_m = 0.0
        self.backup_limited = wanted.linear_x < 0.0 and self._reversed_m >= BACKUP_LIMIT_M
        linear_x = 0.0 if self.backup_limited else wanted.linear_x
        turn_m_s = wanted.angular_z * WHEEL_BASE_M / 2
        self.wheels = _toward(self.wheels, linear_x - turn_m_s, linear_x + turn_m_s, ACCELERATION_M_S2 * dt_s)
        return self.wheels


def _clip(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))


def _toward(now: WheelSpeeds, left_m_s: float, right_m_s: float, step_m_s: float) -> WheelSpeeds:
    """Both wheels ramp in the same proportion, so that an arc keeps its shape."""
    left, right = left_m_s - now.left_m_s, right_m_s - now.right_m_s
    share = min(1.0, step_m_s / max(abs(left), abs(right), 1e-9))
    return WheelSpeeds(now.left_m_s + left * share, now.right_m_s + right * share)
