"""Where the candidate is from the robot, and the ring of poses from which it can be reached."""

import math

from contracts.geometry import Pose2D
from coordinator.core.geometry import Relative, relative, ring
from coordinator.core.step_context import StepContext
from geometry.poses import apart_m, wrap

EXCLUDED_RAD = 0.5


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


def too_near_for_a_goal(context: StepContext, pose: Pose2D) -> bool:
    """Nav2 calls a goal reached from within its tolerance (0.25 m): so short a way is turned and driven instead."""
    here = context.mission.robot.pose
    return here is not None and apart_m(here, pose) < context.rules.goal_m_min


def approach_candidates(
    context: StepContext, radii_m: tuple[float, ...], tried_rad: tuple[float, ...] = ()
) -> tuple[tuple[tuple[Pose2D, ...], ...], tuple[float, ...]]:
    """Groups of poses facing the object, nearest ring first, and what each costs in metres of path for lying further
    round it; only radii nearer than the robot stands, and only directions not within 0.5 rad of a tried one.
    """
    candidate, pose = context.candidate, context.mission.robot.pose
    if candidate.map_xy is None or pose is None:
        return (), ()
    x, y = candidate.map_xy
    seen_from = math.atan2(pose.y - y, pose.x - x)
    away_m = math.hypot(pose.x - x, pose.y - y)
    offsets = tuple(
        a
        for a in context.rules.ring_angles_rad
        if all(abs(wrap(seen_from + a - tried)) > EXCLUDED_RAD for tried in tried_rad)
    )
    if not offsets:
        return (), ()
    nearer = tuple(r for r in radii_m if tried_rad or r < away_m - 0.1)
    groups = tuple(ring(x, y, r, tuple(seen_from + a for a in offsets)) for r in nearer)
    costs = tuple(abs(a) * context.rules.ring_turn_cost_m_rad for a in offsets) * len(groups)
    return groups, costs
