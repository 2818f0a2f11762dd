"""Turning and driving closed on odometry: a step at every tick, until done or given up. Pure: time is passed in."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Generic, TypeVar

from simple_pid import PID

from contracts.geometry import Twist2D
from contracts.motion import DriveReply, Hazard, MotionEnd, MotionGains, RotateReply
from geometry.poses import compose, inverse, wrap
from robot_bridge.sensing.sensor_readings import Odometry

FIRST_STEP_S = 0.05
BLIND_S_MAX = 0.5
HEADING_RAD_S_MAX = 0.5
"""How fast a drive may turn to hold its heading."""
GAINS = MotionGains(
    heading_kp=2.5,
    heading_ki=0.0,
    heading_kd=0.05,
    drive_kp=1.5,
    drive_ki=0.0,
    drive_kd=0.0,
    turn_tolerance_rad=0.02,
    drive_tolerance_m=0.01,
    turn_rad_s_min=0.12,
    drive_m_s_min=0.03,
    blocked_s_max=1.5,
)
"""Of the settings; `PUT /motion/gains` changes them until the process ends."""


class Tuning:
    """The gains in force. A motion reads them at every step, so that a change acts on the one under way."""

    def __init__(self, gains: MotionGains) -> None:
        self.gains = gains


@dataclass(frozen=True, slots=True)
class Ending:
    """How a motion ends: `hazards` those that ended it, `text` for a person, where there is more to say than the end's
    own sentence.
    """

    end: MotionEnd
    hazards: frozenset[Hazard] = frozenset()
    text: str = ""

    @property
    def in_words(self) -> str:
        return self.text or self.end.sentence


R_co = TypeVar("R_co", covariant=True)


class _Loop:
    """A PID on what is left, its gains given anew at every step, its clock the caller's."""

    def __init__(self) -> None:
        self._pid = PID(sample_time=None)
        self._last_s: float | None = None

    def __call__(self, left: float, now_s: float, gains: tuple[float, float, float], limit: float) -> float:
        """Within +-`limit`. The derivative is of what is left, so that a moving target is no jolt."""
        elapsed_s = now_s - self._last_s if self._last_s is not None else FIRST_STEP_S
        self._last_s = now_s
        self._pid.tunings = gains
        self._pid.output_limits = (-limit, limit)
        return self._pid(-left, dt=max(1e-3, elapsed_s)) or 0.0


class Motion(ABC, Generic[R_co]):
    """A closed-loop motion. Given up past its deadline, without odometry, or when nothing of what it wants reaches the
    base."""

    def __init__(self, *, timeout_s: float, tuning: Tuning, allow_reverse: bool = False) -> None:
        self.allow_reverse = allow_reverse
        self._timeout_s = timeout_s
        self._tuning = tuning
        self._started_s: float | None = None
        self._free_s = self._seeing_s = 0.0

    def step(self, odometry: Odometry | None, now_s: float, sent: Twist2D, held: Ending) -> Twist2D | R_co:
        """The next velocity, or the reply when it is over. `odometry` is none when it is too old to act on; `sent` is
        what the last wish became, `held` how it ends should it go on like that without moving."""
        gains = self._tuning.gains
        if self._started_s is None:
            self._started_s = self._free_s = self._seeing_s = now_s
        if odometry is not None:
            self._seeing_s = now_s
        if abs(self._speed(sent)) > 1e-3:
            self._free_s = now_s
        if now_s - self._started_s > self._timeout_s:
            return self.ended(Ending(MotionEnd.TIMED_OUT))
        if now_s - self._seeing_s > BLIND_S_MAX:
            return self.ended(Ending(MotionEnd.NO_ODOMETRY))
        if now_s - self._free_s > gains.blocked_s_max:
            return self.ended(held)
        if odometry is None:
            return Twist2D()
        return self._wanted(odometry, now_s, gains) or self.ended(Ending(MotionEnd.COMPLETED))

    @abstractmethod
    def ended(self, ending: Ending) -> R_co:
        """The reply, should it end now."""

    @abstractmethod
    def _speed(self, sent: Twist2D) -> float:
        """The part of a velocity that brings it nearer to its end."""

    @abstractmethod
    def _wanted(self, odometry: Odometry, now_s: float, gains: MotionGains) -> Twist2D | None:
        """The next velocity. Returns None where it is there."""


