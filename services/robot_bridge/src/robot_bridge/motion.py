"""Turning and driving closed on odometry: a step at every tick, until done or given up. Pure: time is passed in."""

import math
from dataclasses import dataclass
from typing import Protocol

from simple_pid import PID

from contracts.geometry import Twist2D
from contracts.robot import MotionReply
from robot_bridge.senses import Odometry
from robot_bridge.transforms import wrap


@dataclass(slots=True)
class Gains:
    """Tunable while running: a motion reads them at every step."""

    heading_kp: float = 2.5
    heading_ki: float = 0.0
    heading_kd: float = 0.05
    drive_kp: float = 1.5
    turn_tolerance_rad: float = 0.02
    drive_tolerance_m: float = 0.01
    turn_rad_s_min: float = 0.12
    drive_m_s_min: float = 0.03
    blocked_s_max: float = 1.5


class Motion(Protocol):
    """A closed-loop motion. `step` gives the next velocity, or the reply when it is over."""

    allow_reverse: bool

    @property
    def moved(self) -> float: ...

    def step(self, odometry: Odometry | None, now_s: float, sent: Twist2D, why: str) -> Twist2D | MotionReply:
        """`odometry` is none when it is too old to act on; `sent` is what the last wish became, `why` it differed."""
        ...


class _Patience:
    """Gives up a motion past its deadline, without odometry, or when nothing of what it wants reaches the base."""

    def __init__(self, timeout_s: float, blocked_s_max: float) -> None:
        self._timeout_s = timeout_s
        self._blocked_s_max = blocked_s_max
        self._started_s: float | None = None
        self._free_s = 0.0
        self._dead_reckoning_s: float | None = None

    def over(self, now_s: float, *, blind: bool, moving: bool, why: str) -> str | None:
        if self._started_s is None:
            self._started_s = self._free_s = self._dead_reckoning_s = now_s
        if not blind:
            self._dead_reckoning_s = now_s
        if moving:
            self._free_s = now_s
        if now_s - self._started_s > self._timeout_s:
            return "timeout"
        if blind and self._dead_reckoning_s is not None and now_s - self._dead_reckoning_s > 0.5:
            return "no odometry"
        if now_s - self._free_s > self._blocked_s_max:
            return why or "blocked"
        return None


class Rotation:
    """Turns by `angle_rad`, more than once round if asked to, with a PID on the angle left."""

    allow_reverse = False

    def __init__(self, angle_rad: float, *, speed_rad_s: float, timeout_s: float, gains: Gains) -> None:
        self._angle_rad = angle_rad
        self._speed_rad_s = speed_rad_s
        self._gains = gains
        self._pid = PID(setpoint=angle_rad, sample_time=None)
        self._patience = _Patience(timeout_s, gains.blocked_s_max)
        self._last_yaw: float | None = None
        self._last_s: float | None = None
        self.turned_rad = 0.0

    @property
    def moved(self) -> float:
        return self.turned_rad

    def step(self, odometry: Odometry | None, now_s: float, sent: Twist2D, why: str) -> Twist2D | MotionReply:
        over = self._patience.over(now_s, blind=odometry is None, moving=abs(sent.angular_z) > 1e-3, why=why)
        if over is not None:
            return MotionReply(completed=False, moved=self.turned_rad, reason=over)
        if odometry is None:
            return Twist2D()
        yaw = odometry.pose.yaw
        self.turned_rad += wrap(yaw - self._last_yaw) if self._last_yaw is not None else 0.0
        self._last_yaw = yaw
        left_rad = self._angle_rad - self.turned_rad
        if abs(left_rad) <= self._gains.turn_tolerance_rad:
            return MotionReply(completed=True, moved=self.turned_rad)
        gains, limit = self._gains, self._speed_rad_s
        self._pid.tunings = (gains.heading_kp, gains.heading_ki, gains.heading_kd)
        self._pid.output_limits = (-limit, limit)
        dt_s = max(1e-3, now_s - self._last_s) if self._last_s is not None else 0.05
        self._last_s = now_s
        wanted = self._pid(self.turned_rad, dt=dt_s) or 0.0
        slowest = min(limit, gains.turn_rad_s_min)
        return Twist2D(angular_z=math.copysign(max(abs(wanted), slowest), left_rad))


class Drive:
    """Drives `distance_m` along the heading it starts with, holding that heading."""

    def __init__(
        self, distance_m: float, *, speed_m_s: float, timeout_s: float, allow_reverse: bool, gains: Gains
    ) -> None:
        self.allow_reverse = allow_reverse
        self._distance_m = distance_m
        self._speed_m_s = speed_m_s
        self._gains = gains
        self._patience = _Patience(timeout_s, gains.blocked_s_max)
        self._start: Odometry | None = None
        self.driven_m = 0.0

    @property
    def moved(self) -> float:
        return self.driven_m

    def step(self, odometry: Odometry | None, now_s: float, sent: Twist2D, why: str) -> Twist2D | MotionReply:
        over = self._patience.over(now_s, blind=odometry is None, moving=abs(sent.linear_x) > 1e-3, why=why)
        if over is not None:
            return MotionReply(completed=False, moved=self.driven_m, reason=over)
        if odometry is None:
            return Twist2D()
        start = self._start = self._start or odometry
        heading = start.pose.yaw
        dx, dy = odometry.pose.x - start.pose.x, odometry.pose.y - start.pose.y
        self.driven_m = dx * math.cos(heading) + dy * math.sin(heading)
        left_m = self._distance_m - self.driven_m
        if abs(left_m) <= self._gains.drive_tolerance_m or left_m * self._distance_m < 0.0:
            return MotionReply(completed=True, moved=self.driven_m)
        gains = self._gains
        speed = min(self._speed_m_s, max(gains.drive_kp * abs(left_m), gains.drive_m_s_min))
        turn = gains.heading_kp * wrap(heading - odometry.pose.yaw)
        return Twist2D(linear_x=math.copysign(speed, left_m), angular_z=min(max(turn, -0.5), 0.5))
