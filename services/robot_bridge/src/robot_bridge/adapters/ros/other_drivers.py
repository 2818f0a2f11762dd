"""Who else can drive the base: publishers of `cmd_vel` beside this bridge, and what they send."""

from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node

from mesh.clock import Clock
from robot_bridge.adapters.ros.subscriptions import qos_profile
from robot_bridge.adapters.ros.velocity import VelocityPublisher
from robot_bridge.sensing.sensor_readings import SensorReadings
from robot_bridge.settings import Channel


class OtherDrivers:
    """Lives in the robot's thread; listens to `cmd_vel` only while somebody else publishes there."""

    def __init__(self, node: Node, velocity: VelocityPublisher, senses: SensorReadings, clock: Clock) -> None:
        self._node = node
        self._velocity = velocity
        self._senses = senses
        self._clock = clock
        self._listening: list[Any] = []

    def poll(self) -> None:
        """Called every second."""
        names = sorted({name for channel, _ in self._velocity.channels for name in self._others(channel)})
        self._senses.other_drivers.put(tuple(names), self._clock.now_s())
        if names and not self._listening:
            self._listening = [
                self._node.create_subscription(kind, channel.name, self._heard, qos_profile(channel))
                for channel, kind in self._velocity.channels
            ]
        elif not names:
            while self._listening:
                self._node.destroy_subscription(self._listening.pop())

    def _others(self, channel: Channel) -> list[str]:
        """Nodes that publish it, one of this bridge's name left out: that is this bridge."""
        topic = self._node.resolve_topic_name(channel.name)
        own = self._node.get_name()
        names = [info.node_name for info in self._node.get_publishers_info_by_topic(topic)]
        if own in names:
            names.remove(own)
        return names

    def _heard(self, message: Twist | TwistStamped) -> None:
        twist = message.twist if isinstance(message, TwistStamped) else message
        moves = twist.linear.x != 0.0 or twist.angular.z != 0.0
        if moves and not self._velocity.has_sent(message):
            self._senses.foreign_velocity.put((twist.linear.x, twist.angular.z), self._clock.now_s())
