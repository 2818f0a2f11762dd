"""Every knob of the bridge, from the environment: ROBOT_BRIDGE_PORT, nested ROBOT_BRIDGE_ROS__SCAN__NAME."""

from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field
from pydantic_settings import SettingsConfigDict

from contracts.description import DepthNoise
from contracts.geometry import Pose2D
from mesh.settings import Port, ServiceSettings
from robot_bridge.sensing.laser_rules import LaserMask, ZeroRange
from robot_bridge.sensing.snapshot import AgeLimits


class Channel(BaseModel):
    """A ROS topic and its quality of service."""

    model_config = ConfigDict(frozen=True)

    name: str
    reliability: Literal["reliable", "best_effort", "best_available"] = "best_effort"
    durability: Literal["volatile", "transient_local", "best_available"] = "volatile"
    depth: int = Field(default=5, ge=1, le=1000)


def _sensor(name: str, depth: int = 5) -> Channel:
    return Channel(name=name, depth=depth)


def _kept(name: str, depth: int = 1) -> Channel:
    return Channel(name=name, reliability="reliable", durability="transient_local", depth=depth)


def _changing(name: str) -> Channel:
    """Told on change only: the last word counts, also one said before the bridge began."""
    return Channel(name=name, reliability="best_available", durability="best_available")


def _reliable(name: str, depth: int = 10) -> Channel:
    return Channel(name=name, reliability="reliable", depth=depth)


class RosSettings(BaseModel):
    """Names, types and quality of service on the ROS side; relative names live in `namespace`."""

    model_config = ConfigDict(frozen=True)

    node_name: str = "robot_bridge"
    namespace: str = ""
    use_sim_time: bool = False
    map_frame: str = "map"
    odom_frame: str = "odom"
    base_frame: str = "base_link"

    rgb: Channel = _sensor("oakd/rgb/preview/image_raw", 1)
    rgb_info: Channel = _sensor("oakd/rgb/preview/camera_info", 1)
    depth: Channel = _sensor("oakd/stereo/image_raw", 1)
    depth_info: Channel = _sensor("oakd/stereo/camera_info", 1)
    scan: Channel = _sensor("scan")
    odom: Channel = _sensor("odom")
    amcl_pose: Channel = _kept("amcl_pose")
    initial_pose: Channel = _reliable("initialpose")
    map: Channel = _kept("map")
    tf: Channel = _reliable("tf", 100)
    tf_static: Channel = _kept("tf_static", 100)
    battery: Channel = _changing("battery_state")
    dock_status: Channel = _changing("dock_status")
    hazards: Channel = _changing("hazard_detection")
    wheel_status: Channel = _changing("wheel_status")
    cmd_vel_nav: Channel = _reliable("cmd_vel_nav", 1)
    cmd_vel_nav_type: Literal["Twist", "TwistStamped"] = "TwistStamped"
    cmd_vel: Channel = _reliable("cmd_vel")
    cmd_vel_type: Literal["Twist", "TwistStamped"] = "TwistStamped"
    cmd_vel_known: tuple[str, ...] = Field(
        default=("docking_server", "teleop_twist_joy_node"),
        description="nodes that publish cmd_vel too and are known to keep silent: Nav2's docking, an unpaired joystick",
    )
    cmd_vel_unstamped: Channel | None = Field(default=None, description="a second topic, always Twist, where set")
    cmd_audio: Channel = _reliable("cmd_audio")

    navigate_action: str = "navigate_to_pose"
    path_action: str = "compute_path_to_pose"
    dock_action: str = "dock"
    undock_action: str = "undock"
    led_action: str = "led_animation"
    e_stop_service: str = "e_stop"
    clear_costmap_services: tuple[str, ...] = (
        "global_costmap/clear_entirely_global_costmap",
        "local_costmap/clear_entirely_local_costmap",
    )
    nav2_lifecycle_nodes: tuple[str, ...] = ("bt_navigator", "planner_server", "controller_server")


