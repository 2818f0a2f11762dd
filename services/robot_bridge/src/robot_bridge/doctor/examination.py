"""Looks at a live ROS graph for the doctor: listens for some seconds as the bridge would, and asks who is there."""

# pyright: reportUnknownArgumentType=false, reportUnknownMemberType=false, reportUnknownVariableType=false

import time
from collections import defaultdict
from collections.abc import Mapping
from typing import Any

import rclpy
from irobot_create_msgs.action import Dock, Undock
from irobot_create_msgs.msg import WheelStatus
from irobot_create_msgs.srv import EStop
from nav2_msgs.action import ComputePathToPose, NavigateToPose
from nav2_msgs.srv import ClearEntireCostmap
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.action.client import ActionClient
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import CameraInfo, LaserScan
from tf2_msgs.msg import TFMessage

from contracts.problem import Readiness
from mesh.clock import SystemClock
from robot_bridge.adapters.ros.graph import TypeWatch
from robot_bridge.adapters.ros.nav2_questions import Nav2Questions
from robot_bridge.adapters.ros.sensing import Sensing
from robot_bridge.adapters.ros.subscriptions import image_type, qos_profile
from robot_bridge.doctor.facts import ROLES, Facts, Publisher, Traffic
from robot_bridge.sensing.sensor_readings import SensorReadings
from robot_bridge.sensing.snapshot import take_snapshot
from robot_bridge.settings import Channel, Settings

NODE = "atom_doctor"
DISCOVERY_S = 2.0
"""So long servers are given to be found before they are asked."""
CLOCK_TOPIC = "/clock"


def examine(settings: Settings, *, seconds: float, environment: Mapping[str, str], bridge: Readiness | None) -> Facts:
    """Blocks for `seconds`. Only listens and asks: nothing of it moves anything."""
    context = Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    ros = settings.ros
    node = Node(NODE, namespace=ros.namespace, context=context, start_parameter_services=False, enable_rosout=False)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    look_round = _Look(node, settings)
    try:
        look_round.listen(executor, seconds)
        return look_round.facts(environment, bridge)
    finally:
        executor.shutdown()
        look_round.close()
        node.destroy_node()
        context.try_shutdown()
        context.destroy()


