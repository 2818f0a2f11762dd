"""The simulated TurtleBot4 Lite in a furnished home: in-process, on a simulated clock, without ROS."""

from sim.world.rendering import RenderingUnavailableError, open_renderer  # pyright: ignore[reportUnknownVariableType] - MuJoCo has no types
from sim.world.types import (
    Battery,
    CameraModel,
    DockStatus,
    Hazard,
    Imu,
    OccupancyGrid,
    Odometry,
    PoseEstimate,
    Scan,
    Scene,
    SceneThing,
    ThingTruth,
    Truth,
    WorldOptions,
)
from sim.world.world import World

__all__ = [
    "Battery",
    "CameraModel",
    "DockStatus",
    "Hazard",
    "Imu",
    "OccupancyGrid",
    "Odometry",
    "PoseEstimate",
    "RenderingUnavailableError",
    "Scan",
    "Scene",
    "SceneThing",
    "ThingTruth",
    "Truth",
    "World",
    "WorldOptions",
    "open_renderer",
]
