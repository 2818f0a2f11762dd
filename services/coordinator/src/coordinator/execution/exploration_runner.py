"""Plays an exploration: what the robot senses becomes events, commands become calls, each failure an event."""

import asyncio
import math
from collections.abc import Awaitable, Callable, Coroutine
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar, assert_never

import numpy as np
import structlog

from contracts.causes import GoalCause
from contracts.exploration import ExplorationEnd, ExplorationMemory
from contracts.geometry import Pose2D
from contracts.laser import LaserScan
from contracts.motion import MotionEnd
from contracts.obstacles import Obstacles
from contracts.robot import CandidatePose, Goal, GoalRequest, GoalStatus
from coordinator.execution.motion_client import MotionClient
from coordinator.exploration import commands as do
from coordinator.exploration import events as ev
from coordinator.exploration.exploration import Exploration
from coordinator.exploration.frontiers import chart_of
from coordinator.exploration.rules import ExplorationRules
from coordinator.exploration.step import step
from coordinator.exploration.surroundings import Surroundings
from coordinator.exploration_ports import ExploringRobot, Eye, Journal, Pilot
from geometry.grids import MapError, decode
from mesh.clock import Clock
from mesh.errors import MeshError, UnavailableError
from mesh.tasks import Tasks

log = structlog.get_logger()

LOOK_S = 0.2
"""Between two looks at the robot's state and scan."""
CHART_S = 2.0
VIEW_S = 1.0
TURN_RAD_S = 1.0
TURN_TIMEOUT_S = 15.0
GOAL_POLL_S = 1.0
ENDED_BY_OTHERS = frozenset({GoalStatus.REJECTED, GoalStatus.CANCELED})
T = TypeVar("T")


