"""What goes wrong at the robot, drawn from a seed: Nav2 rejects, gives up or claims too much, and depth lies."""

import math
from dataclasses import dataclass, field
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray

from bench.world.faults import Faults
from contracts.robot import GoalStatus
from robot_bridge.ports import GoalEnd
from sim.world import CameraModel, World
from sim.world.world import Moment

NO_PATH: Final = 208
CONTROLLER_PATIENCE: Final = 104
PLANNER_FAILED: Final = (202, 207, 208)
LIES: Final = (0.5, 0.65, 1.5, 2.0)
"""Factors on every depth of a picture that lies."""
SOON_S, LATE_S = 1.0, 20.0
"""When Nav2 ends a goal otherwise than by getting there, s after it began."""


@dataclass
class RobotTroubles:
    """Nothing goes wrong before `begins_s`, on the loop's own clock."""

    faults: Faults = field(default_factory=Faults)
    seed: int = 0
    begins_s: float = math.inf

    def __post_init__(self) -> None:
        self._nav2, self._depth = (np.random.default_rng([self.seed, 410 + part]) for part in range(2))

    def rejects(self, now_s: float) -> bool:
        return self._happens(self.faults.goal_rejected, now_s)

    def hides_path(self, now_s: float) -> bool:
        """The planner says that no path leads where one does."""
        return self._happens(self.faults.path_lie, now_s)

    def ends_instead(self, now_s: float) -> tuple[float, GoalEnd] | None:
        """After how long, s, a goal that began now ends how; none where it ends as it does."""
        faults, rng = self.faults, self._nav2
        if self._happens(faults.goal_aborted_2xx, now_s):
            return 0.2, GoalEnd(GoalStatus.ABORTED, int(rng.choice(PLANNER_FAILED)))
        if self._happens(faults.goal_aborted_104, now_s):
            return float(rng.uniform(SOON_S, LATE_S)), GoalEnd(GoalStatus.ABORTED, CONTROLLER_PATIENCE)
        if self._happens(faults.goal_false_success, now_s):
            return float(rng.uniform(SOON_S, LATE_S)), GoalEnd(GoalStatus.SUCCEEDED, 0)
        return None

    def depth_of(self, world: World, now_s: float) -> World:
        """What the depth camera looks at now."""
        if now_s < self.begins_s or not self.faults.depth_lie or self._depth.random() >= self.faults.depth_lie:
            return world
        return cast("World", DepthLies(world, float(self._depth.choice(LIES))))  # all of it that a depth camera asks

    def _happens(self, chance: float, now_s: float) -> bool:
        return chance > 0.0 and now_s >= self.begins_s and self._nav2.random() < chance


@dataclass(frozen=True)
class DepthLies:
    """A World whose depths are all wrong by one factor."""

    world: World
    factor: float

    @property
    def depth_camera(self) -> CameraModel:
        return self.world.depth_camera

    def moment(self) -> "LyingMoment":
        return LyingMoment(self.world.moment(), self.factor)


@dataclass(frozen=True)
class LyingMoment:
    moment: Moment
    factor: float

    def depth(self) -> NDArray[np.float32]:
        return (self.moment.depth() * self.factor).astype(np.float32)
