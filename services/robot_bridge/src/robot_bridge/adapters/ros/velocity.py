"""The one publisher of `cmd_vel`, and the thread that ticks the wheels 20 times a second."""

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

import structlog
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node

from contracts.geometry import Twist2D
from robot_bridge.adapters.ros.subscriptions import qos_profile
from robot_bridge.settings import Channel, RosSettings

log = structlog.get_logger()

TICK_S = 0.05
END_S_MAX = 2.0
SENT_KEPT = 200
"""Ten seconds of them."""


class VelocityPublisher:
    """Publishes from any thread, at once, on every topic that moves this robot."""

    def __init__(self, node: Node, ros: RosSettings) -> None:
        self._node = node
        self._frame = ros.base_frame
        self._stamped = ros.cmd_vel_type == "TwistStamped"
        kind = TwistStamped if self._stamped else Twist
        self._main = node.create_publisher(kind, ros.cmd_vel.name, qos_profile(ros.cmd_vel))
        unstamped = ros.cmd_vel_unstamped
        self._unstamped = node.create_publisher(Twist, unstamped.name, qos_profile(unstamped)) if unstamped else None
        self.channels: list[tuple[Channel, type[Twist] | type[TwistStamped]]] = [(ros.cmd_vel, kind)]
        """What moves this robot, by topic and type."""
        if unstamped:
            self.channels.append((unstamped, Twist))
        self._lock = threading.Lock()
        self._stamps: deque[tuple[int, int]] = deque(maxlen=SENT_KEPT)
        self._twists: deque[tuple[float, float]] = deque(maxlen=SENT_KEPT)

    def send(self, twist: Twist2D) -> None:
        plain = Twist()
        plain.linear.x, plain.angular.z = twist.linear_x, twist.angular_z
        message: Any = plain
        stamp = self._node.get_clock().now().to_msg()
        if self._stamped:
            message = TwistStamped(twist=plain)
            message.header.stamp = stamp
            message.header.frame_id = self._frame
        with self._lock:
            self._stamps.append((stamp.sec, stamp.nanosec))
            self._twists.append((twist.linear_x, twist.angular_z))
        self._main.publish(message)
        if self._unstamped is not None:
            self._unstamped.publish(plain)

    def has_sent(self, message: Twist | TwistStamped) -> bool:
        """Whether this bridge may have sent it of late: by its stamp, or where it has none by what it says."""
        with self._lock:
            if isinstance(message, TwistStamped):
                return (message.header.stamp.sec, message.header.stamp.nanosec) in self._stamps
            return (message.linear.x, message.angular.z) in self._twists


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
