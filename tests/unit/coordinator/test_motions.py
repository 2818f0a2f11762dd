"""One motion after the other: whatever interrupts the sending of a goal, that goal is not left running."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any, cast

import pytest

from contracts.geometry import Pose2D
from contracts.robot import CandidatePose, Goal, GoalRequest, GoalStatus
from coordinator.execution.motion_client import MotionClient
from coordinator.ports import Robot
from mesh.errors import MeshError, UnavailableError, UpstreamError
from mesh.tasks import Tasks
from support.fake_clock import FakeClock

A, B = Pose2D(x=1.0, y=0.0, yaw=0.0), Pose2D(x=2.0, y=0.0, yaw=0.0)


class Bridge:
    """Takes each goal when it is told to; `told` is what was asked of it, in order."""

    def __init__(self) -> None:
        self.told: list[str] = []
        self.answers = asyncio.Event()
        self.loses: set[str] = set()
        self.asked_about: MeshError = UnavailableError("robot_bridge", "no answer in time")

    async def navigate(self, request: GoalRequest) -> Goal:
        pose = request.candidates[0].pose
        name = f"to {pose.x:.0f}"
        self.told.append(name)
        await self.answers.wait()
        if name in self.loses:
            raise UnavailableError("robot_bridge", "no answer in time")
        return Goal(id=name, pose=pose, status=GoalStatus.EXECUTING, stamp_s=0.0)

    async def goal(self, goal_id: str) -> Goal:
        raise self.asked_about

    async def cancel_goal(self, goal_id: str) -> None:
        self.told.append(f"cancel {goal_id}")

    async def drop_session(self) -> None:
        self.told.append("drop")

    async def end_motion(self) -> None:
        self.told.append("end")


class Bench:
    def __init__(self, tasks: Tasks) -> None:
        self.bridge, self.clock = Bridge(), FakeClock()
        self.failed = 0
        self.motions = MotionClient(
            cast("Robot", self.bridge), self.clock, lambda work: tasks.start("call", work, forever=False),
            goal_poll_s=1.0, on_lease=lambda held: None,
        )  # fmt: skip

    def go(self, pose: Pose2D) -> None:
        async def work() -> None:
            try:
                await self.motions.navigate(GoalRequest(candidates=(CandidatePose(pose=pose),), epoch=0))
            except UnavailableError:
                self.motions.mark_uncertain(0)
            except UpstreamError:
                self.failed += 1

        self.motions.start(work, 0)


@pytest.fixture
async def bench() -> AsyncIterator[Bench]:
    died: list[Any] = []
    async with Tasks(on_death=lambda: died.append(1)) as tasks:
        yield Bench(tasks)
    assert not died


async def test_a_goal_interrupted_while_it_is_sent_is_cancelled_before_the_next_is_sent(bench: Bench) -> None:
    bench.go(A)
    await bench.clock.settle()
    bench.motions.stop(0)
    bench.go(B)
    await bench.clock.settle()
    assert bench.bridge.told == ["to 1"]
    bench.bridge.answers.set()
    await bench.clock.settle()
    assert bench.bridge.told == ["to 1", "cancel to 1", "to 2"]


async def test_of_many_interrupted_goals_only_the_last_is_left(bench: Bench) -> None:
    bench.go(A)
    await bench.clock.settle()
    for pose in (B, A, B):
        bench.motions.stop(0)
        bench.go(pose)
        await bench.clock.settle()
    bench.bridge.answers.set()
    for _ in range(3):
        await bench.clock.settle()
    assert [one for one in bench.bridge.told if one.startswith(("to", "cancel"))] == ["to 1", "cancel to 1", "to 2"]


async def test_an_interrupted_goal_whose_answer_is_lost_ends_with_the_session_before_the_next(bench: Bench) -> None:
    bench.bridge.loses = {"to 1"}
    bench.go(A)
    await bench.clock.settle()
    bench.motions.stop(0)
    bench.go(B)
    bench.bridge.answers.set()
    await bench.clock.settle()
    assert bench.bridge.told == ["to 1", "drop", "to 2"]


async def test_a_goal_whose_answer_does_not_come_is_ended_with_the_session_soon_after_the_stop(bench: Bench) -> None:
    bench.go(A)
    await bench.clock.settle()
    bench.motions.stop(0)
    await bench.clock.settle()
    assert bench.bridge.told == ["to 1"]
    await bench.clock.advance(1.5)
    assert bench.bridge.told == ["to 1", "drop"]
    bench.bridge.answers.set()
    await bench.clock.settle()


async def test_a_goal_that_may_have_been_taken_is_ended_at_once_without_being_told_to(bench: Bench) -> None:
    bench.bridge.loses = {"to 1"}
    bench.bridge.answers.set()
    bench.go(A)
    await bench.clock.settle()
    assert bench.bridge.told == ["to 1", "drop"]


async def test_a_goal_that_can_no_longer_be_asked_about_is_ended_too(bench: Bench) -> None:
    bench.bridge.answers.set()
    bench.go(A)
    await bench.clock.advance(1.1)
    assert bench.bridge.told == ["to 1", "drop"]
    bench.motions.stop(0)
    await bench.clock.settle()
    assert bench.bridge.told == ["to 1", "drop"]


@pytest.mark.parametrize("stopped", [False, True])
async def test_a_goal_of_which_only_a_fault_is_heard_is_cancelled_by_what_comes_next(
    bench: Bench, stopped: bool
) -> None:
    bench.bridge.answers.set()
    bench.bridge.asked_about = UpstreamError("robot_bridge", 500, "it broke")
    bench.go(A)
    await bench.clock.advance(1.1)
    assert (bench.failed, bench.bridge.told) == (1, ["to 1"])
    next_one = {False: lambda: bench.go(B), True: lambda: bench.motions.stop(0)}[stopped]
    next_one()
    await bench.clock.settle()
    assert bench.bridge.told == ["to 1", "cancel to 1", *{False: ["to 2"], True: []}[stopped]]


async def test_leaving_while_a_goal_is_sent_leaves_no_task_and_no_error_behind() -> None:
    before = asyncio.all_tasks()
    async with Tasks() as tasks:
        bench = Bench(tasks)
        bench.bridge.loses = {"to 1"}
        bench.go(A)
        await bench.clock.settle()
        bench.motions.stop(0)
        await bench.clock.settle()
        assert asyncio.all_tasks() != before
    assert asyncio.all_tasks() == before
