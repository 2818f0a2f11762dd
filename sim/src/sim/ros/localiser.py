"""AMCL's part: where the robot is in the map, as it believes; corrections dated ahead, poses on movement only."""

import math
import time

import structlog
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.node import Node
from tf2_msgs.msg import TFMessage

from contracts.geometry import Pose2D
from geometry.poses import compose, inverse
from sim.ros import messages
from sim.ros.quality import REPUBLISHED
from sim.ros.realtime import RealTime
from sim.settings import SimSettings
from sim.world import World

log = structlog.get_logger()

MOVED_M, TURNED_RAD = 0.25, 0.2
"""TurtleBot 4's update_min_d and update_min_a: without so much movement AMCL believes what it believed."""


class Localiser:
    """`turn` and `localise` in the World's thread. With `amcl_initial_pose` off it waits for an initial pose."""

    def __init__(self, node: Node, settings: SimSettings, realtime: RealTime) -> None:
        self._settings = settings
        self._realtime = realtime
        self._map_to_odom = Pose2D(x=0.0, y=0.0, yaw=0.0)
        self._known = settings.amcl_initial_pose
        self._updated_at: Pose2D | None = None
        """In odom; none = the next turn of the laser is looked at, however little the robot has moved."""
        self._amcl = node.create_publisher(PoseWithCovarianceStamped, "amcl_pose", REPUBLISHED)
        self._tf = node.create_publisher(TFMessage, "tf", 100)
        node.create_subscription(PoseWithCovarianceStamped, "initialpose", self._on_initial_pose, 10)

    @property
    def map_to_odom(self) -> Pose2D:
        return self._map_to_odom

    def begin(self, world: World) -> None:
        """Before the first turn of the laser."""
        self.localise(world, time.time_ns())

    def localise(self, world: World, stamp_ns: int) -> None:
        """Looks where it is, where it has moved enough since it last looked."""
        odometry = world.odometry().pose
        if not self._known or not self._has_moved(odometry):
            return
        estimate = world.localization()
        self._updated_at = odometry
        self._map_to_odom = compose(estimate.pose, inverse(odometry))
        self._amcl.publish(messages.amcl_pose(estimate, stamp_ns))

    def turn(self, stamp_ns: int) -> None:
        """With each turn of the laser: the correction, dated so far ahead that it outlives the next turn."""
        if self._known:
            ahead_ns = round(self._settings.amcl_ahead_s * 1e9)
            self._tf.publish(messages.correction(self._map_to_odom, stamp_ns + ahead_ns))

    def _has_moved(self, odometry: Pose2D) -> bool:
        if (last := self._updated_at) is None:
            return True
        turned_rad = math.remainder(odometry.yaw - last.yaw, math.tau)
        return math.hypot(odometry.x - last.x, odometry.y - last.y) >= MOVED_M or abs(turned_rad) >= TURNED_RAD

    def _on_initial_pose(self, message: PoseWithCovarianceStamped) -> None:
        """Takes the pose as the estimate; the localiser then finds back to its own within its next turn."""
        try:
            given = messages.pose2d(message.pose.pose)
        except ValueError:
            log.warning("ignored an initial pose that is none")
            return

        def reset(world: World) -> None:
            self._map_to_odom = compose(given, inverse(world.odometry().pose))
            self._known, self._updated_at = True, None

        self._realtime.call(reset)
        log.info("initial pose taken", x=round(given.x, 2), y=round(given.y, 2), yaw=round(given.yaw, 2))
