"""What a trajectory makes the joints do between its points, and the trajectory home. Pure.

A controller goes straight in joint space where a point tells no velocities, else along the cubic whose ends and end
velocities are given (ros2_control's joint_trajectory_controller). Both are checked as they are driven: a cubic can
leave the range of its ends, and its speed that of its mean.
"""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from contracts.arm import POINT_APART_S_MIN, ArmRefusal, ArmTrajectoryRequest, TrajectoryPoint
from robot_bridge.arm.models import ArmModel

HOME_POINTS: Final = 16
HOME_S_MIN: Final = 0.5
JERK_PEAK: Final = 1.875
"""The peak of a minimum-jerk motion's speed over its mean (Flash and Hogan 1985)."""
ROUNDING: Final = 1e-3
"""Of a speed limit or a time, relative: what arithmetic adds."""
ROUNDING_RAD: Final = 1e-6
"""Of an angle outside the range: what arithmetic adds."""
AT_REST_RAD_S: Final = 1e-7
"""What ros2_control's joint_trajectory_controller takes for 0 at a trajectory's end."""
COEFFICIENT_MAX: Final = 1e100
"""Of a cubic: beyond any arm, and far below where its squares are no numbers any more."""


@dataclass(frozen=True, slots=True)
class Refused:
    """Why a trajectory is not driven: for a program, and for a person."""

    code: ArmRefusal
    text: str


@dataclass(frozen=True, slots=True)
class Extremes:
    """How far and how fast one joint goes between two points."""

    lowest_rad: float
    highest_rad: float
    fastest_rad_s: float


def why_refused(
    request: ArmTrajectoryRequest, model: ArmModel, now_rad: tuple[float, ...], *, speed_rad_s_max: float
) -> Refused | None:
    """None where it may be driven from where the joints are now (`now_rad`, in the model's order), at rest.

    A joint that is outside its range may be anywhere between there and the range, but no farther out than before.
    """
    if sorted(request.joints) != sorted(model.names):
        return Refused(ArmRefusal.WRONG_JOINTS, f"each of {', '.join(model.names)} is to be named once")
    count, before_s = len(model.joints), 0.0
    for point in request.points:
        if len(point.positions_rad) != count or len(point.velocities_rad_s) not in {0, count}:
            return Refused(ArmRefusal.BAD_POINT, f"the point at {point.time_s:g} s has not {count} values")
        if point.time_s - before_s < POINT_APART_S_MIN * (1 - ROUNDING):
            text = f"the time {point.time_s:g} s does not come {POINT_APART_S_MIN:g} s after {before_s:g} s"
            return Refused(ArmRefusal.BAD_TIMES, text)
        before_s = point.time_s
    if any(abs(rate) > AT_REST_RAD_S for rate in request.points[-1].velocities_rad_s):
        return Refused(ArmRefusal.ENDS_MOVING, "a trajectory ends at rest: the last point's velocities are 0")
    start = TrajectoryPoint.model_construct(time_s=0.0, positions_rad=now_rad, velocities_rad_s=(0.0,) * count)
    for one, other in pairwise((start, *in_order(request, model))):
        if (refused := _why_not(one, other, model, speed_rad_s_max)) is not None:
            return refused
    return None


