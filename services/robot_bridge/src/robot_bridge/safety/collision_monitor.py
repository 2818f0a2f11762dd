"""The filter nothing skips: what the laser, the bumpers and the age of both leave of a wanted velocity. Pure."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from contracts.causes import SafetyCause
from contracts.geometry import Twist2D
from contracts.motion import Hazard
from robot_bridge.body import BodyLimits
from robot_bridge.sensing.blindness import NO_ARCS, Arcs, hiding_places
from robot_bridge.sensing.snapshot import AgeLimits

NO_FORWARD = frozenset({Hazard.BUMP, Hazard.CLIFF, Hazard.STALL})
NO_REVERSE = frozenset({Hazard.BACKUP_LIMIT, Hazard.STALL})
NO_LENGTH_M = 1e-6
"""Shorter than this, the sides of a triangle say nothing about its angles."""
FOREIGN_VELOCITY_S = 1.0
"""So long after somebody else has driven the base it is left alone."""


class SafetyLimits(BodyLimits, AgeLimits):
    """Distances are from the footprint, not from the sensor."""

    side_margin_m: float = Field(default=0.02, ge=0.0, le=0.5, description="kept free on each side of the footprint")
    stop_distance_m: float = Field(default=0.08, ge=0.0, le=2.0, description="from the footprint")
    slow_distance_m: float = Field(default=0.35, gt=0.0, le=5.0, description="from the footprint")
    slow_factor_min: float = Field(default=0.3, gt=0.0, le=1.0, description="of the speed, close to the stop distance")
    scan_age_to_turn_s_max: float = Field(default=2.0, gt=0.0, description="with an older scan not even a turn is safe")


@dataclass(frozen=True, slots=True)
class SafetyInput:
    """What the filter may know; ages are none where nothing ever came.

    `points_m` is (n, 2) in the base_link of the scan's time, `measured` the velocity since.
    """

    points_m: NDArray[np.float64]
    scan_age_s: float | None
    odometry_age_s: float | None
    blind: Arcs = field(default_factory=lambda: NO_ARCS)
    """Where the laser, which sits at `laser_m`, knows nothing."""
    laser_m: tuple[float, float] = (0.0, 0.0)
    scan_trouble: str = ""
    """Why the newest scan was not understood; '' where it was."""
    measured: Twist2D = field(default_factory=Twist2D)
    hazards: frozenset[Hazard] = frozenset()
    base_stopped: bool = False
    """The base has disabled its wheels."""
    foreign_velocity_age_s: float | None = None
    """Since somebody else last told the base to move."""


@dataclass(frozen=True, slots=True)
class Restraint:
    """Why the filter left less of a velocity than was wanted, and the numbers it went by."""

    cause: SafetyCause
    forward: bool = True
    """Whether it was the way ahead that counted, or the way back."""
    free_m: float = math.inf
    scan_age_s: float = 0.0
    hazards: frozenset[Hazard] = frozenset()
    """Those that forbid this motion."""
    scan_trouble: str = ""
    """Why the scan is not understood."""
    inside_rad: float | None = None
    """The bearing of what the laser sees inside the footprint, where that is what is in the way."""


def apply_safety(twist: Twist2D, around: SafetyInput, limits: SafetyLimits) -> tuple[Twist2D, Restraint | None]:
    """The twist, never faster and never turned round, and why it differs (None when it does not)."""
    if twist == Twist2D():
        return twist, None
    if (cause := _no_motion_because(around, limits)) is not None:
        return Twist2D(), _restraint(cause, twist, around)
    if twist.linear_x == 0.0:
        return twist, None
    way = _way(twist, around, limits)
    if (cause := _no_translation_because(twist.linear_x, way, around, limits)) is not None:
        return Twist2D(angular_z=twist.angular_z), _restraint(cause, twist, around, way)
    factor = slowdown(way.clear_m, limits)
    if factor >= 1.0:
        return twist, None
    slowed = Twist2D(linear_x=twist.linear_x * factor, angular_z=twist.angular_z * factor)
    return slowed, _restraint(SafetyCause.SLOWED, twist, around, way)


def seen_from_here(points_m: NDArray[np.float64], measured: Twist2D, age_s: float) -> NDArray[np.float64]:
    """Where the points of a scan `age_s` old are now, as the robot has moved on with `measured` since."""
    turned = measured.angular_z * age_s
    driven_m = measured.linear_x * age_s
    moved = points_m - driven_m * np.array([math.cos(turned / 2.0), math.sin(turned / 2.0)])
    cosine, sine = math.cos(turned), math.sin(turned)
    return moved @ np.array([[cosine, -sine], [sine, cosine]])


def slowdown(free_m: float, limits: SafetyLimits) -> float:
    """(distance - stop) / (slow - stop), no less than the floor, no more than 1 (requirement C2)."""
    part = (free_m - limits.stop_distance_m) / (limits.slow_distance_m - limits.stop_distance_m)
    return min(1.0, max(limits.slow_factor_min, part))


def free_travel_m(points_m: NDArray[np.float64], twist: Twist2D, radius_m: float) -> float:
    """How far a disc of `radius_m` goes along the twist's arc until it touches a point; inf when it never does.

    The corridor it sweeps, not the whole half-plane: a door is passed by what stands beside it. A point already inside
    the disc counts only when the motion goes towards it.
    """
    if points_m.size == 0:
        return math.inf
    x, y = points_m[:, 0], points_m[:, 1]
    if twist.linear_x < 0.0:  # seen from behind, reversing is driving forward with the same turn
        x, y = -x, -y
    speed = abs(twist.linear_x)
    if abs(twist.angular_z) * 10.0 < speed:  # an arc of more than 10 m radius is straight within what matters here
        touched = (np.abs(y) < radius_m) & (x > 0.0)
        if not touched.any():
            return math.inf
        reach = x[touched] - np.sqrt(radius_m**2 - y[touched] ** 2)
        return max(0.0, float(reach.min()))
    turn_radius_m = max(NO_LENGTH_M, speed / abs(twist.angular_z))
    y = y * math.copysign(1.0, twist.angular_z)  # mirrored: always a left turn about (0, turn_radius_m)
    from_centre = np.hypot(x, y - turn_radius_m)
    # so near to the centre, a point is touched only if it already is
    touched = (np.abs(from_centre - turn_radius_m) < radius_m) & (from_centre > NO_LENGTH_M)
    touched &= (x > 0.0) | (np.hypot(x, y) >= radius_m)
    if not touched.any():
        return math.inf
    d = from_centre[touched]
    bearing = np.arctan2(x[touched], turn_radius_m - y[touched]) % (2.0 * math.pi)
    cosine = (turn_radius_m**2 + d**2 - radius_m**2) / (2.0 * turn_radius_m * d)
    before_contact = np.arccos(np.clip(cosine, -1.0, 1.0))
    inside = np.hypot(x[touched], y[touched]) < radius_m
    arc_rad = np.where(inside, 0.0, np.maximum(0.0, bearing - before_contact))
    return float(arc_rad.min()) * turn_radius_m


@dataclass(frozen=True, slots=True)
class _Way:
    """How far the robot goes until it touches what is seen, and until it may touch what is not."""

    free_m: float = math.inf
    known_m: float = math.inf
    inside_rad: float | None = None

    @property
    def clear_m(self) -> float:
        return min(self.free_m, self.known_m)


def _way(twist: Twist2D, around: SafetyInput, limits: SafetyLimits) -> _Way:
    radius_m, age_s = limits.footprint_radius_m + limits.side_margin_m, around.scan_age_s or 0.0
    free_m, known_m = (
        free_travel_m(seen_from_here(points_m, around.measured, age_s), twist, radius_m)
        for points_m in (around.points_m, unseen(around, limits))
    )
    return _Way(free_m, known_m, _inside(around.points_m, limits.footprint_radius_m) if free_m == 0.0 else None)


def unseen(around: SafetyInput, limits: SafetyLimits) -> NDArray[np.float64]:
    """(n, 2) places in the base_link of the scan's time, as far off as they matter, where something could stand that
    the laser does not see."""
    radius_m = limits.footprint_radius_m + limits.side_margin_m
    driven_m = abs(around.measured.linear_x) * (around.scan_age_s or 0.0)
    return hiding_places(around.blind, around.laser_m, radius_m, radius_m + limits.slow_distance_m + driven_m)


def _inside(points_m: NDArray[np.float64], footprint_m: float) -> float | None:
    """The bearing of what was seen nearest to the middle of the robot, inside of its footprint; none where nothing was.

    When the scan was taken: what the robot has driven up to since is no part of it.
    """
    apart_m = np.hypot(points_m[:, 0], points_m[:, 1])
    if not (apart_m < footprint_m).any():
        return None
    x, y = points_m[int(np.argmin(apart_m))]
    return math.atan2(y, x)


def _no_motion_because(around: SafetyInput, limits: SafetyLimits) -> SafetyCause | None:
    if around.base_stopped:
        return SafetyCause.BASE_STOPPED
    if around.foreign_velocity_age_s is not None and around.foreign_velocity_age_s <= FOREIGN_VELOCITY_S:
        return SafetyCause.STRANGER
    if Hazard.WHEEL_DROP in around.hazards:
        return SafetyCause.WHEEL_DROP
    if around.scan_age_s is None or around.scan_age_s > limits.scan_age_to_turn_s_max:
        return SafetyCause.NOT_UNDERSTOOD if around.scan_trouble else SafetyCause.NO_SCAN
    return None


def _no_translation_because(
    linear_x: float, way: _Way, around: SafetyInput, limits: SafetyLimits
) -> SafetyCause | None:
    old = (around.scan_age_s or 0.0) > limits.scan_age_s_max
    applies = {
        SafetyCause.NOT_UNDERSTOOD: old and bool(around.scan_trouble),
        SafetyCause.OLD_SCAN: old,
        SafetyCause.BLIND: way.known_m <= limits.stop_distance_m < way.free_m,
        SafetyCause.NO_ODOMETRY: around.odometry_age_s is None or around.odometry_age_s > limits.odometry_age_s_max,
        SafetyCause.HAZARD: bool(_forbidding(linear_x, around)),
        SafetyCause.OBSTACLE: way.free_m <= limits.stop_distance_m,
    }
    return next((cause for cause, yes in applies.items() if yes), None)


def _restraint(cause: SafetyCause, twist: Twist2D, around: SafetyInput, way: _Way | None = None) -> Restraint:
    way = way or _Way()
    return Restraint(
        cause=cause,
        forward=twist.linear_x >= 0.0,
        free_m=way.clear_m,
        scan_age_s=around.scan_age_s or 0.0,
        hazards=_forbidding(twist.linear_x, around) if cause is SafetyCause.HAZARD else frozenset(),
        scan_trouble=around.scan_trouble,
        inside_rad=way.inside_rad,
    )


def _forbidding(linear_x: float, around: SafetyInput) -> frozenset[Hazard]:
    return around.hazards & (NO_FORWARD if linear_x > 0.0 else NO_REVERSE)
