"""The controller of the stand-in for Nav2: regulated pure pursuit, turning on the spot where the path turns sharply.

After Macenski et al., "Regulated Pure Pursuit for Robot Path Tracking" (2023): the speed falls with the curvature, near
obstacles and towards the goal.
"""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D, Twist2D
from geometry.poses import wrap
from sim.nav.planner import SPACING_M, Path

STILL: Final = Twist2D()
_WINDOW: Final = round(1.2 / SPACING_M)
"""Way points ahead among which the nearest is looked for."""


@dataclass(frozen=True)
class Limits:
    """How the stand-in drives. Speeds stay below the Create 3's own 0.306 m/s."""

    speed_m_s: float = 0.26
    speed_min_m_s: float = 0.05
    turn_rad_s: float = 1.2
    turn_min_rad_s: float = 0.2
    lookahead_m: float = 0.35
    turn_first_rad: float = math.radians(45)
    turned_rad: float = math.radians(8)
    slow_radius_m: float = 0.7
    slow_goal_m: float = 0.6
    slow_clearance_m: float = 0.35
    goal_tolerance_m: float = 0.25
    goal_tolerance_rad: float = 0.25
    footprint_m: float = 0.17
    foresight_s: float = 1.2
    foresight_min_m: float = 0.12


class Following(StrEnum):
    """What the follower is about."""

    DRIVING = "driving"
    BLOCKED = "blocked"
    """An obstacle stands where the next second would lead."""
    ARRIVED = "arrived"


@dataclass(frozen=True)
class Command:
    twist: Twist2D
    following: Following
    remaining_m: float


class Follower:
    """Drives one path. `step` is asked often (20 Hz); it remembers how far along the path the robot is.

    As Nav2's goal checker it is stateful: once within `goal_tolerance_m` of the end it only turns, and it has arrived
    when the heading is within `goal_tolerance_rad`. So it ends short of the goal, by nearly the whole tolerance.
    """

    def __init__(self, path: Path, limits: Limits | None = None) -> None:
        self.path = path
        self._limits = limits or Limits()
        self._index = 0
        self._turning = False
        self._at_goal = False

    def step(self, pose: Pose2D, obstacles_m: NDArray[np.float64]) -> Command:
        """The velocity for now. `pose` is in the map; `obstacles_m` is (N, 2) in the robot's own frame."""
        limits = self._limits
        remaining_m, heading = self._look(pose)
        goal = self.path.points_m[-1]
        to_goal_m = math.hypot(goal[0] - pose.x, goal[1] - pose.y)
        self._at_goal = self._at_goal or to_goal_m < limits.goal_tolerance_m
        if self._at_goal:
            return self._align(pose, remaining_m)
        twist = self._pursue(heading, remaining_m, obstacles_m)
        if blocked(twist, obstacles_m, limits):
            return Command(STILL, Following.BLOCKED, remaining_m)
        return Command(twist, Following.DRIVING, remaining_m)

    def _look(self, pose: Pose2D) -> tuple[float, float]:
        """Metres of path left, and the bearing of the point a lookahead further on, relative to the heading."""
        points, along = self.path.points_m, self.path.along_m
        window = points[self._index : self._index + _WINDOW]
        distances = np.hypot(window[:, 0] - pose.x, window[:, 1] - pose.y)
        nearest = int(distances.argmin())
        self._index += nearest
        ahead_m = float(min(along[self._index] + self._limits.lookahead_m, along[-1]))
        x, y = (float(np.interp(ahead_m, along, points[:, axis])) for axis in (0, 1))
        remaining_m = float(along[-1] - along[self._index] + distances[nearest])
        return remaining_m, wrap(math.atan2(y - pose.y, x - pose.x) - pose.yaw)

    def _pursue(self, heading: float, remaining_m: float, obstacles_m: NDArray[np.float64]) -> Twist2D:
        limits = self._limits
        threshold = limits.turned_rad if self._turning else limits.turn_first_rad
        self._turning = abs(heading) > threshold
        if self._turning:
            return Twist2D(angular_z=_turn(heading, limits))
        curvature = 2.0 * math.sin(heading) / limits.lookahead_m
        speed = limits.speed_m_s
        if abs(curvature) > 1.0 / limits.slow_radius_m:
            speed *= max(1.0 / (abs(curvature) * limits.slow_radius_m), 0.3)
        speed *= min(1.0, max(remaining_m / limits.slow_goal_m, 0.3))
        nearest_m = _nearest_ahead_m(obstacles_m)
        if nearest_m < limits.slow_clearance_m:
            speed *= max(nearest_m / limits.slow_clearance_m, 0.4)
        speed = max(speed, limits.speed_min_m_s)
        return Twist2D(
            linear_x=speed, angular_z=float(np.clip(speed * curvature, -limits.turn_rad_s, limits.turn_rad_s))
        )

    def _align(self, pose: Pose2D, remaining_m: float) -> Command:
        error = wrap(self.path.goal_yaw - pose.yaw)
        if abs(error) < self._limits.goal_tolerance_rad:
            return Command(STILL, Following.ARRIVED, remaining_m)
        return Command(Twist2D(angular_z=_turn(error, self._limits)), Following.DRIVING, remaining_m)


def blocked(twist: Twist2D, obstacles_m: NDArray[np.float64], limits: Limits) -> bool:
    """Would the footprint meet one of `obstacles_m` (N, 2, robot frame) in the next second, nearer than it is now?"""
    near = obstacles_m[np.hypot(*obstacles_m.T) < 1.0] if len(obstacles_m) else obstacles_m
    if twist.linear_x <= 0.0 or not len(near):
        return False  # a round robot may always turn
    far_m = max(twist.linear_x * limits.foresight_s, limits.foresight_min_m)
    s = np.linspace(0.0, far_m, 8)[:, None]
    k = twist.angular_z / twist.linear_x
    x, y = (np.sin(k * s) / k, (1 - np.cos(k * s)) / k) if abs(k) > 1e-3 else (s, np.zeros_like(s))
    clearance_m = np.hypot(near[:, 0] - x, near[:, 1] - y)
    return bool((clearance_m < np.minimum(limits.footprint_m, clearance_m[0] - 0.005))[1:].any())


def _turn(error: float, limits: Limits) -> float:
    speed = min(max(1.8 * abs(error), limits.turn_min_rad_s), limits.turn_rad_s)
    return math.copysign(speed, error)


def _nearest_ahead_m(obstacles_m: NDArray[np.float64]) -> float:
    """Distance to the nearest point in front of or beside the robot's centre, inf where there is none."""
    ahead = obstacles_m[obstacles_m[:, 0] > -0.05] if len(obstacles_m) else obstacles_m
    return float(np.hypot(*ahead.T).min()) if len(ahead) else math.inf
