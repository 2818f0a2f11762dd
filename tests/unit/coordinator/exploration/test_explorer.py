"""The exploration of a mission that a model leads: held and gone on with, and what is told of it at its end."""

import asyncio
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field, replace

import pytest

from contracts.exploration import ExplorationEnd, ReportDiscovery
from contracts.mission import MissionState, Outcome
from coordinator.core import actions as act
from coordinator.core import events as ev
from coordinator.core.activities import Paused, UnderExploration
from coordinator.core.mission import Mission
from coordinator.core.rules import Rules
from coordinator.execution.explorer import ExplorationNeeds, Explorer, rules_of
from coordinator.execution.motion_client import MotionClient
from coordinator.exploration.commands import AskModel
from coordinator.exploration_ports import PilotAnswer
from coordinator.settings import Settings
from mesh.tasks import Tasks
from support.bus import MemoryBus
from support.coordinator_world import FakeRobot, World
from support.exploration_memory import KeptHomes
from support.fake_clock import FakeClock

CALL = 7
UNDER_WAY = Mission(Rules(), id="m1", state=MissionState.EXPLORING, activity=UnderExploration(CALL))
HELD = replace(UNDER_WAY, activity=Paused(0.0, float("inf")))


@dataclass
class Reports:
    """A model that reports a cup once and then takes for ever."""

    asked: int = 0
    waiting: int = 0

    async def decide(self, question: AskModel) -> PilotAnswer:
        self.asked += 1
        if self.asked == 1:
            return PilotAnswer(ReportDiscovery(label="cup"), tokens=5)
        self.waiting += 1
        try:
            await asyncio.Event().wait()
        finally:
            self.waiting -= 1
        raise AssertionError(question)


@dataclass
class Rig:
    clock: FakeClock
    pilot: Reports
    explorer: Explorer
    world: World
    told: list[ev.Event] = field(default_factory=list[ev.Event])

    async def begin(self, call: int = CALL) -> None:
        self.explorer.explore(act.BeginExploration(call, self.world.pose), UNDER_WAY, None)
        for _ in range(200):
            if self.pilot.asked >= 2 and self.pilot.waiting:
                return
            await self.clock.advance(0.05)
        raise AssertionError("the model was not asked")

    async def ends(self) -> list[ev.ExplorationEnded]:
        """Once it has ended."""
        for _ in range(600):
            ends = [one for one in self.told if isinstance(one, ev.ExplorationEnded)]
            if ends:
                return ends
            await self.clock.advance(0.1)
        raise AssertionError("it did not end")


@asynccontextmanager
async def opened(*, mapped_m: float | None = 2.5, **settings: object) -> AsyncGenerator[Rig]:
    died: list[str] = []
    async with Tasks(on_death=lambda: died.append("a task")) as tasks:
        clock, pilot, told = FakeClock(), Reports(), list[ev.Event]()
        world = World(clock, MemoryBus(), mapped_m=mapped_m)
        robot = FakeRobot(world)
        motion = MotionClient(
            robot, clock, lambda work: tasks.start("motion", work, forever=False),
            goal_poll_s=1.0, on_lease=lambda _: None,
        )  # fmt: skip
        needs = ExplorationNeeds(Settings.model_validate(settings), robot, KeptHomes(), pilot)
        yield Rig(clock, pilot, Explorer(needs, motion, told.append, clock, tasks), world, told)
    assert died == []


async def test_in_a_known_home_what_the_model_answers_leaves_looking_at_all_of_it() -> None:
    async with opened(mapped_m=None) as rig:
        await rig.begin()
        ends = await rig.ends()
        assert [(one.end, one.all_known) for one in ends] == [(ExplorationEnd.EXPLORED, True)]


@pytest.mark.parametrize("over", [replace(UNDER_WAY, outcome=Outcome.CANCELED), HELD])
async def test_a_pause_or_a_cancel_hangs_up_on_the_model(over: Mission) -> None:
    async with opened() as rig:
        await rig.begin()
        rig.explorer.follow(over)
        await rig.clock.advance(0.1)
        assert rig.pilot.waiting == 0


async def test_what_was_discovered_before_a_pause_is_told_at_the_end() -> None:
    async with opened(exploration_s=12.0) as rig:
        await rig.begin()
        rig.explorer.follow(HELD)
        await rig.clock.advance(60.0)
        rig.explorer.explore(act.BeginExploration(CALL + 1, rig.world.pose), UNDER_WAY, None)
        ends = await rig.ends()
        assert [one.discoveries for one in ends] == [("cup",)]
        assert [one.label for one in rig.told if isinstance(one, ev.DiscoverySeen)] == ["cup"]


@pytest.mark.parametrize(("asked", "lasts"), [(None, 600.0), (120.0, 120.0), (700.0, 600.0)])
def test_it_lasts_as_long_as_was_asked_and_no_longer_than_is_set(asked: float | None, lasts: float) -> None:
    assert rules_of(Settings(), None, model=False, duration_s=asked).duration_s == lasts


async def test_a_short_one_is_over_when_it_was_asked_to_be() -> None:
    async with opened() as rig:
        begun_s = rig.clock.now_s()
        rig.explorer.explore(act.BeginExploration(CALL, rig.world.pose, 12.0), UNDER_WAY, None)
        ends = await rig.ends()
        assert [one.end for one in ends] == [ExplorationEnd.TIME_UP]
        assert rig.clock.now_s() - begun_s < 40.0
