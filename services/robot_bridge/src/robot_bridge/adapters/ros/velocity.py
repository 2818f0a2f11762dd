"""The one publisher of `cmd_vel`, and the thread that ticks the wheels 20 times a second."""

import threading
import time
from collections.abc import Callable
from typing import Any

import structlog
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node

from contracts.geometry import Twist2D
from robot_bridge.adapters.ros.subscriptions import quality
from robot_bridge.settings import RosSettings

log = structlog.get_logger()

TICK_S = 0.05
END_S_MAX = 2.0


class VelocityPublisher:
    """Publishes from any thread, at once, on every topic that moves this robot."""

    def __init__(self, node: Node, ros: RosSettings) -> None:
        self._node = node
        self._frame = ros.base_frame
        self._stamped = ros.cmd_vel_type == "TwistStamped"
        kind = TwistStamped if self._stamped else Twist
        self._main = node.create_publisher(kind, ros.cmd_vel.name, quality(ros.cmd_vel))
        unstamped = ros.cmd_vel_unstamped
        self._unstamped = node.create_publisher(Twist, unstamped.name, quality(unstamped)) if unstamped else None

    def send(self, twist: Twist2D) -> None:
        plain = Twist()
        plain.linear.x, plain.angular.z = twist.linear_x, twist.angular_z
        message: Any = plain
        if self._stamped:
            message = TwistStamped(twist=plain)
            message.header.stamp = self._node.get_clock().now().to_msg()
            message.header.frame_id = self._frame
        self._main.publish(message)
        if self._unstamped is not None:
            self._unstamped.publish(plain)


class Ticker:
    """Calls `tick` on a steady beat in a thread of its own: neither a busy executor nor a stepped clock delays it.

    A beat that was missed is left out, not caught up with. `on_death` is called when `tick` raises.
    """

    def __init__(self, tick: Callable[[], None], *, period_s: float, on_death: Callable[[], None]) -> None:
        self._tick = tick
        self._period_s = period_s
        self._on_death = on_death
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._live, name="wheels", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        """Returns when the last tick has ended. May be called before `start`."""
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join(END_S_MAX)

    def _live(self) -> None:
        next_s = time.monotonic()
        try:
            while not self._closing.is_set():
                self._tick()
                next_s += self._period_s
                late_s = time.monotonic() - next_s
                if late_s > 0.0:
                    next_s += self._period_s * (late_s // self._period_s + 1.0)
                self._closing.wait(max(0.0, next_s - time.monotonic()))
        finally:
            if not self._closing.is_set():
                log.error("the wheels' thread died; ending the process")
                self._on_death()
