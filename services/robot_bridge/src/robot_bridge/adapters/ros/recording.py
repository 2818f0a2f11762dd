"""ROS topics as they come over the wire, for a recording; and the definitions that let others read them."""

import importlib
import os
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mcap.well_known import MessageEncoding, SchemaEncoding
from rclpy.node import Node

from robot_bridge.adapters.ros.subscriptions import best_offered, qos_profile
from robot_bridge.ports import Kind, Raw, Sink
from robot_bridge.recording.ros_topics import RosTopic, ros_topics
from robot_bridge.settings import RosSettings

PRIMITIVES = frozenset({
    "bool", "byte", "char", "float32", "float64", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64",
    "uint64", "string", "wstring",
})  # fmt: skip
FIELD = re.compile(r"^\s*([A-Za-z0-9_/]+)(?:<=\d+)?(?:\[[^\]]*\])?\s+[A-Za-z]")
SEPARATOR = "=" * 80


class RosRecording:
    """Subscriptions of their own beside the bridge's. Opened and closed in the robot's thread."""

    def __init__(self, node: Node, ros: RosSettings, sink: Sink, *, images_hz: float) -> None:
        self._node = node
        self._subscriptions = [self._subscribe(topic, sink) for topic in ros_topics(ros, images_hz)]

    def close(self) -> None:
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        self._subscriptions = []

    def _subscribe(self, wanted: RosTopic, sink: Sink) -> Any:
        channel = wanted.channel
        text = definition(wanted.type_name).encode()
        kind = Kind(wanted.type_name, MessageEncoding.CDR, SchemaEncoding.ROS2, text)
        topic = self._node.resolve_topic_name(channel.name)
        heard = _throttled(topic, kind, sink, period_s=1.0 / wanted.rate_hz if wanted.rate_hz > 0.0 else 0.0)
        offered = best_offered(self._node, channel) or qos_profile(channel)  # where it is known by now
        return self._node.create_subscription(_class(wanted.type_name), channel.name, heard, offered, raw=True)


def _class(type_name: str) -> type[Any]:
    package, _, name = type_name.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def _throttled(topic: str, kind: Kind, sink: Sink, *, period_s: float) -> Callable[[bytes], None]:
    last_s = float("-inf")

    def heard(data: bytes) -> None:
        nonlocal last_s
        now_s = time.monotonic()
        if now_s - last_s >= period_s:
            last_s = now_s
            sink(Raw(topic, kind, time.time_ns(), data))

    return heard


def definition(type_name: str) -> str:
    """The .msg text of `package/msg/Type` and, after it, of everything it is made of; raises `OSError`."""
    texts = {_short(type_name): _text(type_name)}
    waiting = [_short(type_name)]
    while waiting:
        package = waiting[0].split("/")[0]
        for needed in _made_of(texts[waiting.pop(0)], package):
            if needed not in texts:
                texts[needed] = _text(needed)
                waiting.append(needed)
    (_, first), *others = texts.items()
    return "\n".join([first, *(f"{SEPARATOR}\nMSG: {name}\n{text}" for name, text in others)])


def _short(type_name: str) -> str:
    package, *_, name = type_name.split("/")
    return f"{package}/{name}"


def _made_of(text: str, package: str) -> list[str]:
    """Types of the fields that are messages themselves, as package/Type."""
    found: list[str] = []
    for line in text.splitlines():
        field = FIELD.match(line.partition("#")[0])
        if field is None or field[1] in PRIMITIVES:
            continue
        found.append(_short(field[1]) if "/" in field[1] else f"{package}/{field[1]}")
    return found


def _text(type_name: str) -> str:
    """As it lies in the share folder of a sourced ROS or of the wheels."""
    package, *_, name = type_name.split("/")
    prefixes = [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    tried = [Path(prefix) / "share" / package / "msg" / f"{name}.msg" for prefix in prefixes if prefix]
    found = next((path for path in tried if path.is_file()), tried[-1])
    return found.read_text()
