"""A faulty wire between the robot's sensors and the bridge: each topic goes on as `wire/<topic>`, or as it is told.

Reads lines from stdin, `<topic> <mode>`: `pass`, `cut` (nothing comes), `freeze` (the last message again and again) or
`spoil` (sent on, but senseless). Answers each with the same line.
"""

import os
import signal
import sys
import threading
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Image, LaserScan

from bench.ros_process import run_node

SENSOR = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
NAN = float("nan")


def nan_ranges(message: LaserScan) -> None:
    message.ranges = [NAN] * len(message.ranges)


def no_position(message: Odometry) -> None:
    message.pose.pose.position.x = message.twist.twist.linear.x = NAN


def no_pixels(message: Image) -> None:
    message.width = message.height = message.step = 0
    message.data = b""


def no_focal_length(message: CameraInfo) -> None:
    message.k = [0.0] * 9


def no_velocity(message: TwistStamped) -> None:
    message.twist.linear.x = NAN


TOPICS: dict[str, tuple[type, Callable[[Any], None]]] = {
    "scan": (LaserScan, nan_ranges),
    "odom": (Odometry, no_position),
    "oakd/rgb/preview/image_raw": (Image, no_pixels),
    "oakd/rgb/preview/camera_info": (CameraInfo, no_focal_length),
    "oakd/stereo/image_raw": (Image, no_pixels),
    "oakd/stereo/camera_info": (CameraInfo, no_focal_length),
    "cmd_vel_nav": (TwistStamped, no_velocity),
}


class Strand:
    """One topic through the wire."""

    def __init__(self, node: Node, topic: str, kind: type, spoil: Callable[[Any], None]) -> None:
        self.mode = "pass"
        self._spoil = spoil
        self._last: Any = None
        self._out = node.create_publisher(kind, f"wire/{topic}", SENSOR if topic != "cmd_vel_nav" else 1)
        node.create_subscription(kind, topic, self._heard, SENSOR if topic != "cmd_vel_nav" else 1)

    def _heard(self, message: Any) -> None:
        if self.mode == "cut":
            return
        if self.mode == "freeze":
            message = self._last if self._last is not None else message
        elif self.mode == "spoil":
            self._spoil(message)
        if self.mode in {"pass", "freeze"}:
            self._last = message
        self._out.publish(message)


def obey(strands: dict[str, Strand]) -> None:
    for line in sys.stdin:
        topic, mode = line.split()
        strands[topic].mode = mode
        sys.stdout.write(line)
        sys.stdout.flush()
    os.kill(os.getpid(), signal.SIGTERM)


def wire(node: Node) -> dict[str, Strand]:
    strands = {topic: Strand(node, topic, kind, spoil) for topic, (kind, spoil) in TOPICS.items()}
    threading.Thread(target=obey, args=(strands,), daemon=True).start()
    return strands


if __name__ == "__main__":
    run_node("wire", wire)
