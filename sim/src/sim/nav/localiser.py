"""A STAND-IN for AMCL: looks where it is only after some movement, and is off by the World's localisation error."""

import math

from contracts.geometry import Pose2D
from geometry.poses import compose, inverse
from sim.world.types import PoseEstimate

MOVED_M, TURNED_RAD = 0.25, 0.2
"""TurtleBot 4's update_min_d and update_min_a: without so much movement AMCL believes what it believed."""


class Localiser:
    """`map_to_odom` is what it believes. One that is not `known` waits for an initial pose."""

    def __init__(self, *, known: bool) -> None:
        self.map_to_odom = Pose2D(x=0.0, y=0.0, yaw=0.0)
        self.known = known
        self._updated_at: Pose2D | None = None
        """In odom; none = the next turn of the laser is looked at, however little the robot has moved."""

    def is_due(self, odometry: Pose2D) -> bool:
        if not self.known:
            return False
        if (last := self._updated_at) is None:
            return True
        turned_rad = math.remainder(odometry.yaw - last.yaw, math.tau)
        return math.hypot(odometry.x - last.x, odometry.y - last.y) >= MOVED_M or abs(turned_rad) >= TURNED_RAD

    def update(self, estimate: PoseEstimate, odometry: Pose2D) -> None:
        self._updated_at = odometry
        self.map_to_odom = compose(estimate.pose, inverse(odometry))

    def take_initial_pose(self, pose: Pose2D, odometry: Pose2D) -> None:
        """The estimate until the next turn of the laser."""
        self.map_to_odom = compose(pose, inverse(odometry))
        self.known, self._updated_at = True, None
