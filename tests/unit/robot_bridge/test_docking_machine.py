"""Whatever is asked of the dock, answered or given up in whatever order: one thing drives the robot, and it ends."""

import asyncio
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from contracts.causes import GoalCause
from contracts.geometry import Pose2D, Twist2D
from contracts.motion import BaseEnd, BaseReply
from contracts.robot import EmergencyStop, Goal, GoalRequest, GoalStatus
from mesh.errors import ConflictError
from robot_bridge.motion.sessions import Sessions
from robot_bridge.motion.velocity_mux import VelocityLimits, VelocityMux
from robot_bridge.navigation.docking import FOLLOWS, Docking, DockingLimits, DockingPhase
from robot_bridge.sensing.sensor_readings import DockView, Odometry, SensorReadings
from support.fake_clock import FakeClock

DOCK, AFAR = Pose2D(x=0.0, y=0.0, yaw=0.0), Pose2D(x=5.0, y=0.0, yaw=0.0)
TIME_LIMIT_S, LOOK_S = 90.0, 10.0


class World:
    """Nav2 and the base: each holds what it was asked until it is answered or given up."""

    def __init__(self, senses: SensorReadings) -> None:
        self.senses = senses
        self.goal_id: str | None = None
        self.base: asyncio.Future[bool] | None = None
        self.ended: list[BaseEnd] = []

    async def send(self, request: GoalRequest) -> Goal:
        self.goal_id, self._over = "goal", asyncio.Event()
        return self._goal(GoalStatus.EXECUTING)

    async def over(self, goal_id: str) -> Goal:
        await self._over.wait()
        return self._goal(self._status)

    def stop(self, cause: GoalCause) -> None:
        self.end_goal(GoalStatus.CANCELED)

    def end_goal(self, status: GoalStatus) -> None:
        if self.goal_id is not None:
            self.goal_id, self._status = None, status
            self._over.set()

    async def dock(self) -> bool:
        self.base = asyncio.get_running_loop().create_future()
        try:
            return await self.base
        finally:
            self.base = None

    undock = dock

    def _goal(self, status: GoalStatus) -> Goal:
        return Goal(id="goal", pose=DOCK, status=status, stamp_s=0.0)