class _Look:
    """What is heard and asked during one examination."""

    def __init__(self, node: Node, settings: Settings) -> None:
        self._node = node
        self._settings = settings
        self._ros = ros = settings.ros
        self._senses = SensorReadings()
        self._clock = SystemClock()
        self._heard: dict[str, list[tuple[float, int]]] = {role.setting: [] for role in ROLES}
        self._parents: dict[str, set[str]] = defaultdict(set)
        self._scan_frame = ""
        self._wheels_enabled: bool | None = None
        self._sensing = Sensing(
            node, settings, self._senses, self._clock, navigation_velocity=_no_velocity, wheels=self._wheels
        )
        self._nav2 = Nav2Questions(node, ros.nav2_lifecycle_nodes)
        self._actions = {
            name: ActionClient(node, kind, name)
            for name, kind in (
                (ros.navigate_action, NavigateToPose), (ros.path_action, ComputePathToPose),
                (ros.dock_action, Dock), (ros.undock_action, Undock),
            )
        }  # fmt: skip
        self._types = TypeWatch(node, tuple(self._actions), self._senses.mismatches, self._clock)
        self._services = {ros.e_stop_service: node.create_client(EStop, ros.e_stop_service)} | {
            name: node.create_client(ClearEntireCostmap, name) for name in ros.clear_costmap_services
        }
        self._count("odom", Odometry)
        self._count("rgb", image_type(ros.rgb))
        self._count("depth", image_type(ros.depth))
        self._count("rgb_info", CameraInfo)
        self._count("depth_info", CameraInfo)
        self._count("map", OccupancyGrid)
        self._on("scan", LaserScan, self._scanned)
        self._on("tf", TFMessage, self._edges)
        self._on("tf_static", TFMessage, self._edges)

    def listen(self, executor: SingleThreadedExecutor, seconds: float) -> None:
        started_s, asked = time.monotonic(), False
        while (elapsed_s := time.monotonic() - started_s) < seconds:
            executor.spin_once(timeout_sec=0.1)
            if elapsed_s <= min(DISCOVERY_S, seconds / 2.0):
                continue
            self._nav2.ask()
            if not asked:
                asked = True
                self._sensing.poll()  # from here on what is kept is asked for as kept

    def facts(self, environment: Mapping[str, str], bridge: Readiness | None) -> Facts:
        self._sensing.poll()
        self._types.poll()
        now_s, senses = self._clock.now_s(), self._senses
        topics = {name: tuple(types) for name, types in self._node.get_topic_names_and_types()}
        published = {name: found for name in topics if (found := self._publishers(name))}
        names = {role.setting: self._resolved(role.setting) for role in ROLES} | {"cmd_vel": self._resolved("cmd_vel")}
        grid, dock = senses.map.value, senses.dock.value
        return Facts(
            ros=self._ros,
            topics={name: topics[name] for name in published},
            names=names,
            publishers=published,
            mismatches=senses.mismatches.value or (),
            base_listens_for=self._listened_for(names["cmd_vel"]),
            traffic={setting: _traffic(heard) for setting, heard in self._heard.items()},
            sensors=take_snapshot(senses, self._settings, now_s).sensors,
            clocks_behind_s=senses.clocks.odd(now_s),
            parents={child: frozenset(parents) for child, parents in self._parents.items()},
            frames=self._frames(),
            lifecycle=self._nav2.lifecycle,
            servers={name: client.server_is_ready() for name, client in self._actions.items()}
            | {name: client.service_is_ready() for name, client in self._services.items()},
            parameters=self._nav2.parameters,
            wheels_enabled=self._wheels_enabled,
            docked=dock.is_docked if dock is not None else None,
            free_area_m2=grid.free_area_m2 if grid is not None else None,
            sim_time_published=CLOCK_TOPIC in published,
            environment=environment,
            bridge=bridge,
        )

    def close(self) -> None:
        for client in self._actions.values():
            client.destroy()

    def _channel(self, setting: str) -> Channel:
        channel: Channel = getattr(self._ros, setting)
        return channel

    def _resolved(self, setting: str) -> str:
        return self._node.resolve_topic_name(self._channel(setting).name)

    def _on(self, setting: str, kind: type[Any], heard: Any) -> None:
        channel = self._channel(setting)
        self._node.create_subscription(kind, channel.name, heard, qos_profile(channel))

    def _count(self, setting: str, kind: type[Any]) -> None:
        """Unread: only how often, and how large."""

        def heard(data: Any) -> None:
            self._note(setting, len(data))

        channel = self._channel(setting)
        self._node.create_subscription(kind, channel.name, heard, qos_profile(channel), raw=True)

    def _note(self, setting: str, size: int) -> None:
        self._heard[setting].append((time.monotonic(), size))

    def _scanned(self, message: LaserScan) -> None:
        self._scan_frame = message.header.frame_id
        self._note("scan", 0)

    def _edges(self, message: TFMessage) -> None:
        self._note("tf", 0)
        self._note("tf_static", 0)
        for each in message.transforms:
            self._parents[each.child_frame_id.lstrip("/")].add(each.header.frame_id.lstrip("/"))

    def _wheels(self, message: WheelStatus) -> None:
        self._wheels_enabled = bool(message.wheels_enabled)

    def _frames(self) -> dict[str, str]:
        images = {"rgb": self._senses.rgb.value, "depth": self._senses.depth.value}
        named = {sensor: image.frame_id.lstrip("/") for sensor, image in images.items() if image is not None}
        return named | ({"scan": self._scan_frame.lstrip("/")} if self._heard["scan"] else {})

    def _publishers(self, topic: str) -> tuple[Publisher, ...]:
        return tuple(
            Publisher(
                info.node_name,
                info.topic_type,
                reliable=info.qos_profile.reliability == ReliabilityPolicy.RELIABLE,
                transient_local=info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL,
            )
            for info in self._node.get_publishers_info_by_topic(topic)
            if info.node_name != NODE
        )

    def _listened_for(self, topic: str) -> tuple[str, ...]:
        """The types with which others listen to it; a bridge listens there itself, to hear strangers."""
        own = {NODE, self._ros.node_name}
        listeners = self._node.get_subscriptions_info_by_topic(topic)
        return tuple(info.topic_type for info in listeners if info.node_name not in own)


def _traffic(heard: list[tuple[float, int]]) -> Traffic:
    """Over the time between the first message and the last."""
    if len(heard) < 2:
        return Traffic(len(heard))
    span_s = max(1e-3, heard[-1][0] - heard[0][0])
    return Traffic(len(heard), (len(heard) - 1) / span_s, sum(size for _, size in heard[1:]) / span_s)


def _no_velocity(linear_x: float, angular_z: float) -> None:
    """The doctor drives nothing."""
