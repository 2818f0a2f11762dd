"""One step under way: the exploration as it has become so far, and the commands so far."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from contracts.exploration import DecisionVerdict, DoneAction, ExplorationEnd, ExplorationMode
from contracts.geometry import Pose2D
from coordinator.exploration import commands as do
from coordinator.exploration import remembering
from coordinator.exploration.decision_check import Advance, Knowledge
from coordinator.exploration.exploration import Advancing, Exploration, Going, Settling, Standing, Turning
from coordinator.exploration.transitions import ALLOWED, ForbiddenModeError
from geometry.poses import wrap

LITTLE_RAD = 0.05
"""Less is not turned by before a drive."""
DROPPED_KEPT = 50


class Context:
    """Mutable for one `step` only."""

    def __init__(self, exploration: Exploration, now_s: float) -> None:
        self.exploration = exploration
        self.now_s = now_s
        self.commands: list[do.Command] = []

    def update(self, **changes: Any) -> None:
        self.exploration = replace(self.exploration, **changes)

    def tell(self, command: do.Command) -> None:
        self.commands.append(command)

    def take_call(self) -> int:
        call = self.exploration.next_call
        self.update(next_call=call + 1)
        return call

    def become(self, mode: ExplorationMode, why: str, **changes: Any) -> None:
        """Raises `ForbiddenModeError`."""
        if mode not in ALLOWED[self.exploration.mode]:
            raise ForbiddenModeError(f"{self.exploration.mode} to {mode} ({why})")
        self.update(mode=mode, why=why, **changes)
        self.tell(do.TellMode(mode, why))

    def finish(self, end: ExplorationEnd, why: str) -> None:
        self.halt()
        self.drop_question()
        self.become(ExplorationMode.IDLE, why, end=end, silent_since_s=None, fallback=None)
        self.tell(do.Finish(end))

    @property
    def knowledge(self) -> Knowledge:
        one = self.exploration
        return Knowledge(one.surroundings, one.pose, one.chart, one.told, one.tries, self.now_s)

    def drop_question(self) -> None:
        """Nobody waits for its answer any more. What it was waited for counts."""
        one, question = self.exploration, self.exploration.question
        if question is None:
            return
        seconds = one.spent.seconds + max(0.0, self.now_s - question.asked_s)
        dropped = (*one.dropped, question.call)[-DROPPED_KEPT:]
        self.update(question=None, dropped=dropped, spent=replace(one.spent, seconds=seconds))

    # motion

    def halt(self) -> None:
        """Whatever moves ends now; its answer will be too late."""
        if self.exploration.moving:
            self.tell(do.HaltMotion())
        self.update(activity=Standing())

    def turn(self, angle_rad: float, tool: str, then: Advance | None = None) -> None:
        call = self.take_call()
        until_s = self.now_s + self.exploration.rules.turn_s_max
        self.update(activity=Turning(call, until_s, tool, then))
        self.tell(do.TurnRobot(call, wrap(angle_rad)))

    def advance(self, motion: Advance, tool: str) -> None:
        """Turns first; what follows waits for a scan taken after the turn."""
        if abs(motion.bearing_rad) > LITTLE_RAD:
            self.turn(motion.bearing_rad, tool, Advance(0.0, motion.distance_m, motion.speed_m_s))
        else:
            self.settle(motion, tool)

    def settle(self, motion: Advance, tool: str) -> None:
        until_s = self.now_s + self.exploration.rules.settle_s_max
        self.update(activity=Settling(self.now_s, until_s, tool, Advance(0.0, motion.distance_m, motion.speed_m_s)))

    def drive(self, motion: Advance, tool: str) -> None:
        """Straight ahead, at once: the caller has checked it against a scan of now."""
        call, pose = self.take_call(), self.exploration.pose
        heading = pose.yaw if pose is not None else 0.0
        until_s = self.now_s + 5.0 + 3.0 * motion.distance_m / motion.speed_m_s
        self.update(activity=Advancing(call, until_s, tool, heading))
        self.tell(do.DriveRobot(call, motion.distance_m, motion.speed_m_s))

    def go_to(self, pose: Pose2D, tool: str) -> None:
        call = self.take_call()
        self.update(activity=Going(call, self.now_s + self.exploration.rules.goal_s_max, tool, pose))
        self.tell(do.NavigateRobot(call, pose))

    # memory

    def remember_action(self, tool: str, verdict: DecisionVerdict, end: str = "") -> None:
        """Once an action, it is written down."""
        action = DoneAction(tool=tool, verdict=verdict, end=end, by=self.exploration.mode)
        self.update(memory=remembering.done(self.exploration.memory, action))
        self.tell(do.Remember(self.exploration.memory))

    def count(self, verdict: DecisionVerdict) -> None:
        counts: Mapping[DecisionVerdict, int] = dict(self.exploration.verdicts)
        self.update(verdicts=tuple({**counts, verdict: counts.get(verdict, 0) + 1}.items()))
