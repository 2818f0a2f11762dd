"""A robot that stands in an empty room and publishes what a bridge needs to let it drive; as light as can be."""

import argparse
import array
import math
import os
from typing import Any

from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Image, LaserScan
from tf2_msgs.msg import TFMessage

from bench.ros_process import run_node

SENSOR = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEAMS, SIDE_PX = 720, 250


class StandingRobot:
    """Scan 7.7 Hz, odometry 20 Hz, and a colour camera at `camera_hz` (0 = none)."""

    def __init__(self, node: Node, camera_hz: float) -> None:
        self._node = node
        publisher = node.create_publisher
        self._scan = publisher(LaserScan, "scan", SENSOR)
        self._odom = publisher(Odometry, "odom", SENSOR)
        self._tf = publisher(TFMessage, "tf", 100)
        self._image = publisher(Image, "oakd/rgb/preview/image_raw", SENSOR)
        self._info = publisher(CameraInfo, "oakd/rgb/preview/camera_info", SENSOR)
        self._static = publisher(TFMessage, "tf_static", KEPT)
        self._static.publish(TFMessage(transforms=[_frame("base_link", "laser"), _frame("base_link", "optical")]))
        self._ranges = array.array("f", [5.0] * BEAMS)
        self._noise = array.array("B", os.urandom(SIDE_PX * SIDE_PX * 3))  # what JPEG finds hardest
        node.create_timer(1.0 / 7.7, self._publish_scan)
        node.create_timer(0.05, self._publish_odometry)
        if camera_hz > 0.0:
            node.create_timer(1.0 / camera_hz, self._publish_image)

    def _now(self) -> Any:
        return self._node.get_clock().now().to_msg()

    def _publish_scan(self) -> None:
        message = LaserScan(angle_min=-math.pi, angle_increment=math.tau / BEAMS, range_min=0.15, range_max=12.0)
        message.angle_max = math.pi
        message.header.stamp, message.header.frame_id = self._now(), "laser"
        message.ranges = self._ranges
        self._scan.publish(message)

    def _publish_odometry(self) -> None:
        now = self._now()
        message = Odometry(child_frame_id="base_link")
        message.header.stamp, message.header.frame_id = now, "odom"
        message.pose.pose.orientation.w = 1.0
        self._odom.publish(message)
        correction = _frame("map", "odom")
        correction.header.stamp = now
        self._tf.publish(TFMessage(transforms=[correction]))

    def _publish_image(self) -> None:
        message = Image(height=SIDE_PX, width=SIDE_PX, encoding="bgr8", step=SIDE_PX * 3)
        message.header.stamp, message.header.frame_id = self._now(), "optical"
        info = CameraInfo(width=SIDE_PX, height=SIDE_PX, k=[200.0, 0.0, 125.0, 0.0, 200.0, 125.0, 0.0, 0.0, 1.0])
        info.header = message.header
        message.data = self._pixels()
        self._image.publish(message)
        self._info.publish(info)

    def _pixels(self) -> "array.array[int]":
        """Of the frame that is published at once."""
        return self._noise


def _frame(parent: str, child: str) -> TransformStamped:
    frame = TransformStamped(child_frame_id=child)
    frame.header.frame_id = parent
    frame.transform.rotation.w = 1.0
    return frame


def run(kind: type[StandingRobot], name: str, about: str | None) -> None:
    """`--camera-hz N`: none unless it is given."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--camera-hz", type=float, default=0.0)
    arguments = parser.parse_args()
    run_node(name, lambda node: kind(node, arguments.camera_hz))


if __name__ == "__main__":
    run(StandingRobot, "standing_robot", __doc__)
