"""Motion, one at a time and in order: a stop ends what runs before anything new begins."""

import asyncio
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any

import structlog

from contracts.causes import SafetyCause
from contracts.geometry import Pose2D, Twist2D
from contracts.motion import MotionEnd
from contracts.robot import Goal, GoalStatus, VelocityReply
from coordinator.ports import Robot
from mesh.clock import Clock
from mesh.errors import MeshError

log = structlog.get_logger()

OVER = frozenset({
    GoalStatus.SUCCEEDED, GoalStatus.CANCELED, GoalStatus.ABORTED, GoalStatus.REJECTED, GoalStatus.TIMED_OUT,
})  # fmt: skip


END_WAIT_S = 1.5
"""A stop waits so long for word that what ran is over, a goal still being sent included; then it drops the session."""


class Motions:
    """Each `start` waits for what ran before; `stop` cancels it, the goal it had sent, and any lease. Where it is not
    sure that nothing moves any more, it drops the session, and everything ends that was ever asked for in it.
    """

    def __init__(self, robot: Robot, clock: Clock, spawn: Callable[[Coroutine[Any, Any, Any]], "asyncio.Task[Any]"],
                 *, goal_poll_s: float, on_lease: Callable[[MotionEnd], None]) -> None:  # fmt: skip
        self._robot = robot
        self._clock = clock
        self._spawn = spawn
        self._goal_poll_s = goal_poll_s
        self._on_lease = on_lease
        self._open: set[asyncio.Task[None]] = set()
        self._running: asyncio.Task[None] | None = None
        self._lease: asyncio.Task[None] | None = None
        self._sending: asyncio.Task[Goal | MeshError] | None = None
        self._goal: Goal | None = None
        self._over: asyncio.Future[Goal] | None = None
        self._in_doubt = False

    def doubt(self, epoch: int) -> None:
        """A call that moves the robot was not answered: it may be moving all the same, and is stopped before anything
        else begins.
        """
        self._in_doubt = True
        self._chain(lambda: self._halt(None, epoch))

    def start(self, work: Callable[[], Awaitable[None]]) -> None:
        self._running = self._chain(work)

    def lease(self, twist: Twist2D, duration_s: float, epoch: int) -> None:
        """Dropped while another motion runs or the last lease is still on its way."""
        busy = any(not task.done() for task in (*self._open, *filter(None, (self._lease,))))
        if not busy:
            self._lease = self._spawn(self._send_lease(twist, duration_s, epoch))

    def stop(self, epoch: int) -> None:
        leased, self._lease = self._lease, None
        running, self._running = self._running, None
        moving = running is not None and not running.done()
        if moving and running is not None:
            running.cancel()
        if moving or leased is not None or self._goal is not None or self._in_doubt:
            self._chain(lambda: self._halt(leased, epoch))

    def heard(self, goal: Goal) -> None:
        """A goal's news from the bus: quicker than asking."""
        mine = self._goal is not None and goal.id == self._goal.id
        if mine and goal.status in OVER and self._over is not None and not self._over.done():
            self._over.set_result(goal)

    async def navigate(self, pose: Pose2D, timeout_s: float, epoch: int) -> Goal:
        """The goal when it is over. A goal whose sending is interrupted is cancelled as soon as its id is known."""
        self._over = asyncio.get_running_loop().create_future()
        self._sending = self._spawn(self._send(pose, timeout_s, epoch))
        sent = await asyncio.shield(self._sending)
        self._sending = None
        if isinstance(sent, MeshError):
            raise sent
        self._goal = goal = sent
        while goal.status not in OVER:
            polling = asyncio.ensure_future(self._clock.sleep(self._goal_poll_s))
            try:
                await asyncio.wait({polling, self._over}, return_when=asyncio.FIRST_COMPLETED)
            finally:
                polling.cancel()
            goal = self._over.result() if self._over.done() else await self._robot.goal(goal.id)
        self._goal = None
        return goal

    async def _send(self, pose: Pose2D, timeout_s: float, epoch: int) -> Goal | MeshError:
        """The failure is given back, not raised: whoever waited for it may be gone."""
        try:
            return await self._robot.navigate(pose, timeout_s=timeout_s, epoch=epoch)
        except MeshError as error:
            return error

    def _chain(self, work: Callable[[], Awaitable[None]]) -> "asyncio.Task[None]":
        before = {task for task in self._open if not task.done()}
        task = self._spawn(self._after(before, work))
        self._open = {*before, task}
        return task

    async def _after(self, before: "set[asyncio.Task[None]]", work: Callable[[], Awaitable[None]]) -> None:
        if before:
            await asyncio.wait(before)
        await work()

    async def _halt(self, leased: "asyncio.Task[None] | None", epoch: int) -> None:
        if leased is not None:
            await asyncio.wait({leased})
        if self._in_doubt:
            self._in_doubt, self._goal = False, None
            await self._robot.drop_session()
            if self._sending is None:
                return
        ending = self._spawn(self._ended(leased, epoch))
        if not (await self._answered(ending) and ending.result()):
            ending.cancel()
            await self._robot.drop_session()

    async def _ended(self, leased: "asyncio.Task[None] | None", epoch: int) -> bool:
        """Whether the bridge says that what was asked for last is over."""
        sending, self._sending = self._sending, None
        goal, self._goal = self._goal, None
        try:
            if sending is not None:
                sent = await sending
                if isinstance(sent, MeshError):
                    raise sent
                goal = sent
            if goal is not None:
                await self._robot.cancel_goal(goal.id)
            elif leased is not None:
                await self._robot.velocity(Twist2D(), duration_s=0.3, epoch=epoch)
            else:
                await self._robot.end_motion()
        except MeshError as error:
            log.warning("the motion could not be ended: dropping the session, which ends it", error=error.detail)
            return False
        return True

    async def _answered(self, call: "asyncio.Task[Any]") -> bool:
        """Whether its answer comes soon: the robot may be driving meanwhile."""
        waiting = asyncio.ensure_future(self._clock.sleep(END_WAIT_S))
        try:
            await asyncio.wait({call, waiting}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            waiting.cancel()
        return call.done()

    async def _send_lease(self, twist: Twist2D, duration_s: float, epoch: int) -> None:
        try:
            reply = await self._robot.velocity(twist, duration_s=duration_s, epoch=epoch)
        except MeshError as error:
            log.warning("a velocity was not taken", error=error.detail)
            self._on_lease(MotionEnd.HELD_BACK)
        else:
            self._on_lease(held_by(reply))


def held_by(reply: VelocityReply) -> MotionEnd:
    """How a motion of such leases ends should it not move: by the gravest of what holds it back."""
    ends = (cause.ends_as for cause in reply.causes if isinstance(cause, SafetyCause))
    return next((end for end in ends if end is not None), MotionEnd.HELD_BACK)
