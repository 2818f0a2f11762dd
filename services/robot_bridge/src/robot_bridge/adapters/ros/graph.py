"""Reads the ROS graph for who does not speak in the bridge's types, in the robot's thread."""

from typing import Any

import structlog
from rclpy.node import Node

from mesh.clock import Clock
from mesh.latest_value import LatestValue
from robot_bridge.sensing.endpoints import Endpoint, Mismatch, in_words, mismatches

log = structlog.get_logger()


class TypeWatch:
    """Looks at every topic that the node subscribes to, the feedback of `actions` among them, or publishes."""

    def __init__(
        self, node: Node, actions: tuple[str, ...], found: LatestValue[tuple[Mismatch, ...]], clock: Clock
    ) -> None:
        self._node = node
        self._feedback = [node.resolve_topic_name(f"{action}/_action/feedback") for action in actions]
        self._found = found
        self._clock = clock

    def poll(self) -> None:
        node = self._node
        heard = sorted({*(each.topic_name for each in node.subscriptions), *self._feedback})
        said = sorted({each.topic_name for each in node.publishers if not each.topic_name.endswith("parameter_events")})
        wrong: list[Mismatch] = []
        for topics, mine, theirs in (
            (heard, node.get_subscriptions_info_by_topic, node.get_publishers_info_by_topic),
            (said, node.get_publishers_info_by_topic, node.get_subscriptions_info_by_topic),
        ):
            for topic in topics:
                ours = next((_endpoint(topic, each) for each in mine(topic) if self._is_me(each)), None)
                if ours is not None:
                    others = [_endpoint(topic, each) for each in theirs(topic) if not self._is_me(each)]
                    wrong += mismatches(ours, others)
        self._tell(tuple(wrong))

    def _tell(self, wrong: tuple[Mismatch, ...]) -> None:
        for each in wrong:
            if each not in (self._found.value or ()):
                log.warning("somebody speaks in another type", what=in_words(each))
        self._found.put(wrong, self._clock.now_s())

    def _is_me(self, info: Any) -> bool:
        return bool((info.node_name, info.node_namespace) == (self._node.get_name(), self._node.get_namespace()))


def _endpoint(topic: str, info: Any) -> Endpoint:
    return Endpoint(topic, str(info.node_name), str(info.topic_type), _version(info.topic_type_hash))


def _version(type_hash: Any) -> str:
    """'' where the middleware tells none: a version of -1, or a value of zeros."""
    return str(type_hash) if type_hash.version > 0 and any(type_hash.value) else ""
