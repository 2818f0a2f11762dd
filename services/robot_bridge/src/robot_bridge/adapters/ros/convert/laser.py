"""A laser scan: what it hit, where nothing is, and what it does not know. What cannot be understood is never free."""

import math

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import LaserScan

from robot_bridge.sensing.blindness import Arcs, arcs_of
from robot_bridge.sensing.laser_rules import LaserRules, ZeroRange
from robot_bridge.sensing.sensor_readings import Scan
from robot_bridge.sensing.transforms import Matrix

BEAMS_MAX = 20_000
STEP_RAD_MIN, STEP_RAD_MAX = math.tau / BEAMS_MAX, 0.2
ANGLES_OFF_BEAMS, ANGLES_OFF_PART = 2.0, 0.01
"""Drivers round: angle_max may be so far from what the count says, in beams, or as a part of all of them."""
RANGE_MIN_M_MAX = 1.0
RANGE_MAX_M_MIN, RANGE_M_MAX = 1.0, 500.0
"""No laser of a robot ends nearer than that, none reaches further (infinity says that there is no such limit)."""
BEYOND = 1.25
"""Up to so many times range_max a range is a driver's way to say that nothing is there; more is no metre."""
TURN_S_MAX = 5.0
POST_RAD_MAX = 0.2
LEVEL_COSINE = math.cos(math.radians(20.0))

Mask = NDArray[np.bool_]


def scan(message: LaserScan, laser_in_base: Matrix, stamp_s: float, rules: LaserRules | None = None) -> Scan:
    """Hits as points in base_link. Raises `ValueError` where the scan's own limits make no sense."""
    rules = rules or LaserRules()
    ranges = np.asarray(message.ranges, dtype=np.float64)
    if why := _why_not(message, ranges.size, laser_in_base):
        raise ValueError(why)
    far = min(message.range_max, RANGE_M_MAX)
    hit = (ranges >= message.range_min) & (ranges <= far)
    hit &= ranges > 0.0  # also where range_min is 0: 0.0 is no distance
    nothing = (ranges == np.inf) | ((ranges > far) & (ranges <= BEYOND * message.range_max) & np.isfinite(ranges))
    nothing |= (ranges == 0.0) & (rules.laser_zero_means is ZeroRange.NOTHING_THERE)
    angles = message.angle_min + message.angle_increment * np.arange(ranges.size, dtype=np.float64)
    bearings = _in_base(angles, laser_in_base)
    own = _own_parts(bearings, ranges, rules) | _posts(bearings, ranges, message, laser_in_base, rules)
    hit, nothing = hit & ~own, nothing & ~own
    unknown = ~(hit | nothing | own)
    x, y = laser_in_base[:2, :2] @ np.stack([np.cos(angles[hit]), np.sin(angles[hit])]) * ranges[hit]
    points = np.stack([x + laser_in_base[0, 3], y + laser_in_base[1, 3]], axis=1)
    return Scan(
        stamp_s,
        points,
        open_rad=bearings[nothing],
        blind=_blind(unknown, message, laser_in_base),
        laser_m=(float(laser_in_base[0, 3]), float(laser_in_base[1, 3])),
        note=_note(ranges, unknown, points, message.range_max, rules.footprint_radius_m),
    )


