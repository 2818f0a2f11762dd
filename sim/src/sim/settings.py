"""Settings of the simulated robot's process: command line first, then environment (`SIM_...`), then these defaults."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field
from pydantic_settings import BaseSettings, SettingsConfigDict

RateHz = Annotated[float, Field(gt=0.0, le=60.0)]


class SimSettings(BaseSettings):
    """A simulated TurtleBot4 Lite in a furnished home: to everyone else on ROS 2 it is the robot."""

    model_config = SettingsConfigDict(
        env_prefix="SIM_",
        populate_by_name=True,
        cli_prog_name="python -m sim",
        cli_kebab_case=True,
        cli_implicit_flags=True,
        cli_hide_none_type=True,
        cli_avoid_json=True,
    )

    seed: int = Field(default=1, ge=0, description="of the home and of every sensor's noise")
    want: str = Field(default="", description="what the home must hold, for example 'red bottle'")
    home: Path | None = Field(default=None, description="a home file to use instead of a generated one")
    save_home: Path | None = Field(default=None, description="write the home to this file")
    host: str = Field(default="127.0.0.1", description="address of the ground-truth interface")
    port: int = Field(default=8006, ge=0, le=65535, description="port of the ground-truth interface")

    rgb_hz: RateHz = Field(default=5.0, description="colour frames a second (a real OAK-D preview gives 30)")
    depth_hz: RateHz = Field(default=3.0, description="depth frames a second (a real one gives 14)")
    scan_hz: RateHz = Field(default=7.7, description="turns of the lidar a second, as an RPLiDAR A1")
    amcl_hz: RateHz = Field(default=2.0, description="poses of the localiser a second, at most, while it moves")
    amcl_ahead_s: float = Field(default=1.0, ge=0.0, le=10.0, description="AMCL's transform_tolerance, dated ahead")
    amcl_initial_pose: bool = Field(
        default=True, description="the localiser knows where it starts, else waits to be told"
    )
    mapping: bool = Field(
        default=False, description="nobody has mapped the home: the map grows as it is seen, as with slam_toolbox"
    )
    odom_hz: RateHz = Field(default=20.0, description="odometry, tf and the Nav2 stand-in's control loop a second")
    cmd_vel_stamped: bool = Field(default=True, description="TwistStamped on cmd_vel and cmd_vel_nav, else Twist")
    namespace: str = Field(default="", description="ROS namespace of everything the robot says and hears")
    nav2_stand_in: bool = Field(default=True, description="answer as Nav2; off where a real Nav2 runs beside it")
    nav2_active: bool = Field(default=True, description="the stand-in's lifecycle nodes start active")
    nav2_goal_tolerance_m: float = Field(default=0.25, gt=0.0, le=2.0, description="Nav2's xy_goal_tolerance")
    nav2_goal_tolerance_rad: float = Field(default=0.25, gt=0.0, le=3.2, description="Nav2's yaw_goal_tolerance")
    nav2_planner_tolerance_m: float = Field(
        default=0.5, ge=0.0, le=2.0, description="so far beside an occupied goal a path may end; 0 = none, code 206"
    )
    nav2_delay_s: float = Field(default=0.1, ge=0.0, le=1.0, description="from the controller to cmd_vel_nav")
    nav2_gap_s: float = Field(default=0.0, ge=0.0, le=2.0, description="so long cmd_vel_nav is silent every 5 s")
    nav2_abort_one_in: int = Field(
        default=0, ge=0, description="one in so many replannings (one a second) aborts the goal, code 0; 0 = none"
    )
    nav2_drives_on_s: float = Field(
        default=0.0, ge=0.0, le=10.0, description="so long Nav2 drives on after a goal's end"
    )
    nav2_dies_after_s: float = Field(
        default=0.0, ge=0.0, description="the controller dies after so much driving; 0 = never"
    )
    base_timeout_s: float = Field(
        default=0.5, gt=0.0, le=2.0, description="without a command the base stops (wheels_stop_threshold_sec)"
    )
    e_stop_confirms: bool = Field(default=False, description="e_stop answers success: true, as without a republisher")
    power_saver: bool = Field(default=False, description="on its dock lidar and camera are off, as a TurtleBot 4's")
    camera_boot_s: float = Field(default=4.0, ge=0.0, le=60.0, description="after the dock, with the power saver")
    arm: Literal["none", "so101"] = Field(
        default="none", description="on the robot's deck (docs/arm.md); its model comes from a wheel of its own"
    )
    start_docked: bool = Field(default=False, description="start in the dock instead of half a metre in front of it")
    log_level: Literal["DEBUG", "INFO", "WARNING", "ERROR"] = Field(default="INFO", description="of the log on stderr")
