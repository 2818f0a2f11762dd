"""The stand-in for Nav2's navigator: plans, follows, waits where it is blocked, plans again, gives up by the rules."""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D, Twist2D
from sim.nav.codes import Code, NavigationError
from sim.nav.costmap import Costmap
from sim.nav.follower import STILL, Follower, Following, Limits
from sim.nav.obstacles import ObstacleLayer, hits_m
from sim.nav.planner import TOLERANCE_M, Path, plan
from sim.world.types import Scan

_LOCAL_RANGE_M: Final = 1.5
_UNBLOCKED_M: Final = 0.1
_NOTHING: Final = np.empty((0, 2))


@dataclass(frozen=True)
class Patience:
    """When to plan again and when to give up."""

    replan_s: float = 1.0
    blocked_s: float = 8.0
    stuck_s: float = 10.0
    moved_m: float = 0.5
    """In `stuck_s`; turning is no progress."""
    lost_one_in: int = 0
    """Of so many replannings one is not taken by the controller in time: ABORTED without a code. 0 = none."""


class Outcome(StrEnum):
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    ABORTED = "aborted"


@dataclass(frozen=True)
class Progress:
    """How a goal is doing; `twist` is what the stand-in wants on `cmd_vel_nav`."""

    outcome: Outcome
    twist: Twist2D = STILL
    remaining_m: float = 0.0
    recoveries: int = 0
    code: Code = Code.NONE
    detail: str = ""


@dataclass
class _Goal:
    """The goal under way and what has happened to it."""

    pose: Pose2D
    follower: Follower
    marked: Pose2D
    marked_s: float
    blocked_since_s: float | None = None
    replanned_s: float = -math.inf
    handed_on_s: float = 0.0
    """When the tree last handed a new plan to the controller."""
    recoveries: int = 0


class Navigator:
    """One robot's navigation. All poses are in the map frame, all times on one clock (here: simulated)."""

    def __init__(
        self,
        static: Costmap,
        *,
        limits: Limits | None = None,
        patience: Patience | None = None,
        tolerance_m: float = TOLERANCE_M,
    ) -> None:
        """`tolerance_m` is the planner's: how far from an occupied goal a path may end."""
        self._static = static
        self._tolerance_m = tolerance_m
        self._replannings = 0
        self._limits = limits or Limits()
        self._patience = patience or Patience()
        self._layer = ObstacleLayer(static)
        self._costmap = static
        self._local_m: NDArray[np.float64] = _NOTHING
        self._goal: _Goal | None = None

    @property
    def costmap(self) -> Costmap:
        """The newest global costmap: the static map and what the laser added. Immutable: any thread may plan on it."""
        return self._costmap

    @property
    def path(self) -> Path | None:
        return self._goal.follower.path if self._goal else None

    def observe(self, scan: Scan, laser: Pose2D) -> None:
        """One scan; `laser` is the laser's pose in the map when it was taken."""
        self._local_m = hits_m(scan, laser, range_max_m=_LOCAL_RANGE_M)
        if self._layer.observe(scan, laser):
            self._costmap = self._static.with_obstacles(self._layer.marked)

    def take_map(self, static: Costmap) -> None:
        """Another static map, as from SLAM: the goal goes on, and what the laser adds is seen anew."""
        self._static = static
        self._layer = ObstacleLayer(static)
        self._costmap = static

    def clear_global(self) -> None:
        """Forgets what the laser added to the global costmap."""
        self._layer.clear()
        self._costmap = self._static

    def clear_local(self) -> None:
        """Forgets what the laser last saw round the robot; the next scan brings it back where it is real."""
        self._local_m = _NOTHING

    def plan(self, start: Pose2D, goal: Pose2D) -> Path:
        """On the newest global costmap, from any thread. Raises `NavigationError` (2xx) when no path leads there."""
        return plan(self._costmap, start, goal, tolerance_m=self._tolerance_m)

    def start(self, goal: Pose2D, pose: Pose2D, now_s: float) -> None:
        """Takes a new goal in place of any other. Raises `NavigationError` (2xx) when no path leads there."""
        self._goal = None
        follower = Follower(self.plan(pose, goal), self._limits)
        self._goal = _Goal(goal, follower, pose, now_s, handed_on_s=now_s)

    def cancel(self) -> None:
        self._goal = None

    def step(self, pose: Pose2D, now_s: float) -> Progress:
        """What to do now, called at about 20 Hz while a goal is under way. Raises nothing; an abort is a `Progress`."""
        goal = self._goal
        if goal is None:
            return Progress(Outcome.ABORTED, code=Code.UNKNOWN, detail="there is no goal")
        command = goal.follower.step(pose, self._seen_from(pose))
        if command.following is Following.ARRIVED:
            self._goal = None
            return Progress(Outcome.SUCCEEDED, recoveries=goal.recoveries)
        waits = command.following is Following.BLOCKED
        failure = self._lost(goal, now_s) or (self._wait if waits else self._drive)(goal, pose, now_s)
        if failure is not None:
            self._goal = None
            return Progress(Outcome.ABORTED, recoveries=goal.recoveries, code=failure.code, detail=failure.detail)
        return Progress(Outcome.RUNNING, command.twist, command.remaining_m, goal.recoveries)

    def _wait(self, goal: _Goal, pose: Pose2D, now_s: float) -> NavigationError | None:
        """Blocked: looks for another way now and then, until patience ends."""
        if goal.blocked_since_s is None:
            goal.blocked_since_s = now_s
        if now_s - goal.blocked_since_s > self._patience.blocked_s:
            return NavigationError(Code.PATIENCE_EXCEEDED, "an obstacle kept blocking the way")
        goal.marked, goal.marked_s = pose, now_s
        if now_s - goal.replanned_s >= self._patience.replan_s:
            goal.replanned_s = now_s
            try:
                path = self.plan(pose, goal.pose)
            except NavigationError:
                return None  # wait: the obstacle may go away
            goal.recoveries += 1
            goal.follower = Follower(path, self._limits)
        return None

    def _drive(self, goal: _Goal, pose: Pose2D, now_s: float) -> NavigationError | None:
        """Driving: has the robot moved lately?"""
        patience = self._patience
        moved_m = math.hypot(pose.x - goal.marked.x, pose.y - goal.marked.y)
        if moved_m > _UNBLOCKED_M:
            goal.blocked_since_s = None
        if moved_m > patience.moved_m:
            goal.marked, goal.marked_s = pose, now_s
        elif now_s - goal.marked_s > patience.stuck_s:
            return NavigationError(Code.FAILED_TO_MAKE_PROGRESS, f"did not move for {patience.stuck_s:.0f} s")
        return None

    def _lost(self, goal: _Goal, now_s: float) -> NavigationError | None:
        """Once a second the tree hands a new plan on, and fails without a code where nobody takes it in time."""
        if now_s - goal.handed_on_s < self._patience.replan_s:
            return None
        goal.handed_on_s = now_s
        self._replannings += 1
        if self._patience.lost_one_in and self._replannings % self._patience.lost_one_in == 0:
            return NavigationError(Code.NONE, "the controller did not take the new plan in time")
        return None

    def _seen_from(self, pose: Pose2D) -> NDArray[np.float64]:
        """(N, 2) the newest scan's points in the frame of a robot standing at `pose`."""
        if not len(self._local_m):
            return self._local_m
        offset = self._local_m - (pose.x, pose.y)
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        return np.stack([c * offset[:, 0] + s * offset[:, 1], -s * offset[:, 0] + c * offset[:, 1]], axis=-1)