class Settings(ServiceSettings):
    model_config = SettingsConfigDict(
        env_prefix="ROBOT_BRIDGE_",
        env_nested_delimiter="__",
        nested_model_default_partial_update=True,  # a topic that gets another name keeps its quality of service
        frozen=True,
    )

    port: Port = 8004
    log_level: str = "INFO"
    nice: int = Field(default=-10, ge=-20, le=19, description="the process's priority, where it is permitted to set it")
    state_dir: Path = Field(default=Path("var/robot_bridge"), description="holds the emergency stop's latch")
    body_bytes_max: int = Field(default=200_000, ge=1000)

    speed_m_s_max: float = Field(default=0.306, gt=0.0, le=2.0, description="of the base: no request may be faster")
    turn_rad_s_max: float = Field(default=1.9, gt=0.0, le=4.0)
    acceleration_m_s2_max: float = Field(default=0.9, gt=0.0, le=5.0)
    turn_acceleration_rad_s2_max: float = Field(default=7.7, gt=0.0, le=50.0)
    request_age_s_max: float = Field(default=0.5, gt=0.0)
    request_ahead_s_max: float = Field(default=0.1, ge=0.0)
    session_timeout_s: float = Field(default=1.0, gt=0.0, le=10.0, description="a closed socket ends it at once")

    footprint_radius_m: float = Field(default=0.189, gt=0.0, le=2.0)
    side_margin_m: float = Field(default=0.02, ge=0.0, le=0.5)
    stop_distance_m: float = Field(default=0.08, ge=0.0, le=2.0, description="from the footprint")
    slow_distance_m: float = Field(default=0.35, gt=0.0, le=5.0, description="from the footprint")
    slow_factor_min: float = Field(default=0.3, gt=0.0, le=1.0)
    scan_age_s_max: float = Field(default=0.5, gt=0.0)
    scan_age_to_turn_s_max: float = Field(default=2.0, gt=0.0)
    odometry_age_s_max: float = Field(default=0.5, gt=0.0)
    hazard_hold_s: float = Field(default=1.0, gt=0.0)

    laser_zero_means: ZeroRange = Field(default=ZeroRange.UNKNOWN, description="what a range of 0.0 says")
    laser_masks: tuple[LaserMask, ...] = Field(default=(), description="the robot's own parts in the scan")
    depth_noise: DepthNoise = DepthNoise(at_1m_m=0.012, exponent=3.461)
    """Stereo: 1.2 cm at 1.0 m, 28.6 cm at 2.5 m (requirement A9)."""
    depth_m_max: float = Field(default=20.0, gt=0.0, le=100.0, description="what is further is a hole in the picture")

    sector_wall_m: float = Field(default=0.25, gt=0.0, description="a ring sector nearer than this is a WALL")
    sector_obstacle_m: float = Field(default=0.5, gt=0.0, description="nearer than this: OBSTACLE")
    sector_near_m: float = Field(default=1.0, gt=0.0, description="nearer than this: NEAR, else CLEAR")
    gap_width_m_min: float = Field(default=0.7, gt=0.0, description="what is narrower is no doorway")
    gap_width_m_max: float = Field(default=2.5, gt=0.0, description="what is wider is open space")

    image_age_s_max: float = Field(default=1.5, gt=0.0)
    pose_age_s_max: float = Field(default=5.0, gt=0.0)
    jpeg_quality: int = Field(default=85, ge=10, le=100)
    stream_viewers_max: int = Field(default=8, ge=1)
    depth_match_s_max: float = Field(default=0.5, gt=0.0, description="between a picture and the depth measured in it")

    nav2_timeout_s: float = Field(default=5.0, gt=0.0, description="for Nav2 to accept a goal or plan a path")
    nav2_active_wait_s: float = Field(default=2.0, ge=0.0, description="for Nav2 to become active, before a goal")
    ring_radius_m: float = Field(default=0.6, ge=0.0, le=3.0, description="how far from the wanted pose a goal may end")
    ring_clearance_m: float = Field(default=0.08, ge=0.0, description="of the footprint, for poses on the ring")
    preflight_poses_max: int = Field(default=40, ge=1, le=100)
    plan_end_off_m_max: float = Field(
        default=0.15, gt=0.0, le=2.0, description="a plan that ends farther from its goal does not lead there"
    )
    preflight_s_max: float = Field(default=4.0, gt=0.0)
    retries_max: int = Field(default=2, ge=0, le=5, description="of a goal that Nav2 gave up under way, at most")
    costmap_timeout_s: float = Field(default=1.0, gt=0.0)
    fresh_scan_wait_s_max: float = Field(default=1.5, ge=0.0)
    dock_timeout_s: float = Field(default=90.0, gt=0.0, description="the way to the dock included")
    dock_look_s_max: float = Field(default=3.0, ge=0.0, description="for the base to see the dock it stands before")
    dock_pose: Pose2D | None = Field(default=None, description="base_link in map while docked; none = learned")
    initial_pose_from_dock: bool = Field(
        default=True, description="a robot that starts on its dock tells the localiser so, where that is known"
    )
    staging_distance_m: float = Field(default=0.6, gt=0.0, le=2.0, description="in front of the docked pose")

    navigation_may_reverse: bool = Field(default=True, description="Nav2's recoveries back up; the rear is watched too")
    recordings_dir: Path | None = Field(default=None, description="none = recordings/ in the state directory")
    recording_bytes_max: int = Field(default=1_000_000_000, ge=10_000, description="of one recording")
    recordings_bytes_max: int = Field(default=5_000_000_000, ge=10_000, description="of all; the oldest make room")
    recording_s_max: float = Field(default=3600.0, gt=0.0, le=86_400.0)
    recording_images_hz: float = Field(default=2.0, gt=0.0, le=30.0, description="of pictures, where they are wanted")

    heading_kp: float = 2.5
    heading_ki: float = 0.0
    heading_kd: float = 0.05
    drive_kp: float = 1.5
    drive_ki: float = 0.0
    drive_kd: float = 0.0
    turn_tolerance_rad: float = 0.02
    drive_tolerance_m: float = 0.01
    turn_rad_s_min: float = 0.12
    drive_m_s_min: float = 0.03
    blocked_s_max: float = 1.5

    ros: RosSettings = RosSettings()

    @property
    def ages(self) -> AgeLimits:
        return AgeLimits(
            scan_s=self.scan_age_s_max,
            odometry_s=self.odometry_age_s_max,
            image_s=self.image_age_s_max,
            pose_s=self.pose_age_s_max,
            hazard_hold_s=self.hazard_hold_s,
        )
