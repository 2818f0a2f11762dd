"""Which headings a look round stops at. Pure."""

import math

from coordinator.core.rules import Rules


def headings_round(rules: Rules, start_rad: float, angle_rad: float) -> tuple[float, ...]:
    """Of looks that overlap in the picture, from `start_rad` counter-clockwise over `angle_rad`, both ends included."""
    widest = rules.camera_hfov_rad * (1.0 - rules.scan_overlap_min)
    count = math.ceil(angle_rad / min(rules.scan_step_rad, widest) - 1e-6)
    return tuple(start_rad + k * angle_rad / count for k in range(count + 1))
