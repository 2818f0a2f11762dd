"""Plays an exploration on a simulated clock: events in, commands out, a robot that does at once what it is told."""

import math
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from contracts.exploration import ExplorationDecision, ExplorationMode, MoveToward
from contracts.geometry import Pose2D
from contracts.motion import MotionEnd
from coordinator.exploration import commands as do
from coordinator.exploration import events as ev
from coordinator.exploration.exploration import Exploration
from coordinator.exploration.frontiers import Chart, chart_of
from coordinator.exploration.rules import ExplorationRules
from coordinator.exploration.step import step
from coordinator.exploration.surroundings import Surroundings
from geometry.grids import OccupancyGrid

HOME = Pose2D(x=0.0, y=0.0, yaw=0.0)
TICK_S = 0.2
C = TypeVar("C")

FREE = np.empty((0, 2))
WALL_AHEAD = np.array([(0.6, y) for y in np.linspace(-0.3, 0.3, 20)])


def open_chart() -> Chart:
    """8 m x 8 m of known free space, unknown all round: one long frontier."""
    cells = np.full((400, 400), -1, np.int8)
    cells[120:280, 120:280] = 0
    return chart_of(OccupancyGrid(cells, 0.05, Pose2D(x=-10.0, y=-10.0, yaw=0.0)), HOME, 0.19)


def closed_chart() -> Chart:
    cells = np.full((400, 400), 100, np.int8)
    cells[120:280, 120:280] = 0
    return chart_of(OccupancyGrid(cells, 0.05, Pose2D(x=-10.0, y=-10.0, yaw=0.0)), HOME, 0.19)


class Played:
    """`obeys`: motions end at once where they were to lead. Without it the test ends them."""

    def __init__(self, rules: ExplorationRules | None = None, *, obeys: bool = True) -> None:
        self.now_s = 1000.0
        self.exploration = Exploration(rules=rules or ExplorationRules())
        self.pose: Pose2D | None = HOME
        self.points_m = FREE
        self.silent_rad: tuple[tuple[float, float], ...] = ()
        self.scan_age_s = 0.0
        self.stopped = False
        self.obeys = obeys
        self.commands: list[tuple[float, do.Command]] = []
        self._obeyed = 0
        self.view = 0
        self.sees = True
        """A new view wherever the robot goes."""

    @property
    def mode(self) -> ExplorationMode:
        return self.exploration.mode

    def tell(self, event: ev.Event) -> tuple[do.Command, ...]:
        self.exploration, commands = step(self.exploration, event, self.now_s)
        self.commands += [(self.now_s, one) for one in commands]
        return commands

    def begin(self, chart: Chart | None = None) -> "Played":
        self.look()
        if chart is not None:
            self.tell(ev.ChartSeen(chart))
        self.tell(ev.Begun(HOME))
        return self

    def look(self) -> None:
        scan = Surroundings(self.now_s - self.scan_age_s, self.points_m, self.silent_rad)
        self.tell(ev.RobotSeen(self.pose, scan, self.stopped))
        if self.sees and self.pose is not None:
            key = (round(self.pose.x, 2), round(self.pose.y, 2), round(self.pose.yaw, 2))
            self.view = hash(key) & (2**64 - 1)
            self.tell(ev.ViewSeen(self.view))

    def pass_time(self, seconds: float, until: Callable[[], bool] = lambda: False) -> "Played":
        """In ticks; motions are obeyed a tick after they were asked for."""
        end_s = self.now_s + seconds
        while self.now_s < end_s - 1e-9 and not until():
            self.now_s = min(end_s, self.now_s + TICK_S)
            self.look()
            self.tell(ev.TimePassed())
            if self.obeys:
                self.obey()
        return self

    def obey(self) -> None:
        waiting, self._obeyed = self.commands[self._obeyed :], len(self.commands)
        for _, command in waiting:
            match command:
                case do.TurnRobot(call=call, angle_rad=angle_rad) if self.pose is not None:
                    yaw = math.remainder(self.pose.yaw + angle_rad, 2 * math.pi)
                    self.pose = Pose2D(x=self.pose.x, y=self.pose.y, yaw=yaw)
                    self.tell(ev.MotionOver(call, MotionEnd.COMPLETED))
                case do.DriveRobot(call=call, distance_m=distance_m) if self.pose is not None:
                    x = self.pose.x + distance_m * math.cos(self.pose.yaw)
                    y = self.pose.y + distance_m * math.sin(self.pose.yaw)
                    self.pose = Pose2D(x=x, y=y, yaw=self.pose.yaw)
                    self.tell(ev.MotionOver(call, MotionEnd.COMPLETED))
                case do.NavigateRobot(call=call, pose=pose):
                    self.pose = pose
                    self.tell(ev.GoalOver(call, ev.GoalOutcome.REACHED))
                case _:
                    pass

    def told(self, kind: type[C]) -> list[C]:
        return [one for _, one in self.commands if isinstance(one, kind)]

    @property
    def last_asked(self) -> do.AskModel:
        return self.told(do.AskModel)[-1]

    def answer(self, decision: ExplorationDecision | None, tokens: int = 10) -> tuple[do.Command, ...]:
        return self.tell(ev.ModelAnswered(self.last_asked.call, decision, tokens))

    def modes(self) -> list[ExplorationMode]:
        return [one.mode for one in self.told(do.TellMode)]


def ahead(distance_m: float = 1.0) -> MoveToward:
    return MoveToward(bearing_rad=0.0, distance_m=distance_m)
