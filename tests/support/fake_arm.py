"""An arm whose joints are always where its controllers want them; the controllers are the simulated arm's own.

Its twin is the simulated arm over ROS: one suite runs over both (`support.arm_behaviour`).
"""

import asyncio
import contextlib
import time
from collections.abc import AsyncIterator, Callable

from contracts.arm import ArmEnd, ArmPart, TrajectoryPoint
from mesh.clock import SystemClock
from mesh.errors import ServiceTimeoutError, UnavailableError
from mesh.latest_value import LatestValue
from robot_bridge.arm.joint_states import JointStates
from robot_bridge.arm.models import SO101, ArmModel
from sim.world.arm.controller import GripperController, Outcome, Tolerances, TrajectoryController
from sim.world.arm.trajectory import Knot, Trajectory

STEP_S = 0.01
JAW_RAD_S = 3.0
ENDS = {
    Outcome.SUCCEEDED: ArmEnd.COMPLETED,
    Outcome.HELD: ArmEnd.CANCELED,
    Outcome.PATH_TOLERANCE: ArmEnd.OFF_PATH,
    Outcome.GOAL_TOLERANCE: ArmEnd.NOT_REACHED,
    Outcome.STALLED: ArmEnd.STALLED,
}


class FakeArmGoal:
    def __init__(self, outcome: Callable[[], Outcome]) -> None:
        self._outcome = outcome

    async def end(self) -> ArmEnd:
        while (outcome := self._outcome()) is Outcome.RUNNING:  # noqa: ASYNC110 - the controllers are polled
            await asyncio.sleep(STEP_S)
        return ENDS[outcome]


class FakeArm:
    """What is to be set, and `cancels` to look at."""

    def __init__(self) -> None:
        self.there = True
        self.rejects = False
        self.told = True
        """Whether joint_states come."""
        self.jaw_stops_at: float | None = None
        """Something between the jaws, rad."""
        self.hangs = False
        """A goal's end is never told."""
        self.loses_acceptance = False
        """A goal is taken, and the answer never comes."""
        self.cancels = 0
        """Of both parts together."""
        self.owes = set[ArmPart]()
        """Parts whose controller does not answer a cancel."""
        self._joints: LatestValue[JointStates] = LatestValue()
        self._clock = SystemClock()
        self._trajectory = TrajectoryController(SO101.home_rad)
        self._gripper = GripperController(0.0)
        self._jaw = 0.0
        self._last = self._positions()
        self._tell()

    @property
    def model(self) -> ArmModel:
        return SO101

    @property
    def joints(self) -> LatestValue[JointStates]:
        return self._joints

    def missing(self) -> str:
        return "" if self.there else "nobody offers arm_controller/follow_joint_trajectory"

    async def follow(self, points: tuple[TrajectoryPoint, ...]) -> FakeArmGoal | None:
        self._must_be_there()
        if self.rejects:
            return None
        knots = tuple(Knot(each.time_s, each.positions_rad, each.velocities_rad_s) for each in points)
        controller = self._trajectory
        controller.follow(Trajectory(SO101.names, knots), Tolerances(), time.monotonic())
        if self.loses_acceptance:
            raise ServiceTimeoutError("arm", "did not answer in time")
        hangs = self.hangs
        return FakeArmGoal(lambda: Outcome.RUNNING if hangs else controller.outcome)

    async def grip(self, position: float, effort_max: float) -> FakeArmGoal | None:
        self._must_be_there()
        if self.rejects:
            return None
        controller = self._gripper
        controller.grip(position, effort_max, time.monotonic())
        return FakeArmGoal(lambda: controller.outcome)

    @property
    def jaw_wanted(self) -> float:
        """Where the jaw is sent, rad."""
        return self._gripper.wanted

    @property
    def jaw_effort_max(self) -> float:
        """The most it was last told to press with, Nm."""
        return self._gripper.max_effort

    def cancel(self, part: ArmPart) -> None:
        self.cancels += 1
        if part is ArmPart.ARM:
            self._trajectory.hold(self._trajectory.wanted)
        else:
            self._gripper.hold(self._jaw)

    def owes_cancel(self, part: ArmPart) -> bool:
        return part in self.owes

    def move_by_somebody_else(self, to: tuple[float, ...], seconds: float) -> None:
        """Another client of the controller sends a trajectory."""
        self._trajectory.follow(Trajectory(SO101.names, (Knot(seconds, to),)), Tolerances(), time.monotonic())

    @contextlib.asynccontextmanager
    async def alive(self) -> AsyncIterator["FakeArm"]:
        living = asyncio.create_task(self._live(), name="fake-arm")
        try:
            yield self
        finally:
            living.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await living

    async def _live(self) -> None:
        while True:
            self._step(time.monotonic())
            await asyncio.sleep(STEP_S)

    def _step(self, now_s: float) -> None:
        self._trajectory.tick(now_s, self._trajectory.wanted)
        before, way = self._jaw, self._gripper.wanted - self._jaw
        self._jaw += max(-JAW_RAD_S * STEP_S, min(JAW_RAD_S * STEP_S, way))
        if self.jaw_stops_at is not None:
            self._jaw = max(self._jaw, self.jaw_stops_at)
        self._gripper.tick(now_s, self._jaw, (self._jaw - before) / STEP_S)
        self._tell()

    def _tell(self) -> None:
        if not self.told:
            return
        positions, before = self._positions(), self._last
        rates = {name: (positions[name] - before[name]) / STEP_S for name in positions}
        now_s = self._clock.now_s()
        states = JointStates(positions, rates, dict.fromkeys(positions, 0.0), dict.fromkeys(positions, now_s))
        self._joints.put(states, now_s)
        self._last = positions

    def _positions(self) -> dict[str, float]:
        return dict(zip((*SO101.names, SO101.jaw.joint), (*self._trajectory.wanted, self._jaw), strict=True))

    def _must_be_there(self) -> None:
        if not self.there:
            raise UnavailableError("arm", "is not there")
