"""ROS topics as they come over the wire, for a recording; and the definitions that let others read them."""

import os
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped, Twist, TwistStamped
from irobot_create_msgs.msg import DockStatus, HazardDetectionVector, WheelStatus
from mcap.well_known import MessageEncoding, SchemaEncoding
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.node import Node
from sensor_msgs.msg import BatteryState, CameraInfo, LaserScan
from tf2_msgs.msg import TFMessage

from robot_bridge.adapters.ros.subscriptions import best_offered, image_type, qos_profile
from robot_bridge.ports import Kind, Raw, Sink
from robot_bridge.settings import Channel, RosSettings

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
        self._subscriptions = [
            self._subscribe(type_, channel, sink, rate_hz=rate_hz)
            for type_, channel, rate_hz in _topics(ros, images_hz)
        ]

    def close(self) -> None:
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        self._subscriptions = []

    def _subscribe(self, type_: type[Any], channel: Channel, sink: Sink, *, rate_hz: float) -> Any:
        name = f"{type_.__module__.split('.')[0]}/msg/{type_.__name__}"
        kind = Kind(name, MessageEncoding.CDR, SchemaEncoding.ROS2, definition(name).encode())
        topic = self._node.resolve_topic_name(channel.name)
        heard = _throttled(topic, kind, sink, period_s=1.0 / rate_hz if rate_hz > 0.0 else 0.0)
        offered = best_offered(self._node, channel) or qos_profile(channel)  # what was told on change, before it began
        return self._node.create_subscription(type_, channel.name, heard, offered, raw=True)


def _throttled(topic: str, kind: Kind, sink: Sink, *, period_s: float) -> Callable[[bytes], None]:
    last_s = float("-inf")

    def heard(data: bytes) -> None:
        nonlocal last_s
        now_s = time.monotonic()
        if now_s - last_s >= period_s:
            last_s = now_s
            sink(Raw(topic, kind, time.time_ns(), data))

    return heard


def _topics(ros: RosSettings, images_hz: float) -> list[tuple[type[Any], Channel, float]]:
    """Type, channel, and at most how often a second (0 = all of them)."""
    stamped = {"Twist": Twist, "TwistStamped": TwistStamped}
    found: list[tuple[type[Any], Channel, float]] = [
        (TFMessage, ros.tf, 0.0),
        (TFMessage, ros.tf_static, 0.0),
        (Odometry, ros.odom, 0.0),
        (LaserScan, ros.scan, 0.0),
        (PoseWithCovarianceStamped, ros.amcl_pose, 0.0),
        (OccupancyGrid, ros.map, 0.0),
        (BatteryState, ros.battery, 0.0),
        (DockStatus, ros.dock_status, 0.0),
        (HazardDetectionVector, ros.hazards, 0.0),
        (WheelStatus, ros.wheel_status, 0.0),
        (stamped[ros.cmd_vel_type], ros.cmd_vel, 0.0),
        (stamped[ros.cmd_vel_nav_type], ros.cmd_vel_nav, 0.0),
        (CameraInfo, ros.rgb_info, 1.0),
        (CameraInfo, ros.depth_info, 1.0),
    ]
    if images_hz > 0.0:
        found += [(image_type(channel), channel, images_hz) for channel in (ros.rgb, ros.depth)]
    return found


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
