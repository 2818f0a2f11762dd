"""Where the candidate is from the robot, and the poses in reach of it, or of a thing that is remembered."""

import math

from contracts.geometry import Pose2D
from contracts.robot import CandidatePose
from coordinator.core.evidence import of_the_same, sides_rad
from coordinator.core.geometry import Relative, near_any, relative
from coordinator.core.mission import SearchPose
from coordinator.core.rules import ApproachRule, Rules
from coordinator.core.step_context import StepContext
from geometry.poses import wrap

EXCLUDED_RAD = 0.5
SAME_SIDE_RAD = 0.75
"""A thing remembered from one side may be hidden from another."""


def target_in_base(context: StepContext) -> Relative | None:
    """By odometry where it was measured in odom (smooth, no jumps of localisation), else by the map."""
    candidate, robot = context.candidate, context.mission.robot
    if candidate.odom_xy is not None and robot.odometry is not None:
        return relative(*candidate.odom_xy, robot.odometry)
    if candidate.map_xy is not None and robot.pose is not None:
        return relative(*candidate.map_xy, robot.pose)
    return None


def surface_distance_m(context: StepContext) -> float | None:
    """From the camera to the near surface, by the last measurement and odometry."""
    there = target_in_base(context)
    return max(0.0, there.distance_m - context.rules.camera_forward_m) if there is not None else None


def other_sides(context: StepContext) -> tuple[CandidatePose, ...]:
    """Where the candidate can be looked at from a side that it was not judged from."""
    at, rules = context.candidate.map_xy, context.rules
    if at is None:
        return ()
    looks = of_the_same(context.search.judgements, at, rules.rejected_radius_m)
    return approach_candidates(context, rules.step_ring_radii_m, sides_rad(looks))


def approach_candidates(
    context: StepContext, radii_m: tuple[float, ...], tried_rad: tuple[float, ...] = ()
) -> tuple[CandidatePose, ...]:
    """Poses facing the object, the nearest circle first; lying farther round it costs metres of path. Only circles so
    much nearer than the robot stands that Nav2 does not call the way done (its tolerance is 0.25 m), and only
    directions not within 0.5 rad of a tried one.
    """
    candidate, pose, rules = context.candidate, context.mission.robot.pose, context.rules
    if candidate.map_xy is None or pose is None:
        return ()
    away_m = _away_m(candidate.map_xy, pose)
    radii_m = tuple(r for r in radii_m if tried_rad or r < away_m - rules.goal_m_min)
    return _facing(candidate.map_xy, pose, radii_m, rules, tried_rad)


def look_candidates(context: StepContext, place: SearchPose) -> tuple[CandidatePose, ...]:
    """In reach of the remembered thing and facing it, on the side it was seen from; last where it was seen from.

    Only there if its place is not known, or once it was looked for in reach.
    """
    rules, thing_xy, visited = context.rules, place.thing_xy, context.search.visited
    if thing_xy is None or rules.approach_rule is not ApproachRule.LOCALIZED:
        return (CandidatePose(pose=place.pose),)
    radii_m = tuple(r for r in rules.step_ring_radii_m if r < _away_m(thing_xy, place.pose) - rules.goal_m_min)
    there = place.pose.model_copy(update={"x": thing_xy[0], "y": thing_xy[1]})
    if near_any(there, visited, max(radii_m, default=0.0) + rules.goal_m_min):
        radii_m = ()
    in_reach = _facing(thing_xy, place.pose, radii_m, rules, within_rad=SAME_SIDE_RAD)
    return (*in_reach, CandidatePose(pose=place.pose, rank=len(radii_m)))


def _away_m(xy: tuple[float, float], pose: Pose2D) -> float:
    return math.hypot(pose.x - xy[0], pose.y - xy[1])


def _facing(
    xy: tuple[float, float],
    seen: Pose2D,
    radii_m: tuple[float, ...],
    rules: Rules,
    tried_rad: tuple[float, ...] = (),
    within_rad: float = math.pi,
) -> tuple[CandidatePose, ...]:
    x, y = xy
    seen_from = math.atan2(seen.y - y, seen.x - x)
    return tuple(
        CandidatePose(
            pose=Pose2D(
                x=x + radius_m * math.cos(seen_from + a),
                y=y + radius_m * math.sin(seen_from + a),
                yaw=wrap(seen_from + a + math.pi),
            ),
            cost_m=abs(a) * rules.ring_turn_cost_m_rad,
            rank=rank,
        )
        for rank, radius_m in enumerate(radii_m)
        for a in rules.ring_angles_rad
        if abs(a) <= within_rad and all(abs(wrap(seen_from + a - tried)) > EXCLUDED_RAD for tried in tried_rad)
    )
