"""A toy robot in a toy room: kinematics and senses that a fake port and a real ROS node both are made of."""

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from contracts.geometry import Pose2D

BEAMS = 144
ROOM_M = 3.0
FX = 100.0
CAMERA_X_M, CAMERA_Z_M = 0.06, 0.24
OPTICAL_XYZW = (-0.5, 0.5, -0.5, 0.5)
"""The optical frame (z forward, x right, y down) in base_link."""
START = Pose2D(x=1.0, y=2.0, yaw=0.0)
"""odom in map, and so the robot at first."""

Navigation = Literal["drives", "succeeds", "aborts", "rejects", "is_inactive"]


@dataclass
class ToyRobot:
    """What it is told goes into `velocities`; what it shall sense or do is set from outside."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    linear_x: float = 0.0
    angular_z: float = 0.0
    wall_ahead_m: float = ROOM_M
    hazards: set[str] = field(default_factory=set)
    silent: set[str] = field(default_factory=set)
    navigation: Navigation = "drives"
    can_dock: bool = True
    docked: bool = False
    base_stop: bool | None = None
    velocities: list[tuple[float, float]] = field(default_factory=list)
    goals: list[tuple[float, float, float]] = field(default_factory=list)
    cancelled: int = 0
    notes: list[tuple[int, float]] = field(default_factory=list)
    cleared: int = 0

    def told(self, linear_x: float, angular_z: float) -> None:
        self.linear_x, self.angular_z = linear_x, angular_z
        self.velocities.append((linear_x, angular_z))

    def step(self, dt_s: float) -> None:
        self.x += self.linear_x * dt_s * math.cos(self.yaw)
        self.y += self.linear_x * dt_s * math.sin(self.yaw)
        self.yaw = math.remainder(self.yaw + self.angular_z * dt_s, math.tau)

    @property
    def at_rest(self) -> bool:
        return (self.linear_x, self.angular_z) == (0.0, 0.0)

    def bearings_and_ranges(self) -> tuple[np.ndarray, np.ndarray]:
        """Beams from base_link: a round room, and a flat wall ahead of the robot wherever it is."""
        bearings = np.linspace(-math.pi, math.pi, BEAMS, endpoint=False)
        ranges = np.full(BEAMS, ROOM_M)
        ahead = np.abs(bearings) < 1.0
        ranges[ahead] = np.minimum(ROOM_M, self.wall_ahead_m / np.cos(bearings[ahead]))
        return bearings, ranges

    def picture(self) -> np.ndarray:
        image = np.full((250, 250, 3), 180, np.uint8)
        image[100:150, 100:150] = (30, 30, 220)
        return image

    def depths_m(self) -> np.ndarray:
        """The wall, and in the middle of the picture a thing half a metre nearer."""
        depth = np.full((400, 640), self.wall_ahead_m, np.float32)
        depth[160:240, 280:360] = self.wall_ahead_m - 0.5
        return depth

    def cells(self) -> np.ndarray:
        """6 x 8 m at 0.1 m: free, a wall round it, one unknown corner."""
        grid = np.zeros((60, 80), np.int8)
        grid[0, :] = grid[-1, :] = grid[:, 0] = grid[:, -1] = 100
        grid[50:, 70:] = -1
        return grid
