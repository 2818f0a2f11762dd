"""Where a thing that stands still is in map, from many measurements of it: a Kalman filter of two numbers.

A measurement is long in the direction it was seen and narrow across it, so its covariance is turned into map before
it is fused (Bar-Shalom, Estimation with Applications to Tracking and Navigation, 1.6 and 5.4).
"""

import math
from dataclasses import dataclass, replace

GATE = 9.21
"""Squared Mahalanobis distance that 99 % of the measurements of one thing stay within (chi-squared, two numbers)."""
BEARING_SIGMA_RAD = 0.03
POSE_SIGMA_M = 0.05
"""Of the robot's place in map. It is the same error in picture after picture, so no place gets better than this."""
OUTLIERS_MAX = 3


@dataclass(frozen=True, slots=True)
class Track:
    """`xx`, `xy`, `yy` are the covariance in m^2; `outliers` counts the measurements in a row that lay elsewhere."""

    x: float
    y: float
    xx: float
    xy: float
    yy: float
    hits: int = 1
    outliers: int = 0

    @property
    def place(self) -> tuple[float, float]:
        return self.x, self.y

    @property
    def sigma_m(self) -> float:
        """In the direction in which least is known, never below the robot's own."""
        middle, half = (self.xx + self.yy) / 2, math.hypot((self.xx - self.yy) / 2, self.xy)
        return math.sqrt(middle + half + POSE_SIGMA_M**2)


def measured(x: float, y: float, *, bearing_rad: float, distance_m: float, sigma_m: float) -> Track:
    """One measurement alone. `bearing_rad` in map, from the robot; `sigma_m` of the distance."""
    along, across = max(sigma_m, 0.01) ** 2, max(distance_m * BEARING_SIGMA_RAD, 0.01) ** 2
    cos, sin = math.cos(bearing_rad), math.sin(bearing_rad)
    return Track(
        x,
        y,
        xx=along * cos * cos + across * sin * sin,
        xy=(along - across) * cos * sin,
        yy=along * sin * sin + across * cos * cos,
    )


def squared_mahalanobis(one: Track, other: Track) -> float:
    """How far apart two places are, in the uncertainty of both and of the robot's own place."""
    xx, xy, yy = _inverse(*_innovation(one, other))
    dx, dy = other.x - one.x, other.y - one.y
    return dx * dx * xx + 2.0 * dx * dy * xy + dy * dy * yy


def fused(track: Track, new: Track) -> Track:
    """The track with one more measurement. One outside the gate moves nothing; of several in a row the last is
    believed instead.
    """
    if squared_mahalanobis(track, new) > GATE:
        return new if track.outliers + 1 >= OUTLIERS_MAX else replace(track, outliers=track.outliers + 1)
    ixx, ixy, iyy = _inverse(track.xx + new.xx, track.xy + new.xy, track.yy + new.yy)
    kxx, kxy = track.xx * ixx + track.xy * ixy, track.xx * ixy + track.xy * iyy
    kyx, kyy = track.xy * ixx + track.yy * ixy, track.xy * ixy + track.yy * iyy
    dx, dy = new.x - track.x, new.y - track.y
    return Track(
        x=track.x + kxx * dx + kxy * dy,
        y=track.y + kyx * dx + kyy * dy,
        xx=track.xx - kxx * track.xx - kxy * track.xy,
        xy=track.xy - kxx * track.xy - kxy * track.yy,
        yy=track.yy - kyx * track.xy - kyy * track.yy,
        hits=track.hits + 1,
    )


def _innovation(one: Track, other: Track) -> tuple[float, float, float]:
    pose = POSE_SIGMA_M**2
    return one.xx + other.xx + pose, one.xy + other.xy, one.yy + other.yy + pose


def _inverse(xx: float, xy: float, yy: float) -> tuple[float, float, float]:
    det = xx * yy - xy * xy
    return yy / det, -xy / det, xx / det
