"""AMCL's part: where the robot is in the map, as it believes; corrections dated ahead, poses on movement only."""

import time

import structlog
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.node import Node
from tf2_msgs.msg import TFMessage

from contracts.geometry import Pose2D
from sim.nav.localiser import Localiser
from sim.ros import messages
from sim.ros.quality import REPUBLISHED
from sim.ros.realtime import RealTime
from sim.settings import SimSettings
from sim.world import World

log = structlog.get_logger()


class LocaliserInterface:
    """`turn` and `localise` in the World's thread. With `amcl_initial_pose` off it waits for an initial pose."""

    def __init__(self, node: Node, settings: SimSettings, realtime: RealTime) -> None:
        self._settings = settings
        self._realtime = realtime
        self._localiser = Localiser(known=settings.amcl_initial_pose)
        self._amcl = node.create_publisher(PoseWithCovarianceStamped, "amcl_pose", REPUBLISHED)
        self._tf = node.create_publisher(TFMessage, "tf", 100)
        node.create_subscription(PoseWithCovarianceStamped, "initialpose", self._on_initial_pose, 10)

    @property
    def map_to_odom(self) -> Pose2D:
        return self._localiser.map_to_odom

    def begin(self, world: World) -> None:
        """Before the first turn of the laser."""
        self.localise(world, time.time_ns())

    def localise(self, world: World, stamp_ns: int) -> None:
        """Looks where it is, where it has moved enough since it last looked."""
        odometry = world.odometry().pose
        if not self._localiser.is_due(odometry):
            return
        estimate = world.localization()
        self._localiser.update(estimate, odometry)
        self._amcl.publish(messages.amcl_pose(estimate, stamp_ns))

    def turn(self, stamp_ns: int) -> None:
        """With each turn of the laser: the correction, dated so far ahead that it outlives the next turn."""
        if self._localiser.known:
            ahead_ns = round(self._settings.amcl_ahead_s * 1e9)
            self._tf.publish(messages.correction(self.map_to_odom, stamp_ns + ahead_ns))

    def _on_initial_pose(self, message: PoseWithCovarianceStamped) -> None:
        """Takes the pose as the estimate; the localiser then finds back to its own within its next turn."""
        try:
            given = messages.pose2d(message.pose.pose)
        except ValueError:
            log.warning("ignored an initial pose that is none")
            return

        self._realtime.call(lambda world: self._localiser.take_initial_pose(given, world.odometry().pose))
        log.info("initial pose taken", x=round(given.x, 2), y=round(given.y, 2), yaw=round(given.yaw, 2))
