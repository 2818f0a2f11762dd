"""Quality of service: as a channel says, or the best that whoever publishes the topic offers."""

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CompressedImage, Image

from robot_bridge.recording.ros_topics import image_type_name
from robot_bridge.settings import Channel

_RELIABLE = {"reliable": ReliabilityPolicy.RELIABLE, "best_effort": ReliabilityPolicy.BEST_EFFORT}
_DURABLE = {"transient_local": DurabilityPolicy.TRANSIENT_LOCAL, "volatile": DurabilityPolicy.VOLATILE}


def qos_profile(channel: Channel) -> QoSProfile:
    """What every publisher can serve where the channel asks for the best there is."""
    return QoSProfile(
        depth=channel.depth,
        reliability=_RELIABLE.get(channel.reliability, ReliabilityPolicy.BEST_EFFORT),
        durability=_DURABLE.get(channel.durability, DurabilityPolicy.VOLATILE),
    )


def image_type(channel: Channel) -> type[Image] | type[CompressedImage]:
    """By the topic's name, as image_transport gives it."""
    return CompressedImage if image_type_name(channel).endswith("CompressedImage") else Image


def best_offered(node: Node, channel: Channel) -> QoSProfile | None:
    """What the channel asks for, as good as all its publishers of now offer it: asking for more would silence one of
    them. None without a publisher."""
    topic = node.resolve_topic_name(channel.name)
    publishers = [info.qos_profile for info in node.get_publishers_info_by_topic(topic)]
    if not publishers:
        return None
    best = qos_profile(channel)
    if channel.reliability == "best_available" and all(
        each.reliability == ReliabilityPolicy.RELIABLE for each in publishers
    ):
        best.reliability = ReliabilityPolicy.RELIABLE
    if channel.durability == "best_available" and all(
        each.durability == DurabilityPolicy.TRANSIENT_LOCAL for each in publishers
    ):
        best.durability = DurabilityPolicy.TRANSIENT_LOCAL
    return best


class BestAvailable:
    """One subscription, made anew when its publishers offer more or less than before; in the node's own thread.

    rmw's own "best available" is decided once, when the subscription is made; publishers come later.
    """

    def __init__(self, node: Node, kind: type[Any], channel: Channel, heard: Callable[[Any], None]) -> None:
        self._node = node
        self._kind = kind
        self._channel = channel
        self._heard = heard
        self._quality = qos_profile(channel)
        self._subscription = self._subscribe()

    @property
    def name(self) -> str:
        return self._channel.name

    def poll(self) -> bool:
        """Called every second. Whether anybody publishes it."""
        offered = best_offered(self._node, self._channel)
        if offered is not None and offered != self._quality:
            self._node.destroy_subscription(self._subscription)
            self._quality = offered
            self._subscription = self._subscribe()
        return offered is not None

    def _subscribe(self) -> Any:
        return self._node.create_subscription(self._kind, self._channel.name, self._heard, self._quality)