def in_order(request: ArmTrajectoryRequest, model: ArmModel) -> tuple[TrajectoryPoint, ...]:
    """Its points with the joints in the model's order; it names each once."""
    at = [request.joints.index(name) for name in model.names]

    def ordered(values: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(values[i] for i in at) if values else ()

    return tuple(
        TrajectoryPoint(
            time_s=point.time_s,
            positions_rad=ordered(point.positions_rad),
            velocities_rad_s=ordered(point.velocities_rad_s),
        )
        for point in request.points
    )


def between(one: float, other: float, v_one: float, v_other: float, span_s: float) -> Extremes:
    """Of the cubic over `span_s` with these ends (rad) and end velocities (rad/s).

    Its slope is a parabola: the ends, its roots and its vertex are all that can be extreme. Infinite extremes where
    what is asked for is too large to reckon with.
    """
    a = 2 * (one - other) + span_s * (v_one + v_other)
    b = 3 * (other - one) - span_s * (2 * v_one + v_other)
    c = span_s * v_one
    if not abs(a) + abs(b) + abs(c) <= COEFFICIENT_MAX:  # nor is it where one is no number
        return Extremes(-math.inf, math.inf, math.inf)

    def position(s: float) -> float:
        return ((a * s + b) * s + c) * s + one

    def velocity(s: float) -> float:
        return ((3 * a * s + 2 * b) * s + c) / span_s

    turns = [s for s in _roots(3 * a, 2 * b, c) if 0.0 < s < 1.0]
    bends = [s for s in ([-b / (3 * a)] if a else []) if 0.0 < s < 1.0]
    places = [other, *(position(s) for s in turns)]  # where it begins is where it is
    return Extremes(min(places), max(places), max(abs(velocity(s)) for s in (0.0, 1.0, *bends)))


def home(model: ArmModel, now_rad: tuple[float, ...], *, speed_rad_s_max: float) -> tuple[TrajectoryPoint, ...]:
    """Home from where the joints are, all at once and smoothly (minimum jerk), the furthest one at that speed."""
    ways = tuple(to - at for at, to in zip(now_rad, model.home_rad, strict=True))
    top = [min(speed_rad_s_max, joint.speed_rad_s_max) for joint in model.joints]
    total_s = max(HOME_S_MIN, *(JERK_PEAK * abs(way) / speed for way, speed in zip(ways, top, strict=True)))
    points: list[TrajectoryPoint] = []
    for index in range(1, HOME_POINTS + 1):
        t = index / HOME_POINTS
        share = t**3 * (10 - 15 * t + 6 * t * t)
        rate = 30 * t * t * (1 - t) ** 2 / total_s
        points.append(
            TrajectoryPoint(
                time_s=t * total_s,
                positions_rad=tuple(at + share * way for at, way in zip(now_rad, ways, strict=True)),
                velocities_rad_s=tuple(rate * way for way in ways),
            )
        )
    return tuple(points)


def _why_not(one: TrajectoryPoint, other: TrajectoryPoint, model: ArmModel, speed_rad_s_max: float) -> Refused | None:
    span_s = other.time_s - one.time_s
    for index, joint in enumerate(model.joints):
        begin, end = one.positions_rad[index], other.positions_rad[index]
        mean = (end - begin) / span_s
        cubic = bool(one.velocities_rad_s and other.velocities_rad_s)
        v_begin, v_end = (one.velocities_rad_s[index], other.velocities_rad_s[index]) if cubic else (mean, mean)
        found = between(begin, end, v_begin, v_end, span_s)
        where = f"before {other.time_s:g} s {joint.name} would"
        lower, upper = min(joint.lower_rad, begin - ROUNDING_RAD), max(joint.upper_rad, begin + ROUNDING_RAD)
        if not (lower <= found.lowest_rad and found.highest_rad <= upper):  # a joint that is outside may come back
            furthest = found.lowest_rad if found.lowest_rad < lower else found.highest_rad
            text = f"{where} be at {furthest:.3f} rad, outside {joint.lower_rad:g} to {joint.upper_rad:g} rad"
            return Refused(ArmRefusal.OUT_OF_LIMITS, text)
        most = min(speed_rad_s_max, joint.speed_rad_s_max)
        if not found.fastest_rad_s <= most * (1 + ROUNDING):
            text = f"{where} turn at {found.fastest_rad_s:.2f} rad/s, more than {most:g} rad/s"
            return Refused(ArmRefusal.JOINT_TOO_FAST, text)
    return None


def _roots(a: float, b: float, c: float) -> tuple[float, ...]:
    """Where a s^2 + b s + c is zero."""
    if abs(a) < 1e-12:
        return (-c / b,) if abs(b) > 1e-12 else ()
    if (under := b * b - 4 * a * c) < 0.0:
        return ()
    root = math.sqrt(under)
    return ((-b - root) / (2 * a), (-b + root) / (2 * a))
