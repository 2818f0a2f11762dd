"""Postures in a row made a trajectory: straight in joint space, smooth in time; pure."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from contracts.arm import POINTS_MAX
from grasping.planning import Joints

PEAK: Final = 1.875
"""The greatest speed of a minimum-jerk motion from rest to rest, by its mean (Flash and Hogan 1985)."""
STEP_S: Final = 0.1
SHORTEST_S: Final = 0.3


def timed(path: tuple[Joints, ...], speed_rad_s: float) -> tuple[tuple[float, Joints], ...]:
    """(s since the start, joints) along the path from its first posture, where the arm is, to its last: no joint is
    faster than `speed_rad_s`, speed and acceleration are 0 at both ends. Raises ValueError for less than two postures,
    and for a speed that is not above 0."""
    if len(path) < 2 or not speed_rad_s > 0.0:
        raise ValueError(f"a way has two postures and a speed above 0, not {len(path)} and {speed_rad_s} rad/s")
    points = np.array(path, np.float64)
    far = np.abs(np.diff(points, axis=0)).max(axis=1)
    along = np.concatenate(([0.0], np.cumsum(far)))
    duration_s = max(SHORTEST_S, PEAK * float(along[-1]) / speed_rad_s)
    count = min(POINTS_MAX, max(2, round(duration_s / STEP_S)))
    share = np.arange(1, count + 1) / count
    smooth = along[-1] * share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    columns: list[NDArray[np.float64]] = [np.interp(smooth, along, points[:, k]) for k in range(points.shape[1])]
    joints: NDArray[np.float64] = np.stack(columns, axis=1)
    times_s = share * duration_s
    return tuple((float(times_s[k]), tuple(float(angle) for angle in joints[k])) for k in range(count))
