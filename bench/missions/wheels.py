"""The robot's motion without physics: where it is told, at the speed it is told, stopping at what the map holds."""

import asyncio
import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bench.missions.place import SimulatedPlace
from contracts.geometry import Pose2D, Twist2D
from contracts.motion import DriveReply, MotionEnd, RotateReply
from geometry.poses import wrap
from sim.world.sensors import LocalizationError, OdometryDrift
from sim.world.types import WorldOptions

STOP_CLEARANCE_M = 0.20
BLOCKED_S = 1.5
GOAL_SPEED_M_S, GOAL_TURN_RAD_S = 0.26, 1.2
GOAL_TOLERANCE_M, GOAL_TOLERANCE_RAD = 0.25, 0.25
"""turtlebot4's own for Nav2: a goal ends short of where it was sent, and one nearer than this without a move."""


def _future() -> "asyncio.Future[MotionEnd]":
    return asyncio.get_running_loop().create_future()


@dataclass
class Moving:
    """A closed-loop motion; `cut_after` is the share of it after which something takes the wheels away."""

    cut_after: float | None = None
    moved: float = 0.0
    blocked_s: float = 0.0
    ended: "asyncio.Future[MotionEnd]" = field(default_factory=_future)

    def finish(self, end: MotionEnd) -> None:
        if not self.ended.done():
            self.ended.set_result(end)


@dataclass
class Turning(Moving):
    def __init__(self, angle_rad: float, speed_rad_s: float) -> None:
        super().__init__()
        self.angle_rad, self.speed_rad_s = angle_rad, speed_rad_s

    def reply(self, end: MotionEnd) -> RotateReply:
        return RotateReply(end=end, turned_rad=self.moved, text=end.sentence)


@dataclass
class Straight(Moving):
    def __init__(self, distance_m: float, speed_m_s: float) -> None:
        super().__init__()
        self.distance_m, self.speed_m_s = distance_m, speed_m_s

    def reply(self, end: MotionEnd) -> DriveReply:
        return DriveReply(end=end, driven_m=self.moved, text=end.sentence)


@dataclass
class Going:
    """Along a way to a heading. `gives_up_after` and `claims_after` are shares of its length."""

    way: NDArray[np.float64]
    yaw: float
    gives_up_after: float | None = None
    claims_after: float | None = None
    along_m: float = 0.0
    arrived: bool = False
    """Within the tolerance once: from then on it only turns."""

    def __post_init__(self) -> None:
        steps = np.hypot(*np.diff(self.way, axis=0).T)
        self.at_m = np.concatenate([[0.0], np.cumsum(steps)])

    @property
    def length_m(self) -> float:
        return float(self.at_m[-1])

    def point(self, along_m: float) -> tuple[float, float]:
        return (
            float(np.interp(along_m, self.at_m, self.way[:, 0])),
            float(np.interp(along_m, self.at_m, self.way[:, 1])),
        )


