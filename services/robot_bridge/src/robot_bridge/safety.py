"""The filter nothing skips: what the laser, the bumpers and the age of both leave of a wanted velocity. Pure."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from contracts.causes import SafetyCause
from contracts.geometry import Twist2D
from contracts.motion import Hazard

NO_FORWARD = frozenset({Hazard.BUMP, Hazard.CLIFF, Hazard.STALL})
NO_REVERSE = frozenset({Hazard.BACKUP_LIMIT, Hazard.STALL})
NO_LENGTH_M = 1e-6
"""Shorter than this, the sides of a triangle say nothing about its angles."""


@dataclass(frozen=True, slots=True)
class SafetyLimits:
    """Distances are from the footprint, a disc round base_link, not from the sensor."""

    footprint_radius_m: float = 0.189
    side_margin_m: float = 0.02
    stop_distance_m: float = 0.08
    slow_distance_m: float = 0.35
    slow_factor_min: float = 0.3
    scan_age_s_max: float = 0.5
    scan_age_to_turn_s_max: float = 2.0
    odometry_age_s_max: float = 0.5
    known_fraction_min: float = 0.3
    foreign_velocity_s: float = 1.0
    """So long after somebody else has driven the base it is left alone."""


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What the filter may know; ages are none where nothing ever came.

    `points_m` is (n, 2) in the base_link of the scan's time, `measured` the velocity since. `known_ahead` and
    `known_behind` are the parts of the laser's beams there that said anything.
    """

    points_m: NDArray[np.float64]
    scan_age_s: float | None
    odometry_age_s: float | None
    known_ahead: float = 1.0
    known_behind: float = 1.0
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


def restrain(twist: Twist2D, around: Surroundings, limits: SafetyLimits) -> tuple[Twist2D, Restraint | None]:
    """The twist, never faster and never turned round, and why it differs (None when it does not)."""
    if twist == Twist2D():
        return twist, None
    if (cause := _no_motion_because(around, limits)) is not None:
        return Twist2D(), _restraint(cause, twist, around)
    if twist.linear_x == 0.0:
        return twist, None
    points_m = seen_from_here(around.points_m, around.measured, around.scan_age_s or 0.0)
    free_m = free_travel_m(points_m, twist, limits.footprint_radius_m + limits.side_margin_m)
    if (cause := _no_translation_because(twist.linear_x, free_m, around, limits)) is not None:
        return Twist2D(angular_z=twist.angular_z), _restraint(cause, twist, around, free_m)
    factor = slowdown(free_m, limits)
    if factor >= 1.0:
        return twist, None
    slowed = Twist2D(linear_x=twist.linear_x * factor, angular_z=twist.angular_z * factor)
    return slowed, _restraint(SafetyCause.SLOWED, twist, around, free_m)


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


def _no_motion_because(around: Surroundings, limits: SafetyLimits) -> SafetyCause | None:
    if around.base_stopped:
        return SafetyCause.BASE_STOPPED
    if around.foreign_velocity_age_s is not None and around.foreign_velocity_age_s <= limits.foreign_velocity_s:
        return SafetyCause.STRANGER
    if Hazard.WHEEL_DROP in around.hazards:
        return SafetyCause.WHEEL_DROP
    if around.scan_age_s is None or around.scan_age_s > limits.scan_age_to_turn_s_max:
        return SafetyCause.NO_SCAN
    return None


def _no_translation_because(
    linear_x: float, free_m: float, around: Surroundings, limits: SafetyLimits
) -> SafetyCause | None:
    known = around.known_ahead if linear_x > 0.0 else around.known_behind
    applies = {
        SafetyCause.OLD_SCAN: (around.scan_age_s or 0.0) > limits.scan_age_s_max,
        SafetyCause.BLIND: known < limits.known_fraction_min,
        SafetyCause.NO_ODOMETRY: around.odometry_age_s is None or around.odometry_age_s > limits.odometry_age_s_max,
        SafetyCause.HAZARD: bool(_forbidding(linear_x, around)),
        SafetyCause.OBSTACLE: free_m <= limits.stop_distance_m,
    }
    return next((cause for cause, yes in applies.items() if yes), None)


def _restraint(cause: SafetyCause, twist: Twist2D, around: Surroundings, free_m: float = math.inf) -> Restraint:
    return Restraint(
        cause=cause,
        forward=twist.linear_x >= 0.0,
        free_m=free_m,
        scan_age_s=around.scan_age_s or 0.0,
        hazards=_forbidding(twist.linear_x, around) if cause is SafetyCause.HAZARD else frozenset(),
    )


def _forbidding(linear_x: float, around: Surroundings) -> frozenset[Hazard]:
    return around.hazards & (NO_FORWARD if linear_x > 0.0 else NO_REVERSE)
