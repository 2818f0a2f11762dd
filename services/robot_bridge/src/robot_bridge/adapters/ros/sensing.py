"""Subscriptions: what the robot publishes becomes the newest value of a sense. Runs in the robot's thread."""

from collections.abc import Callable
from typing import Any, TypeVar

from geometry_msgs.msg import PoseWithCovarianceStamped, Twist, TwistStamped
from irobot_create_msgs.msg import DockStatus, HazardDetectionVector, WheelStatus
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Odometry as OdometryMessage
from prometheus_client import Counter
from rclpy.node import Node
from sensor_msgs.msg import BatteryState, CameraInfo, Image, LaserScan
from tf2_msgs.msg import TFMessage

from mesh.clock import Clock
from robot_bridge.adapters.ros import convert
from robot_bridge.adapters.ros.subscriptions import BestAvailable, quality
from robot_bridge.mailbox import Mailbox
from robot_bridge.senses import Senses
from robot_bridge.settings import Channel, RosSettings
from robot_bridge.transforms import planar

M = TypeVar("M")
V = TypeVar("V")

MALFORMED = Counter("robot_bridge_ros_malformed_total", "ROS messages that made no sense and were dropped", ["topic"])


class Sensing:
    """Fills `senses` from the node's subscriptions."""

    def __init__(
        self,
        node: Node,
        ros: RosSettings,
        senses: Senses,
        clock: Clock,
        *,
        navigation_velocity: Callable[[float, float], None],
        wheels: Callable[[WheelStatus], None],
    ) -> None:
        self._node = node
        self._ros = ros
        self._senses = senses
        self._clock = clock
        self._changing: list[BestAvailable] = []
        senses.frames.set_base(ros.base_frame)
        self._on(TFMessage, ros.tf_static, self._fixed_frames)
        self._on(TFMessage, ros.tf, self._moving_frames)
        self._on(OdometryMessage, ros.odom, self._odometry)
        self._on(LaserScan, ros.scan, self._scan)
        self._on(PoseWithCovarianceStamped, ros.amcl_pose, self._localisation)
        self._on(Image, ros.rgb, self._colour)
        self._on(Image, ros.depth, self._depth)
        self._keep(CameraInfo, ros.rgb_info, senses.rgb_intrinsics, convert.intrinsics)
        self._keep(CameraInfo, ros.depth_info, senses.depth_intrinsics, convert.intrinsics)
        self._keep(OccupancyGrid, ros.map, senses.map, convert.grid)
        self._keep(BatteryState, ros.battery, senses.battery, convert.battery)
        self._keep(DockStatus, ros.dock_status, senses.dock, convert.dock)
        self._keep(HazardDetectionVector, ros.hazards, senses.hazards, convert.hazards)
        self._on(WheelStatus, ros.wheel_status, wheels)
        if ros.cmd_vel_nav_type == "TwistStamped":
            self._on(TwistStamped, ros.cmd_vel_nav, lambda m: navigation_velocity(m.twist.linear.x, m.twist.angular.z))
        else:
            self._on(Twist, ros.cmd_vel_nav, lambda m: navigation_velocity(m.linear.x, m.angular.z))

    def poll(self) -> None:
        """Called every second: what nobody publishes, of the topics that come on change only."""
        unpublished = frozenset(each.name for each in self._changing if not each.poll())
        self._senses.unpublished.put(unpublished, self._clock.now_s())

    def _on(self, kind: type[M], channel: Channel, handle: Callable[[M], None]) -> None:
        malformed = MALFORMED.labels(channel.name)

        def guarded(message: M) -> None:
            try:
                handle(message)
            except (ValueError, OverflowError):  # pydantic's ValidationError is a ValueError
                malformed.inc()

        if "best_available" in {channel.reliability, channel.durability}:
            self._changing.append(BestAvailable(self._node, kind, channel, guarded))
        else:
            self._node.create_subscription(kind, channel.name, guarded, quality(channel))

    def _keep(self, kind: type[Any], channel: Channel, into: Mailbox[V], read: Callable[[Any], V]) -> None:
        self._on(kind, channel, lambda message: into.put(read(message), self._clock.now_s()))

    def _fixed_frames(self, message: TFMessage) -> None:
        for each in message.transforms:
            self._senses.frames.fix(each.header.frame_id, each.child_frame_id, convert.transform(each.transform))

    def _moving_frames(self, message: TFMessage) -> None:
        """The localiser's correction, and joints of the body; odometry comes with its velocity on its own topic."""
        for each in message.transforms:
            parent, child = each.header.frame_id.lstrip("/"), each.child_frame_id.lstrip("/")
            stamp_s, transform = convert.stamp_s(each.header.stamp), convert.transform(each.transform)
            if (parent, child) == (self._ros.map_frame, self._ros.odom_frame):
                now_s = self._clock.now_s()
                self._senses.poses.add_map_to_odom(stamp_s, planar(transform), received_s=now_s)
            elif parent != self._ros.odom_frame:
                self._senses.frames.move(parent, child, stamp_s, transform)

    def _odometry(self, message: OdometryMessage) -> None:
        odometry = convert.odometry(message)
        if _repeated(odometry.stamp_s, self._senses.odometry.value):
            return
        self._senses.poses.add_odometry(odometry.stamp_s, odometry.pose)
        self._senses.odometry.put(odometry, self._clock.now_s())

    def _localisation(self, message: PoseWithCovarianceStamped) -> None:
        stamp_s = convert.stamp_s(message.header.stamp)
        pose = convert.pose(message.pose.pose)
        self._senses.poses.add_localisation(stamp_s, pose, received_s=self._clock.now_s())

    def _scan(self, message: LaserScan) -> None:
        if _repeated(convert.stamp_s(message.header.stamp), self._senses.scan.value):
            return
        mount = self._senses.frames.in_base(message.header.frame_id)
        if mount is None:
            raise ValueError("where the laser is mounted is not known")
        self._senses.scan.put(convert.scan(message, mount), self._clock.now_s())

    def _colour(self, message: Image) -> None:
        if not _repeated(convert.stamp_s(message.header.stamp), self._senses.rgb.value):
            self._senses.rgb.put(convert.colour_image(message), self._clock.now_s())

    def _depth(self, message: Image) -> None:
        if not _repeated(convert.stamp_s(message.header.stamp), self._senses.depth.value):
            image = convert.depth_image(message)
            self._senses.depth_history.add(image)
            self._senses.depth.put(image, self._clock.now_s())


def _repeated(stamp_s: float, last: Any) -> bool:
    """A sensor that sends the same moment again is frozen: it must grow old, not stay fresh."""
    return last is not None and stamp_s == last.stamp_s and stamp_s > 0.0
