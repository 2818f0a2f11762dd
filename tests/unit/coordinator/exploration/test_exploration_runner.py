"""The shell round an exploration: a stop that nobody saw, senses that do not answer, and whose home is remembered."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import NoReturn

import pytest

from contracts.exploration import Discovery, ExplorationEnd, ExplorationMemory, ExplorationMode, MapPoint
from contracts.robot import Goal, GoalRequest, GoalStatus
from coordinator.execution.exploration_runner import LOOK_S, ExplorationRunner
from coordinator.exploration.commands import AskModel
from coordinator.exploration.local import frontiers_left
from coordinator.exploration.rules import ExplorationRules
from coordinator.exploration_ports import PilotAnswer
from mesh.errors import ConflictError, MeshError, UnavailableError
from mesh.tasks import Tasks
from support.bus import MemoryBus
from support.coordinator_world import FakeRobot, World
from support.exploration_memory import KeptHomes
from support.fake_clock import FakeClock

M = ExplorationMode
WANDERS = ExplorationRules(pilot=M.REACTIVE)


class NobodyToAsk:
    async def decide(self, question: AskModel) -> PilotAnswer:
        raise AssertionError(f"nobody is asked {question.reason}")


class Run:
    """A runner on a simulated clock, and its world."""

    def __init__(self, tasks: Tasks, rules: ExplorationRules) -> None:
        self.clock = FakeClock()
        self.world = World(self.clock, MemoryBus())
        self.robot = FakeRobot(self.world)
        self.homes = KeptHomes()
        self.runner = ExplorationRunner(
            self.robot, NobodyToAsk(), rules=rules, clock=self.clock, tasks=tasks, journal=self.homes
        )

    @property
    def end(self) -> ExplorationEnd | None:
        return self.runner.exploration.end

    async def begin(self) -> None:
        await self.runner.begin(self.world.pose)

    async def until(self, happens: Callable[[], bool], within_s: float = 10.0) -> None:
        end_s = self.clock.now_s() + within_s
        while not happens():
            assert self.clock.now_s() < end_s, "it did not happen in time"
            await self.clock.advance(0.05)


@asynccontextmanager
async def running(rules: ExplorationRules = WANDERS) -> AsyncIterator[Run]:
    died: list[str] = []
    async with Tasks(on_death=lambda: died.append("a task")) as tasks:
        run = Run(tasks, rules)
        tasks.start("runner", run.runner.run())
        await run.clock.advance(2 * LOOK_S)
        yield run
    assert died == []


# the stop


async def test_a_stop_that_was_pressed_and_reset_between_two_looks_ends_it() -> None:
    async with running() as run:
        await run.begin()
        await run.until(lambda: "drive" in run.world.moves)
        await run.robot.emergency_stop("a person presses it")
        await run.world.reset()
        moved = list(run.world.moves)
        await run.clock.advance(20.0)
        assert run.end is ExplorationEnd.STOPPED
        assert run.world.moves == moved
        await run.begin()
        await run.until(lambda: len(run.world.moves) > len(moved))


async def test_a_stop_is_seen_though_the_laser_does_not_answer() -> None:
    async with running() as run:
        await run.begin()
        await run.until(lambda: "drive" in run.world.moves)
        run.robot.hangs = {"scan"}
        await run.robot.emergency_stop("a person presses it")
        await run.world.reset()
        await run.clock.advance(2 * LOOK_S)
        assert run.end is ExplorationEnd.STOPPED


# what does not answer


async def test_a_map_that_is_never_told_holds_up_nothing() -> None:
    async with running() as run:
        run.robot.hangs = {"map"}
        await run.clock.advance(2.5)
        await run.begin()
        await run.until(lambda: "drive" in run.world.moves)
        await run.robot.emergency_stop("a person presses it")
        await run.clock.advance(2 * LOOK_S)
        assert run.end is ExplorationEnd.STOPPED


async def test_time_passes_though_the_robot_tells_nothing() -> None:
    async with running(ExplorationRules(pilot=M.REACTIVE, duration_s=5.0)) as run:
        await run.begin()
        run.robot.hangs = {"state", "map", "rotate", "drive", "navigate"}
        await run.clock.advance(5.0 + LOOK_S)
        assert run.end is ExplorationEnd.TIME_UP


# a session that is lost for a moment


@pytest.mark.parametrize("status", [None, GoalStatus.CANCELED, GoalStatus.REJECTED])
async def test_a_goal_that_is_not_taken_for_a_moment_is_no_visit(status: GoalStatus | None) -> None:
    async with running(ExplorationRules(pilot=M.FRONTIERS)) as run:
        run.world.mapped_m = 2.5
        await run.until(lambda: bool(frontiers_left(run.runner.exploration)), within_s=60.0)
        until_s, real, tries = run.clock.now_s() + 1.5, run.robot.navigate, 0

        async def navigate(request: GoalRequest) -> Goal:
            nonlocal tries
            if run.clock.now_s() >= until_s:
                return await real(request)
            tries += 1
            if status is None:
                raise UnavailableError("robot_bridge", "no session is held")
            return Goal(id=f"none-{tries}", pose=request.candidates[0].pose, status=status, stamp_s=0.0)

        run.robot.navigate = navigate
        await run.begin()
        await run.until(lambda: run.runner.goals_reached > 0, within_s=60.0)
        assert 1 <= tries <= 2
        assert run.runner.exploration.memory.given_up == ()
        assert sum(count for _, count in run.runner.exploration.visits) == 1


@pytest.mark.parametrize(
    ("error", "dropped"), [(UnavailableError("robot_bridge", "no answer"), True), (ConflictError("busy"), False)]
)
async def test_the_session_is_dropped_for_what_was_not_answered_and_not_for_a_refusal(
    error: MeshError, dropped: bool
) -> None:
    async with running() as run:

        async def fails(*_: object, **__: object) -> NoReturn:
            raise error

        run.robot.rotate = run.robot.drive = fails
        await run.begin()
        await run.clock.advance(3.0)
        assert 2 <= run.runner.exploration.failures <= 4
        assert (run.robot.sessions_dropped > 0) is dropped


# whose home it is

CUP = Discovery(label="cup", x_m=1.0, y_m=2.0, stamp_s=3.0)


async def remembers_an_action(run: Run) -> None:
    await run.until(lambda: run.runner.exploration.memory.actions_done > 0, within_s=30.0)


async def test_what_is_remembered_goes_into_the_home_that_it_began_in() -> None:
    async with running() as run:
        run.homes.of["flat"] = ExplorationMemory(discoveries=(CUP,))
        run.world.map_id = "flat"
        await run.clock.advance(2 * LOOK_S)
        await run.begin()
        await remembers_an_action(run)
        assert list(run.homes.of) == ["flat"]
        assert run.homes.of["flat"].discoveries == (CUP,)


async def test_in_another_map_it_ends_and_what_it_knew_stays_out_of_it() -> None:
    async with running() as run:
        run.world.map_id = "flat"
        await run.clock.advance(2 * LOOK_S)
        await run.begin()
        await remembers_an_action(run)
        run.world.map_id = "garden house"
        await run.clock.advance(30.0)
        assert run.end is ExplorationEnd.ANOTHER_MAP
        await run.begin()
        assert run.runner.exploration.memory.actions == ()
        assert list(run.homes.of) == ["flat"]


async def test_of_a_map_without_a_name_nothing_is_kept_though_it_is_named_under_way() -> None:
    async with running() as run:
        await run.begin()
        await run.clock.advance(LOOK_S)
        run.world.map_id = "flat"
        await remembers_an_action(run)
        assert run.runner.exploration.running
        assert run.homes.of == {}


async def test_a_map_that_changes_while_it_begins_is_the_one_it_begins_in() -> None:
    async with running() as run:
        run.homes.of["flat"] = ExplorationMemory(discoveries=(CUP,))
        run.world.map_id = "flat"
        await run.clock.advance(2 * LOOK_S)
        run.homes.held.clear()
        beginning = asyncio.create_task(run.begin())
        run.world.map_id = "garden house"
        await run.clock.advance(2 * LOOK_S)
        run.homes.held.set()
        await beginning
        assert run.runner.exploration.memory.discoveries == ()
        await remembers_an_action(run)
        assert set(run.homes.of) == {"flat", "garden house"}


async def test_what_was_given_up_is_tried_again_the_next_time() -> None:
    async with running() as run:
        run.homes.of["flat"] = ExplorationMemory(given_up=(MapPoint(x_m=1.0, y_m=1.0),))
        run.world.map_id = "flat"
        await run.clock.advance(2 * LOOK_S)
        await run.begin()
        assert run.runner.exploration.memory.given_up == ()
