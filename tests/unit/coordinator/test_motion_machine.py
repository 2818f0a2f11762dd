"""Whatever is asked of the wheels in whatever order, and whichever answers are lost: one motion at a time."""

import asyncio
from collections.abc import Callable
from typing import cast

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from contracts.geometry import Pose2D, Twist2D
from contracts.robot import CandidatePose, Goal, GoalRequest, GoalStatus, VelocityReply
from coordinator.execution.motion_client import MotionClient
from coordinator.execution.motion_phases import FOLLOWS, MotionPhase
from coordinator.ports import Robot
from mesh.errors import MeshError, UnavailableError, UpstreamError
from support.fake_clock import FakeClock

GOAL = Pose2D(x=1.0, y=0.0, yaw=0.0)
REQUEST = GoalRequest(candidates=(CandidatePose(pose=GOAL),), epoch=0)


class Bridge:
    """Holds every call until it is answered or lost. `moving` is what may move the robot; `told` what was asked."""

    def __init__(self) -> None:
        self.calls: list[asyncio.Future[MeshError | None]] = []
        self.moving: set[str] = set()
        self.told: list[str] = []
        self.overlaps: list[tuple[str, set[str]]] = []
        self._count = 0

    def answer(self, error: MeshError | None) -> None:
        while self.calls:
            call = self.calls.pop(0)
            if not call.done():
                call.set_result(error)
                return

    async def _moves(self, kind: str) -> str:
        """Taken at once, answered later. Raises `UnavailableError` where the answer is lost."""
        self._count += 1
        name = f"{kind} {self._count}"
        self.told.append(name)
        others = {one for one in self.moving if not (kind == one.split()[0] == "lease")}
        self.overlaps += [(name, others)] if others else []
        self.moving = {*others, name}
        await self._answered()
        return name

    async def _answered(self) -> None:
        call = asyncio.get_running_loop().create_future()
        self.calls.append(call)
        if (error := await call) is not None:
            raise error

    async def navigate(self, request: GoalRequest) -> Goal:
        try:
            name = await self._moves("goal")
        except UpstreamError:
            self.moving = {one for one in self.moving if not one.startswith("goal")}
            raise
        return Goal(id=name, pose=GOAL, status=GoalStatus.EXECUTING, stamp_s=0.0)

    async def goal(self, goal_id: str) -> Goal:
        """Raises what the question is answered with; the goal goes on."""
        await self._answered()
        self.moving.discard(goal_id)
        return Goal(id=goal_id, pose=GOAL, status=GoalStatus.SUCCEEDED, stamp_s=0.0)

    async def rotate(self) -> None:
        """Refused, it did not begin."""
        try:
            name = await self._moves("turn")
        except UpstreamError:
            self.moving = {one for one in self.moving if not one.startswith("turn")}
            raise
        self.moving.discard(name)

    async def velocity(self, twist: Twist2D, *, duration_s: float, epoch: int) -> VelocityReply:
        if twist == Twist2D():
            self.moving = {one for one in self.moving if not one.startswith("lease")}
        else:
            await self._moves("lease")
        return VelocityReply.model_construct(causes=())

    async def cancel_goal(self, goal_id: str) -> None:
        self.moving.discard(goal_id)

    async def end_motion(self) -> None:
        self.moving = {one for one in self.moving if not one.startswith("turn")}

    async def drop_session(self) -> None:
        self.told.append("drop")
        self.moving.clear()


class Motions(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.loop = asyncio.new_event_loop()
        self.bridge, self.clock = Bridge(), FakeClock()
        self.ended_badly = False
        self.client = MotionClient(
            cast("Robot", self.bridge), self.clock, self.loop.create_task, goal_poll_s=1.0, on_lease=lambda held: None
        )

    def now(self, act: Callable[[], None]) -> None:
        async def run() -> None:
            act()
            await self.clock.settle()

        self.loop.run_until_complete(run())

    def begin(self, goal: bool) -> None:
        async def work() -> None:
            try:
                await (self.client.navigate(REQUEST) if goal else self.bridge.rotate())
            except UnavailableError:
                self.client.mark_uncertain(0)
            except UpstreamError:
                self.ended_badly = True

        self.ended_badly = False
        self.client.start(work, 0)

    @rule(goal=st.booleans())
    def starts_in_the_moment_of_a_stop(self, goal: bool) -> None:
        def stop_and_begin() -> None:
            self.client.stop(0)
            self.begin(goal)

        self.now(stop_and_begin)

    @precondition(lambda self: self.ended_badly)
    @rule(goal=st.booleans())
    def starts_when_the_last_ended_badly(self, goal: bool) -> None:
        """As the core does: without a stop, nothing begins but after an end."""
        self.now(lambda: self.begin(goal))

    @rule()
    def stops(self) -> None:
        self.now(lambda: self.client.stop(0))

    @rule()
    def sends_a_velocity(self) -> None:
        self.ended_badly = False
        self.now(lambda: self.client.send_velocity(Twist2D(linear_x=0.1), 0.3, 0))

    @rule()
    def an_answer_comes(self) -> None:
        self.now(lambda: self.bridge.answer(None))

    @rule()
    def an_answer_is_lost(self) -> None:
        """A goal or turn of which no answer comes is ended with the session; a lease ends by itself."""
        self.now(lambda: self.bridge.answer(UnavailableError("robot_bridge", "no answer in time")))

    @rule()
    def an_answer_is_a_refusal(self) -> None:
        """Of a goal under way: nothing is known of it, and it goes on."""
        self.now(lambda: self.bridge.answer(UpstreamError("robot_bridge", 500, "it broke")))

    @rule(seconds=st.sampled_from([0.5, 1.1, 1.6]))
    def time_passes(self, seconds: float) -> None:
        self.loop.run_until_complete(self.clock.advance(seconds))

    @invariant()
    def never_two_motions_at_once(self) -> None:
        assert self.bridge.overlaps == []

    @invariant()
    def what_is_not_followed_does_not_move(self) -> None:
        """Idle: whatever began was answered, ended by a stop, or went with the session."""
        assert self.client.phase is not MotionPhase.IDLE or self.bridge.moving == set()

    def teardown(self) -> None:
        self.now(lambda: self.client.stop(0))
        self.loop.run_until_complete(self.clock.advance(2.0))
        for _ in range(20):
            self.now(lambda: self.bridge.answer(UnavailableError("robot_bridge", "no answer in time")))
            self.loop.run_until_complete(self.clock.advance(2.0))
        assert (self.client.phase, self.bridge.moving) == (MotionPhase.IDLE, set())
        assert asyncio.all_tasks(self.loop) == set()
        self.loop.close()


TestMotions = Motions.TestCase
TestMotions.settings = settings(max_examples=60, stateful_step_count=25, deadline=None)


def test_the_table_names_every_phase_and_every_phase_can_be_left_and_reached() -> None:
    assert set(FOLLOWS) == set(MotionPhase)
    assert set().union(*FOLLOWS.values()) == set(MotionPhase)
    assert all(FOLLOWS.values())
