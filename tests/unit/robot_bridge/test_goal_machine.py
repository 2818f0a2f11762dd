"""Whatever clients, Nav2 and the emergency stop do in whatever order: one goal, and no velocity without it."""

import asyncio
import itertools
from collections import defaultdict
from pathlib import Path as FilePath
from typing import cast

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from contracts.causes import GoalCause
from contracts.geometry import Pose2D
from contracts.robot import CandidatePose, Goal, GoalRequest, GoalStatus
from mesh.tasks import Tasks
from robot_bridge.motion.velocity_mux import VelocityMux
from robot_bridge.navigation.goal_executor import GoalExecutor, GoalLimits
from robot_bridge.navigation.goal_phases import FOLLOWS, GoalPhase, page
from robot_bridge.navigation.goal_states import ALLOWED, is_over
from robot_bridge.navigation.recovery import Recovery
from robot_bridge.ports import GoalEnd, Path, Robot
from robot_bridge.sensing.sensor_readings import Grid, SensorReadings
from support.fake_clock import FakeClock

ROOT = FilePath(__file__).parents[3]
HERE = Pose2D(x=1.0, y=1.0, yaw=0.0)
REQUEST = GoalRequest(candidates=(CandidatePose(pose=Pose2D(x=3.0, y=3.0, yaw=0.0)),), epoch=0, session_id="s")


class TakenGoal:
    def __init__(self) -> None:
        self.ended: asyncio.Future[GoalEnd] = asyncio.get_running_loop().create_future()
        self.cancelled = False

    async def end(self) -> GoalEnd:
        return await asyncio.shield(self.ended)

    def cancel(self) -> None:
        self.cancelled = True

    async def was_preempted(self) -> bool:
        return False


class Nav2:
    """Holds every question until a rule answers it."""

    def __init__(self) -> None:
        self.senses = SensorReadings()
        self.senses.map.put(Grid(np.zeros((100, 100), np.int8), 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0)), 1000.0)
        self.senses.poses.add_odometry(1000.0, HERE)
        self.senses.poses.add_map_to_odom(1000.0, Pose2D(x=0.0, y=0.0, yaw=0.0), received_s=1000.0)
        self.senses.nav2_missing.put("", 1000.0)
        self.asked: list[asyncio.Future[TakenGoal | None]] = []
        self.taken: list[TakenGoal] = []
        self.planner_code = 0

    async def navigate(self, pose: Pose2D, on_progress: object) -> TakenGoal | None:
        question: asyncio.Future[TakenGoal | None] = asyncio.get_running_loop().create_future()
        self.asked.append(question)
        return await question

    async def compute_path(self, goal: Pose2D, start: Pose2D | None) -> Path:
        return Path(() if self.planner_code else (HERE, goal), self.planner_code)

    async def clear_costmaps(self) -> None:
        await asyncio.sleep(0)

    @property
    def driving(self) -> list[TakenGoal]:
        return [goal for goal in self.taken if not goal.ended.done() and not goal.cancelled]


class Wheels:
    """`passing` is the goal of which Nav2's velocity would reach the base."""

    def __init__(self) -> None:
        self.goal: str | None = None
        self.passing: str | None = None

    def check(self, epoch: int, session_id: str | None) -> None:
        pass

    def open_navigation(self, goal_id: str, epoch: int, session_id: str | None) -> None:
        self.goal = self.passing = goal_id

    def hold_navigation(self, goal_id: str) -> None:
        self.passing = None if goal_id == self.passing else self.passing

    def release_navigation(self, goal_id: str) -> None:
        self.passing = goal_id if goal_id == self.goal else self.passing

    def close_navigation(self, goal_id: str) -> None:
        self.hold_navigation(goal_id)
        self.goal = None if goal_id == self.goal else self.goal

    def navigation_hold(self) -> None:
        return None


class Recoveries:
    """Each waits until a rule ends it."""

    def __init__(self) -> None:
        self.begun: list[asyncio.Future[None]] = []

    async def make_room(self, active: object, hold: object) -> None:
        self.begun.append(asyncio.get_running_loop().create_future())
        await self.begun[-1]

    @property
    def waiting(self) -> list[asyncio.Future[None]]:
        return [recovery for recovery in self.begun if not recovery.done()]


