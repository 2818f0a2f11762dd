"""The exploration of a mission: begun, held and ended as the mission says, and told of as its events and status."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass

from contracts.description import RobotDescription
from contracts.exploration import DISCOVERIES_TOLD, Discovery, ExplorationEnd, ExplorationMode, ExplorationStatus
from contracts.mission import MissionState
from coordinator.core import actions as act
from coordinator.core import events as ev
from coordinator.core.activities import UnderExploration
from coordinator.core.mission import Mission
from coordinator.execution.exploration_runner import LOOK_S, ExplorationRunner
from coordinator.execution.motion_client import MotionClient
from coordinator.exploration import commands as do
from coordinator.exploration.decision_check import CheckLimits
from coordinator.exploration.local import frontiers_left
from coordinator.exploration.rules import ExplorationRules, SpendingLimits
from coordinator.exploration_ports import ExploringRobot, Eye, Journal, Pilot, PilotAnswer
from coordinator.settings import Settings
from mesh.clock import Clock
from mesh.errors import UnavailableError
from mesh.tasks import Tasks

CHART_S_MAX = 6.0
"""So long it waits for its first map; then the laser leads until one comes."""
UNTIL_TOLD_S = float("inf")


@dataclass(frozen=True, slots=True)
class ExplorationNeeds:
    """What explorations need; without a `pilot` no model is set, and the frontiers lead."""

    settings: Settings
    robot: ExploringRobot
    journal: Journal
    pilot: Pilot | None = None
    eye: Eye | None = None


def rules_of(
    settings: Settings, robot: RobotDescription | None, *, model: bool, duration_s: float | None = None
) -> ExplorationRules:
    """For one robot: with its footprint, no faster than it can, and no longer than is set."""
    limits = CheckLimits()
    if robot is not None:
        limits = CheckLimits(
            footprint_radius_m=robot.footprint_radius_m,
            speed_m_s=min(limits.speed_m_s, robot.speed_m_s_max),
            slow_speed_m_s=min(limits.slow_speed_m_s, robot.speed_m_s_max),
        )
    return ExplorationRules(
        pilot=ExplorationMode.MODEL if model else ExplorationMode.FRONTIERS,
        duration_s=min(settings.exploration_s, duration_s or settings.exploration_s),
        spending=SpendingLimits(
            calls_max=settings.exploration_calls_max,
            tokens_max=settings.exploration_tokens_max,
            seconds_max=settings.exploration_waited_s_max,
        ),
        limits=limits,
    )


class Explorer:
    """One at a time, each anew but for what its home's journal remembers. `feed` takes the mission's events.

    `follow` is told the mission after each of its steps: whatever ends or pauses it ends or holds the exploration too.
    """

    def __init__(
        self,
        given: ExplorationNeeds,
        motion: MotionClient,
        feed: Callable[[ev.Event], None],
        clock: Clock,
        tasks: Tasks,
    ) -> None:
        self._given = given
        self._motion = motion
        self._feed = feed
        self._clock = clock
        self._tasks = tasks
        self._runner: ExplorationRunner | None = None
        self._senses: asyncio.Task[None] | None = None
        self._mission = ""
        self._last_told: Discovery | None = None
        self._call = 0
        """The mission's that is answered; 0 while it is held or over."""

    def explore(self, action: act.BeginExploration, mission: Mission, body: RobotDescription | None) -> None:
        """Begins one, or lets the one that is held go on. Returns at once."""
        self._call = action.call
        if self._runner is not None and self._runner.exploration.running:
            self._runner.heard()
            return
        self._end_senses()
        self._mission = mission.id
        runner = self._runner = ExplorationRunner(
            self._given.robot,
            self._given.pilot or _NoPilot(),
            rules=rules_of(
                self._given.settings, body, model=self._given.pilot is not None, duration_s=action.duration_s
            ),
            clock=self._clock,
            tasks=self._tasks,
            journal=self._given.journal,
            eye=self._given.eye if self._given.pilot is not None else None,
            motion=self._motion,
            told=self._told,
        )
        self._senses = self._tasks.start("exploration-senses", runner.run())
        self._tasks.start("exploration-begins", self._begin(runner, action), forever=False)

    def follow(self, mission: Mission) -> None:
        runner = self._runner
        if runner is None:
            return
        if not mission.running or mission.state is not MissionState.EXPLORING or mission.id != self._mission:
            self._call = 0
            runner.cancel()
            self._end_senses()
        elif not isinstance(mission.activity, UnderExploration):
            self._call = 0
            runner.listen(UNTIL_TOLD_S)

    def status(self, map_id: str | None) -> ExplorationStatus | None:
        """Of the exploration under way, or of the last; its discoveries only in the home that it began in."""
        if self._runner is None:
            return None
        one, rules, chart = self._runner.exploration, self._runner.exploration.rules, self._runner.exploration.chart
        limits, spent = rules.spending, one.spent
        named_since = self._runner.home is None and one.running
        at_home = self._runner.home == map_id or named_since
        led = self._given.pilot is not None
        return ExplorationStatus(
            mission_id=self._mission,
            mode=one.mode,
            why=one.why[:200],
            model=self._given.settings.exploration_model[:100] if led else "",
            calls=spent.calls,
            calls_max=limits.calls_max if led else 0,
            tokens=spent.tokens,
            tokens_max=limits.tokens_max if led else 0,
            waited_s=round(spent.seconds, 1),
            waited_s_max=limits.seconds_max if led else 0.0,
            refused=sum(count for verdict, count in one.verdicts if not verdict.moves),
            actions=one.motions,
            goals=self._runner.goals_reached,
            frontiers=len(frontiers_left(one)),
            explored_m2=round(chart.reachable_m2, 2) if chart is not None else None,
            discoveries=one.memory.discoveries[-DISCOVERIES_TOLD:] if at_home else (),
        )

    async def discovered(self, map_id: str | None) -> tuple[Discovery, ...]:
        """Of the home of that map, oldest first, over restarts; of one without a name what this process still knows.
        Raises `UnavailableError`."""
        runner = self._runner
        begun = runner is not None and runner.exploration.home is not None
        if runner is not None and begun and runner.home == map_id:
            return runner.exploration.memory.discoveries
        return (await self._given.journal.read(map_id)).discoveries if map_id is not None else ()

    async def _begin(self, runner: ExplorationRunner, action: act.BeginExploration) -> None:
        """Once it sees where the robot is, and its map. What it never sees the mission gives up on by its own rules."""

        def still() -> bool:
            return self._runner is runner and self._call == action.call

        map_until_s = self._clock.now_s() + CHART_S_MAX
        while still() and (
            runner.exploration.pose is None or (runner.exploration.chart is None and self._clock.now_s() < map_until_s)
        ):
            await self._clock.sleep(LOOK_S)
        await runner.begin(action.home, still)
        if still() and not runner.exploration.running:  # the emergency stop is on, and the mission was not told yet
            self._feed(ev.ExplorationEnded(action.call, ExplorationEnd.STOPPED))

    def _told(self, command: do.TellMode | do.Remember | do.Finish) -> None:
        if self._call == 0 or self._runner is None:
            return
        match command:
            case do.TellMode(mode=ExplorationMode.IDLE):
                pass  # the end says it
            case do.TellMode(mode=mode, why=why):
                self._tell(ev.LeadChanged(self._call, mode, why))
            case do.Remember(memory=memory):
                began_s, last = self._runner.exploration.begun_s, memory.discoveries[-1:]
                for one in last:
                    if one != self._last_told and one.stamp_s >= began_s:
                        self._last_told = one
                        self._tell(ev.DiscoverySeen(self._call, one.label, one.note))
            case do.Finish(end=end):
                one = self._runner.exploration
                found = tuple(each.label for each in one.memory.discoveries if each.stamp_s >= one.begun_s)
                ended = ev.ExplorationEnded(
                    self._call, end, one.motions, one.spent.calls, found, all_known=not one.unknown_seen
                )
                self._tell(ended)

    def _tell(self, event: ev.Event) -> None:
        """In a task of its own: the mission may be in the middle of a step."""

        async def feed() -> None:
            self._feed(event)

        self._tasks.start("exploration-told", feed(), forever=False)

    def _end_senses(self) -> None:
        if self._senses is not None:
            self._senses.cancel()
            self._senses = None


class _NoPilot:
    """Nobody asks it: without a model the frontiers lead."""

    async def decide(self, question: do.AskModel) -> PilotAnswer:
        raise UnavailableError("model", f"none is set ({question.reason})")
