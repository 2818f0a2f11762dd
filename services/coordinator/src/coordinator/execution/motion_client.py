"""Motion, one at a time and in order: a stop ends what runs before anything new begins."""

import asyncio
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any

import structlog

from contracts.causes import SafetyCause
from contracts.geometry import Twist2D
from contracts.motion import MotionEnd
from contracts.robot import Goal, GoalRequest, GoalStatus, VelocityReply
from coordinator.execution.motion_phases import (
    FOLLOWS,
    Calling,
    Ending,
    Following,
    Idle,
    Leased,
    Motion,
    MotionPhase,
    Sending,
    Uncertain,
)
from coordinator.ports import Robot
from mesh.clock import Clock
from mesh.errors import MeshError

log = structlog.get_logger()

OVER = frozenset({
    GoalStatus.SUCCEEDED, GoalStatus.CANCELED, GoalStatus.ABORTED, GoalStatus.REJECTED, GoalStatus.TIMED_OUT,
})  # fmt: skip


END_WAIT_S = 1.5
"""A stop waits so long for word that what ran is over, a goal still being sent included; then it drops the session."""


class MotionClient:
    """Each `start` waits for what ran before, and ends a goal that is still followed; `stop` cancels what runs, its
    goal and any lease. Where it is not sure that nothing moves any more, it drops the session, which ends everything
    that was ever asked for in it.
    """

    def __init__(self, robot: Robot, clock: Clock, spawn: Callable[[Coroutine[Any, Any, Any]], "asyncio.Task[Any]"],
                 *, goal_poll_s: float, on_lease: Callable[[MotionEnd], None]) -> None:  # fmt: skip
        self._robot = robot
        self._clock = clock
        self._spawn = spawn
        self._goal_poll_s = goal_poll_s
        self._on_lease = on_lease
        self._motion: Motion = Idle()
        self._open: set[asyncio.Task[None]] = set()
        """What the next in line waits for."""

    @property
    def phase(self) -> MotionPhase:
        return self._motion.phase

    def mark_uncertain(self, epoch: int) -> None:
        """A call that moves the robot was not answered: it may be moving all the same, and is stopped before anything
        else begins.
        """
        self._end(self._motion, Uncertain(), epoch)

    def start(self, work: Callable[[], Awaitable[None]], epoch: int) -> None:
        """A goal of which no end was heard is ended first."""
        if isinstance(self._motion, Sending | Following):
            self.stop(epoch)
        self._become(Calling(self._chain(lambda: self._call(work))))

    def send_velocity(self, twist: Twist2D, duration_s: float, epoch: int) -> None:
        """Dropped while another motion runs or the last lease is still on its way."""
        if self.phase in {MotionPhase.IDLE, MotionPhase.LEASED} and all(task.done() for task in self._open):
            self._become(Leased())
            self._open = {self._spawn(self._send_lease(twist, duration_s, epoch))}

    def stop(self, epoch: int) -> None:
        motion = self._motion
        if isinstance(motion, Calling | Sending | Following):
            motion.task.cancel()
        if motion.phase.to_end:
            self._end(motion, Ending(), epoch)

    def on_goal_update(self, goal: Goal) -> None:
        """A goal's news from the bus: quicker than asking."""
        match self._motion:
            case Following(goal=mine, over=over) if mine.id == goal.id and goal.status in OVER and not over.done():
                over.set_result(goal)
            case _:
                pass

    async def navigate(self, request: GoalRequest) -> Goal:
        """The goal when it is over. Only inside the work of a `start`. A goal whose sending is interrupted is cancelled
        as soon as its id is known.
        """
        calling = self._motion
        assert isinstance(calling, Calling)
        answer = self._spawn(self._send(request))
        self._become(Sending(calling.task, answer))
        goal = await asyncio.shield(answer)
        if isinstance(goal, MeshError):
            self._become(calling)
            raise goal
        over: asyncio.Future[Goal] = asyncio.get_running_loop().create_future()
        self._become(Following(calling.task, goal, over))
        while goal.status not in OVER:
            polling = asyncio.ensure_future(self._clock.sleep(self._goal_poll_s))
            try:
                await asyncio.wait({polling, over}, return_when=asyncio.FIRST_COMPLETED)
            finally:
                polling.cancel()
            goal = over.result() if over.done() else await self._robot.goal(goal.id)
        self._become(calling)
        return goal

    async def _send(self, request: GoalRequest) -> Goal | MeshError:
        """The failure is given back, not raised: whoever waited for it may be gone."""
        try:
            return await self._robot.navigate(request)
        except MeshError as error:
            return error

    def _become(self, motion: Motion) -> None:
        if motion.phase not in FOLLOWS[self.phase]:
            raise RuntimeError(f"a motion cannot be {motion.phase} after it was {self.phase}")
        self._motion = motion

    def _chain(self, work: Callable[[], Awaitable[None]]) -> "asyncio.Task[None]":
        before = {task for task in self._open if not task.done()}
        task = self._spawn(self._after(before, work))
        self._open = {*before, task}
        return task

    async def _after(self, before: "set[asyncio.Task[None]]", work: Callable[[], Awaitable[None]]) -> None:
        if before:
            await asyncio.wait(before)
        await work()

    async def _call(self, work: Callable[[], Awaitable[None]]) -> None:
        """A goal of which no end was heard is still followed afterwards: the next stop or start cancels it."""
        await work()
        if isinstance(self._motion, Calling) and self._motion.task is asyncio.current_task():
            self._become(Idle())

    def _end(self, motion: Motion, ending: Ending | Uncertain, epoch: int) -> None:
        self._become(ending)
        self._chain(lambda: self._halt(motion, ending, epoch))

    async def _halt(self, motion: Motion, ending: Ending | Uncertain, epoch: int) -> None:
        if isinstance(ending, Uncertain):
            await self._robot.drop_session()
        else:
            asked = self._spawn(self._ended(motion, epoch))
            if not (await self._answered(asked) and asked.result()):
                asked.cancel()
                await self._robot.drop_session()
        if self._motion is ending:
            self._become(Idle())

    async def _ended(self, motion: Motion, epoch: int) -> bool:
        """Whether the bridge says that what was asked for last is over."""
        try:
            match motion:
                case Sending(answer=answer):
                    sent = await answer
                    if isinstance(sent, MeshError):
                        raise sent
                    await self._robot.cancel_goal(sent.id)
                case Following(goal=goal):
                    await self._robot.cancel_goal(goal.id)
                case Leased():
                    await self._robot.velocity(Twist2D(), duration_s=0.3, epoch=epoch)
                case _:
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