class Spin(Motion[RotateReply]):
    """Turns by `angle_rad`, more than once round if asked to, with a PID on the angle left."""

    def __init__(self, angle_rad: float, *, speed_rad_s: float, timeout_s: float, tuning: Tuning) -> None:
        super().__init__(timeout_s=timeout_s, tuning=tuning)
        self._angle_rad = angle_rad
        self._speed_rad_s = speed_rad_s
        self._loop = _Loop()
        self._last_yaw: float | None = None
        self.turned_rad = 0.0

    def ended(self, ending: Ending) -> RotateReply:
        return RotateReply(
            end=ending.end, turned_rad=self.turned_rad, hazards=tuple(sorted(ending.hazards)), text=ending.in_words
        )

    def _speed(self, sent: Twist2D) -> float:
        return sent.angular_z

    def _wanted(self, odometry: Odometry, now_s: float, gains: MotionGains) -> Twist2D | None:
        yaw = odometry.pose.yaw
        self.turned_rad += wrap(yaw - self._last_yaw) if self._last_yaw is not None else 0.0
        self._last_yaw = yaw
        left_rad = self._angle_rad - self.turned_rad
        if abs(left_rad) <= gains.turn_tolerance_rad:
            return None
        limit = self._speed_rad_s
        wanted = self._loop(left_rad, now_s, (gains.heading_kp, gains.heading_ki, gains.heading_kd), limit)
        return Twist2D(angular_z=_at_least(wanted, min(limit, gains.turn_rad_s_min), left_rad))


class DriveOnHeading(Motion[DriveReply]):
    """Drives `distance_m` along the heading it starts with: a PID on the distance left, one that holds the heading."""

    def __init__(
        self, distance_m: float, *, speed_m_s: float, timeout_s: float, allow_reverse: bool, tuning: Tuning
    ) -> None:
        super().__init__(timeout_s=timeout_s, tuning=tuning, allow_reverse=allow_reverse)
        self._distance_m = distance_m
        self._speed_m_s = speed_m_s
        self._distance_loop, self._heading_loop = _Loop(), _Loop()
        self._start: Odometry | None = None
        self.driven_m = 0.0

    def ended(self, ending: Ending) -> DriveReply:
        return DriveReply(
            end=ending.end, driven_m=self.driven_m, hazards=tuple(sorted(ending.hazards)), text=ending.in_words
        )

    def _speed(self, sent: Twist2D) -> float:
        return sent.linear_x

    def _wanted(self, odometry: Odometry, now_s: float, gains: MotionGains) -> Twist2D | None:
        start = self._start = self._start or odometry
        moved = compose(inverse(start.pose), odometry.pose)
        self.driven_m = moved.x
        left_m = self._distance_m - self.driven_m
        if abs(left_m) <= gains.drive_tolerance_m or left_m * self._distance_m < 0.0:
            return None
        limit = self._speed_m_s
        speed = self._distance_loop(left_m, now_s, (gains.drive_kp, gains.drive_ki, gains.drive_kd), limit)
        heading_gains = gains.heading_kp, gains.heading_ki, gains.heading_kd
        turn = self._heading_loop(-moved.yaw, now_s, heading_gains, HEADING_RAD_S_MAX)
        return Twist2D(linear_x=_at_least(speed, min(limit, gains.drive_m_s_min), left_m), angular_z=turn)


def _at_least(wanted: float, slowest: float, left: float) -> float:
    """Towards what is left; no slower than the base can move, and never backwards to it."""
    return math.copysign(max(abs(wanted), slowest), left) if wanted * left > 0.0 else math.copysign(slowest, left)