class DockingMachine(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.loop, self.loop_s = asyncio.new_event_loop(), 0.0
        cast("Any", self.loop).time = lambda: self.loop_s
        self.clock, self.senses, self.sessions = FakeClock(), SensorReadings(), Sessions(timeout_s=1e6)
        self.session_id = self.sessions.open(0.0)
        self.world = World(self.senses)
        self.wheels = VelocityMux(
            senses=self.senses,
            sessions=self.sessions,
            clock=self.clock,
            stop=EmergencyStop(latched=False, epoch=0),
            limits=VelocityLimits(),
        )
        self.folder = tempfile.TemporaryDirectory()
        self.docking = Docking(
            robot=cast("Any", self.world),
            wheels=self.wheels,
            navigator=cast("Any", self.world),
            maps=cast("Any", SimpleNamespace(current=None)),
            clock=self.clock,
            state_dir=Path(self.folder.name),
            limits=DockingLimits(dock_pose=DOCK, dock_look_s_max=LOOK_S, dock_timeout_s=TIME_LIMIT_S),
        )
        self.asked: asyncio.Task[BaseReply] | None = None
        self.given_up: BaseEnd | None = None
        self.sees(is_docked=False, dock_visible=True, at=AFAR)

    def now(self, act: Callable[[], object]) -> None:
        async def run() -> None:
            act()
            await self.clock.settle()

        self.loop.run_until_complete(run())

    @property
    def is_asked(self) -> bool:
        return self.asked is not None and not self.asked.done()

    def work(self, docking: bool) -> "asyncio.Task[BaseReply]":
        task = self.loop.create_task((self.docking.dock if docking else self.docking.undock)(self.session_id))
        task.add_done_callback(lambda done: done.cancelled() or done.exception())  # a refusal is heard
        return task

    @rule(is_docked=st.booleans(), dock_visible=st.booleans(), at=st.sampled_from([DOCK, AFAR]))
    def sees(self, is_docked: bool, dock_visible: bool, at: Pose2D) -> None:
        def told() -> None:
            now_s = self.clock.now_s()
            self.senses.odometry.put(Odometry(now_s, DOCK, Twist2D()), now_s)
            self.senses.poses.add_odometry(now_s, DOCK)
            self.senses.poses.add_map_to_odom(now_s, at, received_s=now_s)
            self.senses.nav2_missing.put("", now_s)
            self.senses.dock.put(DockView(is_docked, dock_visible), now_s)

        self.now(told)

    @precondition(lambda self: not self.is_asked)
    @rule(docking=st.booleans())
    def asks(self, docking: bool) -> None:
        def ask() -> None:
            self.asked, self.given_up = self.work(docking), None

        self.now(ask)

    @precondition(lambda self: self.is_asked)
    @rule(docking=st.booleans())
    def asks_again(self, docking: bool) -> None:
        again: list[asyncio.Task[BaseReply]] = []
        self.now(lambda: again.append(self.work(docking)))
        assert isinstance(again[0].exception(), ConflictError)

    @rule(status=st.sampled_from([GoalStatus.SUCCEEDED, GoalStatus.ABORTED]))
    def nav2_ends(self, status: GoalStatus) -> None:
        self.now(lambda: self.world.end_goal(status))

    @precondition(lambda self: self.world.base is not None)
    @rule(done=st.booleans())
    def the_base_ends(self, done: bool) -> None:
        self.now(lambda: self.world.base is not None and self.world.base.set_result(done))

    @rule(
        status=st.sampled_from([None, GoalStatus.SUCCEEDED]), end=st.sampled_from([BaseEnd.STOPPED, BaseEnd.CANCELED])
    )
    def is_stopped(self, status: GoalStatus | None, end: BaseEnd) -> None:
        """As the emergency stop and the halt do; it may be the very moment in which Nav2 arrives."""
        self.given_up = self.given_up or (end if self.is_asked else None)

        def stop() -> None:
            self.world.end_goal(status or GoalStatus.CANCELED)
            self.wheels.halt()
            self.docking.stop(end)

        self.now(stop)
        assert not self.is_asked

    @rule()
    def its_session_ends(self) -> None:
        self.given_up = self.given_up or (BaseEnd.SESSION_ENDED if self.is_asked else None)
        self.now(lambda: self.docking.end_session(self.session_id))
        assert not self.is_asked

    @precondition(lambda self: self.is_asked)
    @rule()
    def the_client_leaves(self) -> None:
        self.now(lambda: self.asked is not None and self.asked.cancel())
        assert not self.is_asked

    @rule(seconds=st.sampled_from([LOOK_S + 0.1, TIME_LIMIT_S + 0.1]))
    def time_passes(self, seconds: float) -> None:
        self.loop_s += seconds
        self.now(lambda: None)

    @invariant()
    def one_thing_drives_and_only_while_it_was_asked_for(self) -> None:
        drives = {
            DockingPhase.IDLE: (False, False),
            DockingPhase.STAGING: (True, False),
            DockingPhase.LOOKING: (False, False),
            DockingPhase.BASE_DRIVES: (False, True),
        }
        assert (self.world.goal_id is not None, self.world.base is not None) == drives[self.docking.phase]
        assert (self.docking.phase is not DockingPhase.IDLE) == self.is_asked

    @invariant()
    def the_bridge_keeps_quiet_while_the_base_drives(self) -> None:
        assert self.wheels.base_is_busy == (self.world.base is not None)

    @invariant()
    def what_was_given_up_says_why(self) -> None:
        assert self.given_up is None or (self.asked is not None and self.asked.result().end is self.given_up)

    def teardown(self) -> None:
        self.now(lambda: self.docking.stop(BaseEnd.CANCELED))
        assert self.docking.phase is DockingPhase.IDLE
        assert asyncio.all_tasks(self.loop) == set()
        self.loop.close()
        self.folder.cleanup()


TestDockingMachine = DockingMachine.TestCase
TestDockingMachine.settings = settings(max_examples=60, stateful_step_count=25, deadline=None)


def test_the_table_names_every_phase_and_every_phase_can_be_left_and_reached() -> None:
    assert set(FOLLOWS) == set(DockingPhase)
    assert set().union(*FOLLOWS.values()) == set(DockingPhase)
    assert all(FOLLOWS.values())
