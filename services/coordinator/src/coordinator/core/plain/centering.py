"""CENTERING by the plain rule (requirement A8): a turn by short leases, in proportion to the error in the picture."""

import math

from contracts.geometry import Twist2D
from coordinator.core import actions as do
from coordinator.core.mission import Sighting
from coordinator.core.rules import Rules
from coordinator.core.states.centering import await_newer_frame
from coordinator.core.step_context import StepContext


def centering_speed_rad_s(error_px: float, rules: Rules) -> float:
    """omega = -gain * error, clipped, and never so small that the wheels stand still (A8).

    `error_px` is right-positive in a 320 px wide frame.
    """
    size = min(max(abs(error_px) * rules.centering_gain_rad_s_px, rules.centering_speed_min_rad_s),
               rules.centering_speed_max_rad_s)  # fmt: skip
    return -math.copysign(size, error_px)


def proportional_turn(context: StepContext, sighting: Sighting) -> None:
    omega = centering_speed_rad_s(sighting.error_px, context.rules)
    context.request(do.SetVelocity(Twist2D(angular_z=omega), context.rules.lease_s))
    await_newer_frame(context, after_s=sighting.stamp_s)