class Goals(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.loop = asyncio.new_event_loop()
        self.nav2, self.wheels, self.clock = Nav2(), Wheels(), FakeClock()
        self.recoveries = Recoveries()
        self.told: dict[str, list[Goal]] = defaultdict(list)
        self.died = 0
        self.executor = self.loop.run_until_complete(self.begin())

    async def begin(self) -> GoalExecutor:
        return GoalExecutor(
            robot=cast("Robot", self.nav2),
            wheels=cast("VelocityMux", self.wheels),
            recovery=cast("Recovery", self.recoveries),
            clock=self.clock,
            tasks=Tasks(on_death=self.die),
            limits=GoalLimits(fresh_scan_wait_s_max=0.0),
            publish=lambda goal: self.told[goal.id].append(goal),
        )

    def die(self) -> None:
        self.died += 1

    def settle(self) -> None:
        self.loop.run_until_complete(self.clock.settle())

    @rule(planner_code=st.sampled_from([0, 0, 0, 206]))
    def a_goal_is_sent(self, planner_code: int) -> None:
        self.nav2.planner_code = planner_code
        self.loop.create_task(self.executor.send(REQUEST.model_copy(update={"clear_costmaps": False})))
        self.settle()

    @precondition(lambda self: self.nav2.asked)
    @rule()
    def nav2_takes_it(self) -> None:
        async def take() -> None:
            self.nav2.taken.append(TakenGoal())
            self.nav2.asked.pop(0).set_result(self.nav2.taken[-1])
            await self.clock.settle()

        self.loop.run_until_complete(take())

    @precondition(lambda self: self.nav2.asked)
    @rule()
    def nav2_rejects_it(self) -> None:
        self.nav2.asked.pop(0).set_result(None)
        self.settle()

    @precondition(lambda self: self.nav2.taken and not self.nav2.taken[-1].ended.done())
    @rule(status=st.sampled_from([GoalStatus.SUCCEEDED, GoalStatus.ABORTED]), code=st.sampled_from([0, 104, 208, 204]))
    def nav2_ends_it(self, status: GoalStatus, code: int) -> None:
        goal = self.nav2.taken[-1]
        goal.ended.set_result(GoalEnd(GoalStatus.CANCELED) if goal.cancelled else GoalEnd(status, code))
        self.settle()

    @precondition(lambda self: self.recoveries.waiting)
    @rule()
    def the_robot_has_room(self) -> None:
        for recovery in self.recoveries.waiting:
            recovery.set_result(None)
        self.settle()

    @rule()
    def somebody_cancels(self) -> None:
        for goal_id in {self.executor.goal_id} - {None}:
            self.loop.create_task(self.executor.cancel(goal_id))
        self.settle()

    @rule()
    def the_session_ends(self) -> None:
        self.loop.call_soon(self.executor.end_session, "s")
        self.settle()

    @rule()
    def the_emergency_stop(self) -> None:
        async def stop() -> None:
            self.executor.stop(GoalCause.STOPPED)
            assert (self.executor.goal_id, self.wheels.goal, self.nav2.driving) == (None, None, [])
            await self.clock.settle()

        self.loop.run_until_complete(stop())

    @invariant()
    def nav2_drives_at_most_one_goal_and_none_that_nobody_follows(self) -> None:
        assert len(self.nav2.driving) <= (self.executor.goal_id is not None)

    @invariant()
    def a_velocity_passes_only_while_nav2_drives(self) -> None:
        assert self.wheels.passing is None or (self.nav2.driving and self.wheels.passing == self.executor.goal_id)

    @invariant()
    def what_is_told_is_in_order_and_ends_once(self) -> None:
        for told in self.told.values():
            for before, after in itertools.pairwise(told):
                assert after.status is before.status or after.status in ALLOWED[before.status]
            assert sum(is_over(goal.status) for goal in told) == is_over(told[-1].status)
            assert is_over(told[-1].status) == (told[-1].id != self.executor.goal_id)

    @invariant()
    def no_task_of_it_dies(self) -> None:
        assert self.died == 0

    def teardown(self) -> None:
        for _ in range(30):
            self.the_emergency_stop()
            while self.nav2.asked:
                self.nav2_takes_it()
            self.the_robot_has_room()
        for goal in {goal for goal in self.nav2.taken if not goal.ended.done()}:
            goal.ended.set_result(GoalEnd(GoalStatus.CANCELED))
        self.settle()
        assert asyncio.all_tasks(self.loop) == set()
        self.loop.close()


TestGoals = Goals.TestCase
TestGoals.settings = settings(max_examples=60, stateful_step_count=25, deadline=None)


def test_the_table_names_every_phase_and_every_phase_but_the_last_can_be_left() -> None:
    assert set(FOLLOWS) == set(GoalPhase)
    assert {phase for phase, to in FOLLOWS.items() if not to} == {GoalPhase.OVER}
    assert all(GoalPhase.OVER in to for to in FOLLOWS.values() if to)


def test_the_page_shows_the_table() -> None:
    assert (ROOT / "docs/goal-phases.md").read_text(encoding="utf-8") == page()


def test_a_goal_that_another_task_ended_when_its_time_was_up_ends_nothing_more() -> None:
    goals = Goals()
    goals.a_goal_is_sent(0)
    goals.nav2_takes_it()
    goals.loop.run_until_complete(goals.clock.advance(REQUEST.timeout_s + 1.0))
    goals.the_emergency_stop()
    goals.nav2_ends_it(GoalStatus.SUCCEEDED, 0)
    goals.no_task_of_it_dies()
    goals.teardown()
