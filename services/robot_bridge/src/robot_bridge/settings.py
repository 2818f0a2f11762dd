"""Settings from the environment, prefix ROBOT_BRIDGE_; the numbers of each part stand in its own module."""

from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field
from pydantic_settings import SettingsConfigDict

from contracts.motion import MotionGains
from mesh.settings import Port, ServiceSettings
from robot_bridge.arm.arm_service import ArmLimits
from robot_bridge.motion.motions import GAINS
from robot_bridge.motion.velocity_mux import VelocityLimits
from robot_bridge.navigation.docking import DockingLimits
from robot_bridge.navigation.goal_executor import GoalLimits
from robot_bridge.recording.recordings import RecordingLimits
from robot_bridge.safety.obstacles import ObstacleLimits
from robot_bridge.sensing.laser_rules import LaserRules
from robot_bridge.sensing.object_localizer import LocalizerLimits


class Channel(BaseModel):
    """A ROS topic and its quality of service."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    reliability: Literal["reliable", "best_effort", "best_available"] = "best_effort"
    durability: Literal["volatile", "transient_local", "best_available"] = "volatile"
    depth: int = Field(default=5, ge=1, le=1000)


def _sensor(name: str, what: str, depth: int = 5) -> Any:
    return _field(Channel(name=name, depth=depth), what)


def _kept(name: str, what: str, depth: int = 1) -> Any:
    return _field(Channel(name=name, reliability="reliable", durability="transient_local", depth=depth), what)


def _changing(name: str, what: str) -> Any:
    """Told on change only: the last word counts, also one said before the bridge began."""
    return _field(Channel(name=name, reliability="best_available", durability="best_available"), what)


def _reliable(name: str, what: str, depth: int = 10) -> Any:
    return _field(Channel(name=name, reliability="reliable", depth=depth), what)


def _field(channel: Channel, what: str) -> Any:
    return Field(default=channel, description=f"{what}; a topic with its QoS")


class RosSettings(BaseModel):
    """Names, types and quality of service on the ROS side; relative names live in `namespace`."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    node_name: str = Field(default="robot_bridge", description="of the bridge's own node")
    namespace: str = Field(default="", description="of the robot: topics, actions, services, tf")
    use_sim_time: bool = Field(default=False, description="time from /clock")
    map_frame: str = Field(default="map", description="frame of the map")
    odom_frame: str = Field(default="odom", description="frame of the odometry")
    base_frame: str = Field(default="base_link", description="frame of the robot")

    rgb: Channel = _sensor("oakd/rgb/preview/image_raw", "colour picture", 1)
    rgb_info: Channel = _sensor("oakd/rgb/preview/camera_info", "calibration of the colour camera", 1)
    depth: Channel = _sensor("oakd/stereo/image_raw", "depth picture", 1)
    depth_info: Channel = _sensor("oakd/stereo/camera_info", "calibration of the depth camera", 1)
    scan: Channel = _sensor("scan", "laser scan")
    odom: Channel = _sensor("odom", "odometry")
    amcl_pose: Channel = _kept("amcl_pose", "pose in map from the localiser")
    initial_pose: Channel = _reliable("initialpose", "pose in map for the localiser")
    map: Channel = _kept("map", "occupancy grid")
    plan: Channel = _reliable("plan", "path that Nav2 planned, for recordings")
    rosout: Channel = _kept("/rosout", "log lines of every node, for recordings", 100)
    tf: Channel = _reliable("tf", "moving frames", 100)
    tf_static: Channel = _kept("tf_static", "fixed frames", 100)
    battery: Channel = _changing("battery_state", "battery")
    dock_status: Channel = _changing("dock_status", "whether it is docked")
    hazards: Channel = _changing("hazard_detection", "bump, cliff, stall, wheel drop")
    wheel_status: Channel = _changing("wheel_status", "whether the base lets its wheels turn")
    cmd_vel_nav: Channel = _reliable("cmd_vel_nav", "velocity that Nav2 wants", 1)
    cmd_vel_nav_type: Literal["Twist", "TwistStamped"] = Field(default="TwistStamped", description="of Nav2's velocity")
    cmd_vel: Channel = _reliable("cmd_vel", "velocity for the base")
    cmd_vel_type: Literal["Twist", "TwistStamped"] = Field(default="TwistStamped", description="that the base takes")
    cmd_vel_known: tuple[str, ...] = Field(
        default=("docking_server", "teleop_twist_joy_node"),
        description="nodes that publish cmd_vel too and are known to keep silent: Nav2's docking, an unpaired joystick",
    )
    cmd_vel_unstamped: Channel | None = Field(default=None, description="a second topic, always Twist, where set")
    cmd_audio: Channel = _reliable("cmd_audio", "notes for the base to play")
    joint_states: Channel = _sensor("joint_states", "positions of the arm's joints")

    navigate_action: str = Field(default="navigate_to_pose", description="Nav2's action that drives to a goal")
    path_action: str = Field(default="compute_path_to_pose", description="Nav2's action that plans a path")
    dock_action: str = Field(default="dock", description="the base's action that docks")
    undock_action: str = Field(default="undock", description="the base's action that undocks")
    led_action: str = Field(default="led_animation", description="the base's action that blinks")
    arm_action: str = Field(
        default="arm_controller/follow_joint_trajectory", description="the arm's action that moves its joints"
    )
    gripper_action: str = Field(
        default="gripper_controller/gripper_cmd", description="the arm's action that moves its jaw"
    )
    e_stop_service: str = Field(default="e_stop", description="the base's service that disables its wheels")
    clear_costmap_services: tuple[str, ...] = Field(
        default=("global_costmap/clear_entirely_global_costmap", "local_costmap/clear_entirely_local_costmap"),
        description="Nav2's services that clear its costmaps",
    )
    nav2_lifecycle_nodes: tuple[str, ...] = Field(
        default=("bt_navigator", "planner_server", "controller_server"), description="active while Nav2 is"
    )


