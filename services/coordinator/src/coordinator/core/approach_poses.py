"""Where the candidate is from the robot, and the ring of poses from which it can be reached."""

import math

from contracts.geometry import Pose2D
from contracts.robot import CandidatePose
from coordinator.core.geometry import Relative, relative
from coordinator.core.step_context import StepContext
from geometry.poses import wrap

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
    x, y = candidate.map_xy
    seen_from = math.atan2(pose.y - y, pose.x - x)
    away_m = math.hypot(pose.x - x, pose.y - y)
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
        for rank, radius_m in enumerate(r for r in radii_m if tried_rad or r < away_m - rules.goal_m_min)
        for a in rules.ring_angles_rad
        if all(abs(wrap(seen_from + a - tried)) > EXCLUDED_RAD for tried in tried_rad)
    )
