"""Navigation goals as they stand, each change told; and what is known of the one under way."""

import asyncio
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field

from contracts.robot import Goal, GoalStatus
from mesh.errors import NotFoundError
from robot_bridge.navigation.goal_phases import FOLLOWS, Asking, Phase
from robot_bridge.navigation.goal_states import with_status
from robot_bridge.navigation.path_check import GoalRegion

GOALS_KEPT = 200
PROGRESS_S = 0.5


@dataclass(slots=True)
class ActiveGoal:
    """The one goal that may be under way."""

    goal_id: str
    region: GoalRegion
    epoch: int
    session_id: str | None
    begun_s: float
    deadline_s: float
    state: Phase = field(default_factory=Asking)
    progress_told_s: float | None = None
    over: asyncio.Event = field(default_factory=asyncio.Event)

    def become(self, state: Phase) -> None:
        if state.phase not in FOLLOWS[self.state.phase]:
            raise RuntimeError(f"a goal cannot be {state.phase} after it was {self.state.phase}")
        self.state = state


class GoalStore:
    """The newest state of the last 200. `publish` hears every change, and progress about twice a second."""

    def __init__(self, publish: Callable[[Goal], None]) -> None:
        self._publish = publish
        self._by_id: OrderedDict[str, Goal] = OrderedDict()

    def get(self, goal_id: str) -> Goal:
        """Raises `NotFoundError`."""
        if (goal := self._by_id.get(goal_id)) is None:
            raise NotFoundError(f"no goal {goal_id[:64]}")
        return goal

    def keep(self, goal: Goal) -> None:
        self._by_id[goal.id] = goal
        while len(self._by_id) > GOALS_KEPT:
            self._by_id.popitem(last=False)
        self._publish(goal)

    def progress(self, active: ActiveGoal, left_m: float, now_s: float) -> None:
        """Metres left. Nav2 says 0.0 as long as it has no path: that is not told."""
        goal = self.get(active.goal_id)
        if left_m <= 0.0 and goal.distance_remaining_m is None:
            return
        told_s = active.progress_told_s
        if goal.status is GoalStatus.EXECUTING and (told_s is None or now_s - told_s >= PROGRESS_S):
            active.progress_told_s = now_s
            self.keep(with_status(goal, goal.status, stamp_s=now_s, distance_remaining_m=max(0.0, left_m)))