class Wheels:
    """Where the robot is, where it believes to be, and the one thing that moves it."""

    def __init__(self, place: SimulatedPlace, start: Pose2D, seed: int) -> None:
        options = WorldOptions()
        self.pose = start
        self.twist = Twist2D()
        self.goal_ending: int | None = None
        """Of the last goal: 0 reached, else Nav2's error code; none while it is under way."""
        self.way_m = 0.0
        self._place = place
        self._odometry = OdometryDrift(options, np.random.default_rng([seed, 31]))
        self._error = LocalizationError(options, np.random.default_rng([seed, 32]))
        self._moving: Moving | None = None
        self._going: Going | None = None
        self._lease: tuple[Twist2D, float] = (Twist2D(), -math.inf)

    def believed(self) -> Pose2D:
        x, y, yaw = self._error.value
        return Pose2D(x=self.pose.x + x, y=self.pose.y + y, yaw=wrap(self.pose.yaw + yaw))

    def odometry(self) -> Pose2D:
        return self._odometry.pose

    def put(self, pose: Pose2D) -> None:
        self.pose = pose

    def begin(self, what: "Moving | Going") -> None:
        self.end(MotionEnd.PREEMPTED)
        if isinstance(what, Going):
            self._going, self.goal_ending = what, None
        else:
            self._moving = what

    def lease(self, twist: Twist2D, until_s: float) -> None:
        self._lease = (twist, until_s)

    def end(self, end: MotionEnd) -> None:
        if self._moving is not None:
            self._moving.finish(end)
        self._moving = self._going = None
        self._lease = (Twist2D(), -math.inf)
        self.twist = Twist2D()

    def tick(self, dt_s: float, now_s: float) -> None:
        self._error.tick(dt_s)
        before = self.pose
        match self._moving:
            case Turning() as turning:
                self._turn(turning, dt_s)
            case Straight() as straight:
                self._drive(straight, dt_s)
            case _:
                if self._going is not None:
                    self._go(self._going, dt_s)
                elif now_s < self._lease[1]:
                    twist = self._lease[0]
                    self._shift(twist.linear_x * dt_s)
                    self._spin(twist.angular_z * dt_s)
        self._note(before, dt_s)

    def _note(self, before: Pose2D, dt_s: float) -> None:
        dx, dy, turn = self.pose.x - before.x, self.pose.y - before.y, wrap(self.pose.yaw - before.yaw)
        if dx == dy == turn == 0.0:
            self.twist = Twist2D()
            return
        cos, sin = math.cos(before.yaw), math.sin(before.yaw)
        self._odometry.move(cos * dx + sin * dy, cos * dy - sin * dx, turn)
        self.way_m += math.hypot(dx, dy)
        self.twist = Twist2D(linear_x=math.hypot(dx, dy) / dt_s, angular_z=turn / dt_s)

    def _turn(self, turning: Turning, dt_s: float) -> None:
        left = turning.angle_rad - turning.moved
        step = math.copysign(min(abs(left), turning.speed_rad_s * dt_s), left)
        self._spin(step)
        turning.moved += step
        if turning.cut_after is not None and abs(turning.moved) >= turning.cut_after * abs(turning.angle_rad):
            self.end(MotionEnd.PREEMPTED)
        elif abs(turning.angle_rad - turning.moved) < 1e-6:
            self._moving = None
            turning.finish(MotionEnd.COMPLETED)

    def _drive(self, straight: Straight, dt_s: float) -> None:
        step = min(straight.distance_m - straight.moved, straight.speed_m_s * dt_s)
        if self._shift(step):
            straight.moved += step
            straight.blocked_s = 0.0
        else:
            straight.blocked_s += dt_s
        if straight.cut_after is not None and straight.moved >= straight.cut_after * straight.distance_m:
            self.end(MotionEnd.PREEMPTED)
        elif straight.blocked_s > BLOCKED_S:
            self.end(MotionEnd.BLOCKED)
        elif straight.distance_m - straight.moved < 1e-6:
            self._moving = None
            straight.finish(MotionEnd.COMPLETED)

    def _go(self, going: Going, dt_s: float) -> None:
        left_m = going.length_m - going.along_m
        if going.gives_up_after is not None and going.along_m >= going.gives_up_after * going.length_m:
            self._going, self.goal_ending = None, 104
            return
        if going.claims_after is not None and going.along_m >= going.claims_after * going.length_m:
            self._going, self.goal_ending = None, 0
            return
        if going.arrived or left_m <= GOAL_TOLERANCE_M:
            going.arrived = True
            if self._spin_towards(going.yaw, dt_s, within_rad=GOAL_TOLERANCE_RAD):
                self._going, self.goal_ending = None, 0
            return
        ahead = going.point(min(going.along_m + 0.2, going.length_m))
        here = going.point(going.along_m)
        heading = math.atan2(ahead[1] - here[1], ahead[0] - here[0])
        if abs(wrap(heading - self.believed().yaw)) > 0.7:
            self._spin_towards(heading, dt_s)
            return
        going.along_m += min(left_m, GOAL_SPEED_M_S * dt_s)
        x, y = going.point(going.along_m)
        error_x, error_y, error_yaw = self._error.value
        turn = wrap(heading - error_yaw - self.pose.yaw)
        turn = math.copysign(min(abs(turn), GOAL_TURN_RAD_S * dt_s), turn)
        self.pose = Pose2D(x=x - error_x, y=y - error_y, yaw=wrap(self.pose.yaw + turn))

    def _spin_towards(self, yaw: float, dt_s: float, *, within_rad: float = 0.06) -> bool:
        """In the map, as believed; true when it looks there."""
        left = wrap(yaw - self.believed().yaw)
        if abs(left) < within_rad:
            return True
        self._spin(math.copysign(min(abs(left), GOAL_TURN_RAD_S * dt_s), left))
        return False

    def _spin(self, angle_rad: float) -> None:
        self.pose = Pose2D(x=self.pose.x, y=self.pose.y, yaw=wrap(self.pose.yaw + angle_rad))

    def _shift(self, metres: float) -> bool:
        """Straight ahead; false, and it stays, where it would come too near something."""
        if metres == 0.0:
            return True
        x, y = self.pose.x + metres * math.cos(self.pose.yaw), self.pose.y + metres * math.sin(self.pose.yaw)
        after = self._place.clearance_m(x, y)
        if after < STOP_CLEARANCE_M and after <= self._place.clearance_m(self.pose.x, self.pose.y):
            return False
        self.pose = Pose2D(x=x, y=y, yaw=self.pose.yaw)
        return True
