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

OCCUPIED = (4.5, 3.0, 0.3)
"""x, y and radius of a place in the map that no path leads into: something stands there."""
DOCK = Pose2D(x=0.5, y=2.0, yaw=math.pi)
"""base_link in map while docked."""
NEAR_M = 0.65
THING_BOX = (105.0, 105.0, 145.0, 145.0)

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
    planner_code: int = 0
    """What the planner says of every goal, where it is not 0; 208 only of those farther off than `NEAR_M`."""
    give_ups: int = 0
    """So many goals are aborted with `give_up_code` before `navigation` holds."""
    give_up_code: int = 104
    distance_left_m: float = 1.5
    """What Nav2 feeds back while it drives. Only the fake robot heeds it."""
    camera_x_m: float = CAMERA_X_M
    """Of the camera before base_link."""
    preempted: bool = False
    """Somebody else's goal has taken the place of one that was given up. Only the fake robot heeds it."""
    thinking: set[str] = field(default_factory=set)
    """Of `nav2`, `costmaps` and `base`, who takes for ever over the next thing asked of it. Only the fake robot heeds
    it."""
    can_dock: bool = True
    docked: bool = False
    dock_visible: bool = False
    base_stop: bool | None = None
    """Whether its wheels are disabled: by its own stop, whoever pressed it; None = nobody has yet."""
    base_stop_asks: list[bool] = field(default_factory=list)
    """What its own stop was asked for, by service."""
    initial_poses: list[tuple[float, float]] = field(default_factory=list)
    republisher_deaths: int = 0
    """How often the base was asked for what it rejects: that kills create3_republisher."""
    velocities: list[tuple[float, float]] = field(default_factory=list)
    goals: list[tuple[float, float, float]] = field(default_factory=list)
    cancelled: int = 0
    docking: int = 0
    """Dockings and undockings that the base is at."""
    notes: list[tuple[int, float]] = field(default_factory=list)
    leds: tuple[int, tuple[tuple[int, int, int], ...], float] | None = None
    """The newest animation: its type, each LED's colour, its seconds."""
    cleared: int = 0

    def told_where(self, x: float, y: float) -> None:
        """The localiser's initial pose; one that knew none speaks from then on."""
        self.initial_poses.append((round(x, 3), round(y, 3)))
        self.silent.discard("pose")

    def asked_to_stop(self, on: bool) -> None:
        """Its own stop, by service."""
        self.base_stop = on
        self.base_stop_asks.append(on)

    def told(self, linear_x: float, angular_z: float) -> None:
        self.linear_x, self.angular_z = linear_x, angular_z
        self.velocities.append((linear_x, angular_z))

    def step(self, dt_s: float) -> None:
        self.x += self.linear_x * dt_s * math.cos(self.yaw)
        self.y += self.linear_x * dt_s * math.sin(self.yaw)
        self.yaw = math.remainder(self.yaw + self.angular_z * dt_s, math.tau)

    def put_on_dock(self) -> None:
        """By hand. The toy's odometry, and so its place in the map, follow."""
        self.x, self.y, self.yaw = DOCK.x - START.x, DOCK.y - START.y, DOCK.yaw
        self.docked = self.dock_visible = True

    def put_away(self) -> None:
        """Off the dock by hand, to where the base does not see it."""
        self.x, self.y, self.yaw = 1.0, 0.0, 0.0
        self.docked = self.dock_visible = False

    def drive_onto_dock(self, docked: bool) -> None:
        """What the base does by itself."""
        if docked:
            self.put_on_dock()
        else:
            self.docked, self.x = False, self.x + 0.45

    def face_the_thing(self) -> tuple[tuple[float, float, float, float], float, tuple[float, float]]:
        """Puts the robot before a thing: its box in the picture, its depth, and where in the map its surface is."""
        return THING_BOX, self.wall_ahead_m - 0.5, (START.x + CAMERA_X_M + self.wall_ahead_m - 0.5, START.y)

    def plan_code(self, x: float, y: float) -> int:
        """Of the toy's planner, 0 where a path leads there."""
        inside = math.hypot(x - OCCUPIED[0], y - OCCUPIED[1]) < OCCUPIED[2]
        return self.refusal(x, y) or (206 if inside else 0)

    def refusal(self, x: float, y: float) -> int:
        """`planner_code`, where it is said of a goal there."""
        near = math.hypot(x - START.x - self.x, y - START.y - self.y) < NEAR_M
        return 0 if near and self.planner_code == 208 else self.planner_code

    def gives_up(self) -> bool:
        """Asked once for each goal."""
        self.give_ups -= 1
        return self.give_ups >= 0

    @property
    def has_driven(self) -> bool:
        """Also on a busy machine, where a short lease may be over before a test looks."""
        return any(linear_x > 0.0 for linear_x, _ in self.velocities)

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