class Limits(
    VelocityLimits,
    ObstacleLimits,
    LaserRules,
    LocalizerLimits,
    GoalLimits,
    DockingLimits,
    RecordingLimits,
    ArmLimits,
):
    """Of all parts; a class of its own because pyright takes no more than one of them beside `ServiceSettings`."""


class Settings(Limits, ServiceSettings):
    """E.g. ROBOT_BRIDGE_PORT, nested ROBOT_BRIDGE_ROS__SCAN__NAME, ROBOT_BRIDGE_GAINS__HEADING_KP."""

    model_config = SettingsConfigDict(
        env_prefix="ROBOT_BRIDGE_",
        env_nested_delimiter="__",
        nested_model_default_partial_update=True,  # a topic that gets another name keeps its quality of service
        frozen=True,
    )

    port: Port = 8004
    log_level: str = Field(default="INFO", description="DEBUG, INFO, WARNING or ERROR")
    nice: int = Field(default=-10, ge=-20, le=19, description="the process's priority, where it is permitted to set it")
    state_dir: Path = Field(default=Path("var/robot_bridge"), description="holds the emergency stop's latch")
    recordings_dir: Path | None = Field(default=None, description="none = recordings/ in the state directory")
    body_bytes_max: int = Field(default=200_000, ge=1000, description="largest request body; a larger one gets 413")
    foxglove_port: Port | None = Field(
        default=None, description="of a live view for Foxglove, on this machine only and without keys; none = off"
    )
    foxglove_images_hz: float = Field(default=5.0, ge=0.0, le=30.0, description="of pictures in the live view")
    session_timeout_s: float = Field(
        default=1.0, gt=0.0, le=10.0, description="a session silent for so long ends; a closed socket ends it at once"
    )
    jpeg_quality: int = Field(default=85, ge=10, le=100, description="of the camera's pictures")
    stream_viewers_max: int = Field(default=8, ge=1, description="of the camera's stream at the same time")
    depth_m_max: float = Field(default=20.0, gt=0.0, le=100.0, description="what is further is a hole in the picture")
    nav2_timeout_s: float = Field(default=5.0, gt=0.0, description="for Nav2 to accept a goal or plan a path")
    arm: Literal["none", "so101"] = Field(default="none", description="the arm on the robot (docs/arm.md)")
    gains: MotionGains = GAINS
    ros: RosSettings = RosSettings()
