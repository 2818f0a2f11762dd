"""What the doctor has seen of a ROS graph, as plain values. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from contracts.problem import Readiness
from contracts.robot import SensorStatus
from robot_bridge.sensing.endpoints import Mismatch
from robot_bridge.settings import Channel, RosSettings


class Need(StrEnum):
    """How much the bridge needs a topic."""

    REQUIRED = "required"
    """Without it `/ready` is false."""
    ON_CHANGE = "on_change"
    """It speaks on change only: that it is published is all there is to see."""
    ASKED = "asked"
    """It speaks while something moves."""


@dataclass(frozen=True, slots=True)
class Role:
    """A topic the bridge listens to: the name of its setting, its type, its sensor in `/state` ('' = none)."""

    setting: str
    type: str
    need: Need = Need.REQUIRED
    sensor: str = ""
    hz_min: float = 0.0
    """Slower than this it is of little use."""
    bytes_s_max: float = 0.0
    """More than this a robot's Wi-Fi does not carry; 0 = never much."""


PICTURE = "sensor_msgs/msg/Image"
WIFI_BYTES_S_MAX = 10e6

ROLES = (
    Role("scan", "sensor_msgs/msg/LaserScan", sensor="scan", hz_min=4.0),
    Role("odom", "nav_msgs/msg/Odometry", sensor="odom", hz_min=8.0),
    Role("rgb", PICTURE, sensor="rgb", hz_min=1.5, bytes_s_max=WIFI_BYTES_S_MAX),
    Role("rgb_info", "sensor_msgs/msg/CameraInfo", sensor="rgb_info"),
    Role("depth", PICTURE, sensor="depth", hz_min=1.0, bytes_s_max=WIFI_BYTES_S_MAX),
    Role("depth_info", "sensor_msgs/msg/CameraInfo", sensor="depth_info"),
    Role("map", "nav_msgs/msg/OccupancyGrid", sensor="map"),
    Role("tf", "tf2_msgs/msg/TFMessage"),
    Role("tf_static", "tf2_msgs/msg/TFMessage"),
    Role("battery", "sensor_msgs/msg/BatteryState", Need.ON_CHANGE, sensor="battery"),
    Role("dock_status", "irobot_create_msgs/msg/DockStatus", Need.ON_CHANGE, sensor="dock"),
    Role("hazards", "irobot_create_msgs/msg/HazardDetectionVector", Need.ON_CHANGE, sensor="hazards"),
    Role("wheel_status", "irobot_create_msgs/msg/WheelStatus", Need.ON_CHANGE),
    Role("cmd_vel_nav", "", Need.ASKED),
)


def type_of(role: Role, ros: RosSettings) -> str:
    """The type the bridge subscribes with; of some it is a setting, or in the name."""
    if role.setting == "cmd_vel_nav":
        return f"geometry_msgs/msg/{ros.cmd_vel_nav_type}"
    channel: Channel = getattr(ros, role.setting)
    if role.type == PICTURE and channel.name.endswith(("/compressed", "/compressedDepth")):
        return "sensor_msgs/msg/CompressedImage"
    return role.type


@dataclass(frozen=True, slots=True)
class Publisher:
    """Who publishes a topic, of which type, in which quality of service."""

    node: str
    type: str
    reliable: bool = True
    transient_local: bool = False


@dataclass(frozen=True, slots=True)
class Traffic:
    """What came on a topic while the doctor listened."""

    messages: int = 0
    hz: float = 0.0
    bytes_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Facts:
    """Topic names are as resolved ('/robot1/scan'); by setting where the bridge has one."""

    ros: RosSettings
    topics: Mapping[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]])
    """Every topic that somebody publishes, with its types."""
    names: Mapping[str, str] = field(default_factory=dict[str, str])
    """The resolved topic of each setting."""
    publishers: Mapping[str, tuple[Publisher, ...]] = field(default_factory=dict[str, tuple[Publisher, ...]])
    mismatches: tuple[Mismatch, ...] = ()
    """Who is on one of the bridge's topics with another type, or another definition of it."""
    base_listens_for: tuple[str, ...] = ()
    """The types with which somebody listens to cmd_vel."""
    traffic: Mapping[str, Traffic] = field(default_factory=dict[str, Traffic])
    """By setting."""
    sensors: Mapping[str, SensorStatus] = field(default_factory=dict[str, SensorStatus])
    clocks_behind_s: Mapping[str, float] = field(default_factory=dict[str, float])
    """Those that do not agree with most."""
    parents: Mapping[str, frozenset[str]] = field(default_factory=dict[str, frozenset[str]])
    """Of each frame in tf."""
    frames: Mapping[str, str] = field(default_factory=dict[str, str])
    """The frame that each sensor's messages name."""
    lifecycle: Mapping[str, str] = field(default_factory=dict[str, str])
    """The state of each of Nav2's nodes; '' where it does not answer."""
    servers: Mapping[str, bool] = field(default_factory=dict[str, bool])
    """Actions and services by name: is a server there?"""
    parameters: Mapping[str, float] = field(default_factory=dict[str, float])
    """Nav2's, 'node.name', where it answers."""
    wheels_enabled: bool | None = None
    docked: bool | None = None
    free_area_m2: float | None = None
    sim_time_published: bool = False
    environment: Mapping[str, str] = field(default_factory=dict[str, str])
    bridge: Readiness | None = None
    """What a running robot_bridge says of itself; none where none answers."""