def _why_not(message: LaserScan, beams: int, laser_in_base: Matrix) -> str:
    """Why the scan cannot be understood at all, '' where it can."""
    near, far, step = message.range_min, message.range_max, message.angle_increment
    first, last = message.angle_min, message.angle_max
    reasons = {
        "it is mounted at a slant": not abs(laser_in_base[2, 2]) >= LEVEL_COSINE,
        f"it has {beams} beams": not 0 < beams <= BEAMS_MAX,
        f"its range_min is {near:g} m": not 0.0 <= near <= RANGE_MIN_M_MAX,
        f"its range_max is {far:g} m": not (RANGE_MAX_M_MIN <= far <= RANGE_M_MAX or far == math.inf),
        f"its range_max, {far:g} m, is not beyond its range_min, {near:g} m": not far > near,
        f"its angle_min is {first:g} rad": not abs(first) <= 2.0 * math.tau,
        f"its angle_increment is {step:g} rad": not STEP_RAD_MIN <= abs(step) <= STEP_RAD_MAX,
        f"{beams} beams {step:g} rad apart are more than a full turn": abs(step) * (beams - 2) > math.tau,
        f"its angles, {first:g} to {last:g} rad, are not those of {beams} beams {step:g} rad apart": not (
            abs(first + step * (beams - 1) - last) <= abs(step) * max(ANGLES_OFF_BEAMS, ANGLES_OFF_PART * beams)
        ),
        f"it has {len(message.intensities)} intensities for {beams} beams": len(message.intensities) not in {0, beams},
        f"its scan_time is {message.scan_time:g} s": not 0.0 <= message.scan_time <= TURN_S_MAX,
        f"its time_increment is {message.time_increment:g} s": not (
            0.0 <= message.time_increment * beams <= TURN_S_MAX
        ),
    }
    return next((reason for reason, applies in reasons.items() if applies), "")


def _in_base(angles: NDArray[np.float64], laser_in_base: Matrix) -> NDArray[np.float64]:
    """Bearings in base_link of the beams, however the laser is turned."""
    x, y = laser_in_base[:2, :2] @ np.stack([np.cos(angles), np.sin(angles)])
    return np.arctan2(y, x)


def _own_parts(bearings: NDArray[np.float64], ranges: NDArray[np.float64], rules: LaserRules) -> Mask:
    """Beams that a known part of the robot stops; one that sees past it, or nothing, counts as any other."""
    own = np.zeros(ranges.size, np.bool_)
    for mask in rules.laser_masks:
        within = (bearings - mask.from_rad) % math.tau <= mask.to_rad - mask.from_rad
        own |= within & ~(ranges > mask.range_m_max)
    return own


def _posts(
    bearings: NDArray[np.float64],
    ranges: NDArray[np.float64],
    message: LaserScan,
    laser_in_base: Matrix,
    rules: LaserRules,
) -> Mask:
    """Narrow things nearer than range_min and inside the footprint, which only the robot's own posts can be. What
    covers more of the view than a post may be anything."""
    near = (ranges > 0.0) & (ranges < message.range_min)
    distance_m = np.where(near, ranges, 0.0)
    x = laser_in_base[0, 3] + distance_m * np.cos(bearings)
    y = laser_in_base[1, 3] + distance_m * np.sin(bearings)
    near &= np.hypot(x, y) < rules.footprint_radius_m
    if not near.any():
        return near
    for begin, width in _blind(near, message, laser_in_base):
        if width > POST_RAD_MAX:
            near &= (bearings - begin) % math.tau > width
    return near


def _blind(unknown: Mask, message: LaserScan, laser_in_base: Matrix) -> Arcs:
    """The arcs of unknown beams, as base_link counts angles: a laser that hangs upside down counts them the other way
    round."""
    upside_down = laser_in_base[2, 2] < 0.0
    heading = float(_in_base(np.zeros(1), laser_in_base)[0])
    side = -1.0 if upside_down else 1.0
    return arcs_of(unknown, heading + side * message.angle_min, side * message.angle_increment)


def _note(
    ranges: NDArray[np.float64], unknown: Mask, points: NDArray[np.float64], range_max_m: float, footprint_m: float
) -> str:
    if (np.isfinite(ranges) & (ranges > BEYOND * range_max_m)).mean() > 0.5:
        return f"most of its ranges lie far beyond range_max, {range_max_m:g} m: they are not metres"
    if unknown.all():
        return f"none of its {ranges.size} beams says anything"
    apart_m = np.hypot(points[:, 0], points[:, 1])
    if not (apart_m < footprint_m).any():
        return ""
    x, y = points[int(np.argmin(apart_m))]
    return (
        f"something inside the footprint is seen at {math.degrees(math.atan2(y, x)):.0f} degrees, "
        f"{math.hypot(x, y):.2f} m from the middle: if it is a part of the robot, mask it (ROBOT_BRIDGE_LASER_MASKS)"
    )