class ExplorationRunner:
    """`run` for ever; `begin`, `listen`, `cancel` from outside. One exploration at a time, and no mission beside it.

    `motion` is its owner's where others move the robot by turns with it. `told` hears who leads, what is
    remembered, and the end.
    """

    def __init__(
        self,
        robot: ExploringRobot,
        pilot: Pilot,
        *,
        rules: ExplorationRules,
        clock: Clock,
        tasks: Tasks,
        journal: Journal,
        eye: Eye | None = None,
        motion: MotionClient | None = None,
        told: Callable[[do.TellMode | do.Remember | do.Finish], None] = lambda _: None,
    ) -> None:
        self.goals_reached = 0
        self.exploration = Exploration(rules=rules)
        self.ended = asyncio.Event()
        self._robot = robot
        self._pilot = pilot
        self._clock = clock
        self._tasks = tasks
        self._journal = journal
        self._eye = eye
        self._told = told
        self._asking: set[asyncio.Task[None]] = set()
        self.home: str | None = None
        """The map that the exploration began in, and what is remembered belongs to; none = it has no name."""
        self._motion = motion or MotionClient(
            robot, clock, self._spawn, goal_poll_s=GOAL_POLL_S, on_lease=_no_lease
        )  # fmt: skip

    async def run(self) -> None:
        """For ever. Its owner keeps the robot's session open besides.

        Each sense is asked at its own pace: one that is slow to answer holds up neither the others nor the time.
        """
        async with asyncio.TaskGroup() as senses:
            senses.create_task(self._each(LOOK_S, self._look))
            senses.create_task(self._each(LOOK_S, self._pass_time))
            senses.create_task(self._each(CHART_S, self._chart))
            if self._eye is not None:
                senses.create_task(self._each(VIEW_S, partial(self._view, self._eye)))

    async def _each(self, pause_s: float, work: Callable[[], Awaitable[None]]) -> None:
        while True:
            await work()
            await self._clock.sleep(pause_s)

    async def begin(self, home: Pose2D, still: Callable[[], bool] = lambda: True) -> None:
        """With what is remembered of this map; without it where the journal is away. Of a map without a name nothing is
        remembered, and nothing is kept. Nothing begins where it is not `still` wanted once that was read."""
        map_id = self.exploration.map_id
        memory = await self._remembered(map_id)
        while map_id != self.exploration.map_id:  # it was named, or changed, meanwhile
            map_id = self.exploration.map_id
            memory = await self._remembered(map_id)
        if not still():
            return
        if not self.exploration.running:
            self.home = map_id
            self.goals_reached = 0
            self.exploration = replace(self.exploration, memory=memory)
        self.ended.clear()
        self.feed(ev.Begun(home))

    async def _remembered(self, map_id: str | None) -> ExplorationMemory:
        if map_id is None:
            return ExplorationMemory()
        try:
            return await self._journal.read(map_id)
        except UnavailableError as error:
            log.warning("an exploration begins without what was remembered", error=error.detail)
            return ExplorationMemory()

    def listen(self, for_s: float) -> None:
        self.feed(ev.ListenStarted(for_s))
        self._ask_no_more()

    def heard(self) -> None:
        self.feed(ev.ListenEnded())

    def cancel(self) -> None:
        self.feed(ev.ExplorationCanceled())
        self._ask_no_more()

    def link(self, *, up: bool) -> None:
        """Whoever watches the network to the model says so."""
        self.feed(ev.LinkChanged(up))

    def feed(self, event: ev.Event) -> None:
        self.exploration, commands = step(self.exploration, event, self._clock.now_s())
        for command in commands:
            self._act(command)

    # what comes in

    @property
    def _epoch(self) -> int:
        """The core's: a stop that it has not been told of yet refuses what it asks for."""
        return self.exploration.epoch or 0

    async def _pass_time(self) -> None:
        self.feed(ev.TimePassed())

    async def _view(self, eye: Eye) -> None:
        self.feed(ev.ViewSeen(await eye.view()))

    async def _look(self) -> None:
        """A robot that tells nothing has neither pose nor scan."""
        try:
            state = await self._robot.state()
        except MeshError:
            self.feed(ev.RobotSeen(None, None, stopped=self.exploration.stopped))
            return
        stop = state.emergency_stop
        seen = ev.RobotSeen(state.pose, None, stop.latched, stop.epoch, state.map_id)
        if seen.stopped or seen.epoch != self.exploration.epoch:
            self.feed(seen)  # before anything else is asked, which may take its time
        scan = None
        with suppress(MeshError):
            scan = surroundings_of(await self._robot.scan(), await self._robot.obstacles())
        self.feed(replace(seen, surroundings=scan))

    async def _chart(self) -> None:
        while (pose := self.exploration.pose) is None:
            await self._clock.sleep(LOOK_S)
        map_id = self.exploration.map_id
        try:
            grid = decode(await self._robot.map())
        except (MeshError, MapError) as error:
            log.warning("an exploration goes on without the newest map", error=str(error))
            return
        radius_m = self.exploration.rules.limits.footprint_radius_m
        chart = await asyncio.to_thread(chart_of, grid, pose, radius_m)
        if self.exploration.map_id == map_id:  # else it is of another home
            self.feed(ev.ChartSeen(chart))

    # what goes out

    def _act(self, command: do.Command) -> None:
        epoch = self._epoch
        match command:
            case do.AskModel():
                asking = self._spawn(self._ask(command))
                self._asking.add(asking)
                asking.add_done_callback(self._asking.discard)
            case do.TurnRobot(call=call, angle_rad=angle_rad):
                self._start(call, lambda: self._turn(angle_rad, epoch))
            case do.DriveRobot(call=call, distance_m=distance_m, speed_m_s=speed_m_s):
                self._start(call, lambda: self._drive(distance_m, speed_m_s, epoch))
            case do.NavigateRobot(call=call, pose=pose):
                self._motion.start(lambda: self._navigate(call, pose, epoch), epoch)
            case do.HaltMotion():
                self._motion.stop(epoch)
            case do.Remember(memory=memory):
                if self.home is not None:
                    self._journal.write(self.home, memory)
                self._told(command)
            case do.TellMode(mode=mode, why=why):
                log.info("exploration", mode=mode.value, why=why)
                self._told(command)
            case do.Finish(end=end):
                self._finished(end)
                self._told(command)
            case _:
                assert_never(command)

    def _finished(self, end: ExplorationEnd) -> None:
        log.info("the exploration is over", end=end.value)
        self._ask_no_more()
        self.ended.set()

    def _ask_no_more(self) -> None:
        """The server need not think on: nobody waits for its answer."""
        for asking in self._asking:
            asking.cancel()

    async def _ask(self, question: do.AskModel) -> None:
        limit_s = self.exploration.rules.asking.answer_s
        try:
            async with asyncio.timeout(limit_s):
                answer = await self._pilot.decide(question)
        except (MeshError, TimeoutError) as error:
            self.feed(ev.ModelFailed(question.call, str(error)))
            return
        self.feed(ev.ModelAnswered(question.call, answer.decision, answer.tokens, answer.detail))

    def _start(self, call: int, move: Callable[[], Awaitable[MotionEnd]]) -> None:
        async def work() -> None:
            self.feed(ev.MotionOver(call, await self._taken(move)))

        self._motion.start(work, self._epoch)

    async def _taken(self, move: Callable[[], Awaitable[T]]) -> T | None:
        """None where it was refused, or not answered: then it may be moving all the same, and is stopped."""
        try:
            return await move()
        except UnavailableError as error:
            log.warning("a motion of the exploration was not answered", error=error.detail)
            self._motion.mark_uncertain(self._epoch)
        except MeshError as error:
            log.warning("a motion of the exploration was refused", error=error.detail)
        return None

    async def _turn(self, angle_rad: float, epoch: int) -> MotionEnd:
        reply = await self._robot.rotate(angle_rad, speed_rad_s=TURN_RAD_S, timeout_s=TURN_TIMEOUT_S, epoch=epoch)
        return reply.end

    async def _drive(self, distance_m: float, speed_m_s: float, epoch: int) -> MotionEnd:
        timeout_s = 4.0 + 2.5 * distance_m / speed_m_s
        reply = await self._robot.drive(distance_m, speed_m_s=speed_m_s, timeout_s=timeout_s, epoch=epoch)
        return reply.end

    async def _navigate(self, call: int, pose: Pose2D, epoch: int) -> None:
        request = GoalRequest(
            candidates=(CandidatePose(pose=pose),),
            epoch=epoch,
            timeout_s=self.exploration.rules.goal_s_max,
        )
        outcome = outcome_of(await self._taken(lambda: self._motion.navigate(request)))
        self.goals_reached += outcome is ev.GoalOutcome.REACHED
        self.feed(ev.GoalOver(call, outcome))

    def _spawn(self, work: Coroutine[Any, Any, Any]) -> "asyncio.Task[Any]":
        return self._tasks.start("exploration", work, forever=False)


def outcome_of(goal: Goal | None) -> ev.GoalOutcome:
    """None: the goal was not taken."""
    if goal is None or goal.status in ENDED_BY_OTHERS or goal.cause is GoalCause.NAV2_GONE:
        return ev.GoalOutcome.FAILED
    return ev.GoalOutcome.REACHED if goal.status is GoalStatus.SUCCEEDED else ev.GoalOutcome.NOT_REACHED


def surroundings_of(scan: LaserScan, around: Obstacles) -> Surroundings:
    """The scan, and the sectors of the ring about which no beam says anything."""
    half_rad = math.pi / max(1, len(around.ring))
    silent = tuple((one.bearing_rad - half_rad, one.bearing_rad + half_rad) for one in around.ring if one.label is None)
    return Surroundings(scan.stamp_s, np.array(scan.points_m, np.float64).reshape(-1, 2), silent)


def _no_lease(_: MotionEnd) -> None:
    """No leases are asked for here."""
