"""What ros2_control's controllers make of a goal, pure: time and the joints as measured are passed in.

The arm's is a joint_trajectory_controller, the gripper's a gripper_action_controller, each with its habits: a canceled
or ended goal leaves the joints where they are; a gripper that stalls on something aborts, and says `stalled`.
"""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

from sim.world.arm.trajectory import Trajectory

GOAL_TOLERANCE_RAD: Final = 0.05
GOAL_TIME_S: Final = 2.0
"""So long after its end a trajectory's last point may be reached."""
GRIPPER_TOLERANCE_RAD: Final = 0.02
STALL_RAD_S: Final = 0.02
STALL_S: Final = 0.5
"""A jaw slower than that for so long has stalled."""


class Outcome(StrEnum):
    """How the newest goal stands."""

    IDLE = "idle"
    """There has been none."""
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    HELD = "held"
    """It was ended from outside."""
    PATH_TOLERANCE = "path_tolerance"
    """A joint was further from the path than the goal permits."""
    GOAL_TOLERANCE = "goal_tolerance"
    """A joint was not where it is to end in time."""
    STALLED = "stalled"
    """The jaw moves no further, and is not where it was sent."""


@dataclass(frozen=True, slots=True)
class Tolerances:
    """Of one goal, rad by joint in the controller's order; 0 = none said, negative = any."""

    path_rad: tuple[float, ...] = ()
    goal_rad: tuple[float, ...] = ()
    goal_time_s: float = GOAL_TIME_S


@dataclass(slots=True)
class _Following:
    trajectory: Trajectory
    start: tuple[float, ...]
    began_s: float
    tolerances: Tolerances


@dataclass(slots=True)
class TrajectoryController:
    """`wanted` is where the servos are sent, rad."""

    wanted: tuple[float, ...]
    outcome: Outcome = field(default=Outcome.IDLE, init=False)
    _now: _Following | None = field(default=None, init=False)

    def follow(self, trajectory: Trajectory, tolerances: Tolerances, now_s: float) -> None:
        """A newer goal replaces an older one. Its joints are in the controller's order, and it is valid."""
        self._now, self.outcome = _Following(trajectory, self.wanted, now_s, tolerances), Outcome.RUNNING

    def hold(self, measured: tuple[float, ...]) -> None:
        """A trajectory under way ends, and the joints stay where they are."""
        if self._now is not None:
            self._end(Outcome.HELD, measured)

    def tick(self, now_s: float, measured: tuple[float, ...]) -> None:
        """Moves `wanted` on. After an end the joints are held."""
        following = self._now
        if following is None:
            return
        elapsed_s, duration_s = now_s - following.began_s, following.trajectory.duration_s
        self.wanted = following.trajectory.at(elapsed_s, following.start)
        off = tuple(abs(is_ - to) for is_, to in zip(measured, self.wanted, strict=True))
        if elapsed_s < duration_s:
            if _beyond(off, following.tolerances.path_rad, default=-1.0):
                self._end(Outcome.PATH_TOLERANCE, measured)
        elif not _beyond(off, following.tolerances.goal_rad, default=GOAL_TOLERANCE_RAD):
            self._end(Outcome.SUCCEEDED, self.wanted)
        elif elapsed_s > duration_s + following.tolerances.goal_time_s:
            self._end(Outcome.GOAL_TOLERANCE, measured)

    def _end(self, outcome: Outcome, stay: tuple[float, ...]) -> None:
        self._now, self.outcome, self.wanted = None, outcome, stay


def _beyond(off: tuple[float, ...], said: tuple[float, ...], *, default: float) -> bool:
    """Whether a joint is further off than it may be; a negative limit is none."""
    limits = [limit or default for limit in said or (0.0,) * len(off)]
    return any(0.0 <= limit < each for each, limit in zip(off, limits, strict=True))


@dataclass(slots=True)
class GripperController:
    """`wanted` is where the jaw is sent, rad; `max_effort` how hard it may press, Nm (0 = as hard as it can)."""

    wanted: float
    max_effort: float = 0.0
    outcome: Outcome = field(default=Outcome.IDLE, init=False)
    _moved_s: float = field(default=0.0, init=False)

    def grip(self, position: float, max_effort: float, now_s: float) -> None:
        """A newer goal replaces an older one."""
        self.wanted, self.max_effort = position, max_effort
        self.outcome, self._moved_s = Outcome.RUNNING, now_s

    def hold(self, measured: float) -> None:
        """Stays where it is, where a goal is under way; what is held already is held on to."""
        if self.outcome is Outcome.RUNNING:
            self.outcome, self.wanted = Outcome.HELD, measured

    def tick(self, now_s: float, position: float, velocity: float) -> None:
        """A stalled jaw goes on pressing."""
        if self.outcome is not Outcome.RUNNING:
            return
        if abs(position - self.wanted) <= GRIPPER_TOLERANCE_RAD:
            self.outcome = Outcome.SUCCEEDED
        elif abs(velocity) > STALL_RAD_S:
            self._moved_s = now_s
        elif now_s - self._moved_s > STALL_S:
            self.outcome = Outcome.STALLED
