"""Crossing from asyncio to the robot's thread and back: actions and services whose answers asyncio awaits."""

import asyncio
from collections import deque
from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus as RosGoalStatus
from action_msgs.msg import GoalStatusArray
from rclpy.action.client import ActionClient
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.qos import qos_profile_action_status_default

from contracts.robot import GoalStatus
from mesh.errors import ServiceTimeoutError, UnavailableError
from robot_bridge.ports import GoalEnd

ENDS = {
    RosGoalStatus.STATUS_SUCCEEDED: GoalStatus.SUCCEEDED,
    RosGoalStatus.STATUS_CANCELED: GoalStatus.CANCELED,
    RosGoalStatus.STATUS_ABORTED: GoalStatus.ABORTED,
}


STATUS_S_MAX = 0.2
"""What an action's status topic says may come so much later than a goal's result."""


class Handover:
    """Work for an executor's thread, done in the order it was handed over: rclpy does the newest of its tasks first."""

    def __init__(self, executor: Executor) -> None:
        self._executor = executor
        self._waiting: deque[Callable[[], Any]] = deque()

    def put(self, work: Callable[[], Any]) -> None:
        """From any thread."""
        self._waiting.append(work)
        self._executor.create_task(self._do_next)

    def _do_next(self) -> None:
        self._waiting.popleft()()


class GoalsUnderWay:
    """Which goals of an action are under way, whoever sent them. Heard in the robot's thread, read in asyncio."""

    def __init__(self, node: Node, action: str) -> None:
        self._ids: frozenset[bytes] = frozenset()
        topic = f"{action}/_action/status"
        node.create_subscription(GoalStatusArray, topic, self._heard, qos_profile_action_status_default)

    def other_than(self, goal_id: bytes) -> bool:
        return bool(self._ids - {goal_id})

    def _heard(self, message: GoalStatusArray) -> None:
        going = {RosGoalStatus.STATUS_ACCEPTED, RosGoalStatus.STATUS_EXECUTING}
        self._ids = frozenset(
            bytes(each.goal_info.goal_id.uuid) for each in message.status_list if each.status in going
        )


class Calls:
    """Awaited in `loop`. `do` hands work to the robot's thread, which alone touches rclpy's clients."""

    def __init__(
        self, loop: asyncio.AbstractEventLoop, do: Callable[[Callable[[], Any]], None], *, accept_s_max: float
    ) -> None:
        """`accept_s_max` is how long a server may take to accept a goal."""
        self._loop = loop
        self._accept_s_max = accept_s_max
        self.do = do

    async def send_goal(
        self,
        client: ActionClient,
        server: str,
        goal: Any,
        feedback: Callable[[Any], None] | None = None,
        *,
        under_way: GoalsUnderWay | None = None,
    ) -> "RosGoal | None":
        """None when the server rejects it. Raises `UnavailableError` naming `server` when it is not there."""
        handle = await self.ask(
            server,
            lambda: client.send_goal_async(goal, feedback_callback=feedback),
            ready=client.server_is_ready,
            timeout_s=self._accept_s_max,
            too_late=lambda handle: handle.cancel_goal_async() if handle.accepted else None,
        )
        return RosGoal(self, handle, under_way) if handle.accepted else None

    async def ask(
        self,
        server: str,
        start: Callable[[], Any],
        *,
        ready: Callable[[], bool] | None = None,
        timeout_s: float | None,
        too_late: Callable[[Any], Any] | None = None,
    ) -> Any:
        """What the rclpy future of `start` (called in the robot's thread) becomes.

        `too_late` is called there with a result that nobody waits for any more.
        """
        answer: asyncio.Future[Any] = self._loop.create_future()

        def settle(done: Any) -> None:  # in asyncio
            if (error := done.exception()) is not None:
                _fail(answer, UnavailableError(server, f"{type(error).__name__}: {error}"))
            elif not answer.done():
                answer.set_result(done.result())
            elif (late := too_late) is not None:
                self.do(lambda: late(done.result()))

        def begin() -> None:  # in the robot's thread
            if ready is not None and not ready():
                self._loop.call_soon_threadsafe(_fail, answer, UnavailableError(server, "is not there"))
                return
            start().add_done_callback(lambda done: self._loop.call_soon_threadsafe(settle, done))

        self.do(begin)
        try:
            async with asyncio.timeout(timeout_s):
                return await answer
        except (asyncio.CancelledError, TimeoutError) as error:
            # the answer may have come in the very turn of the loop in which the waiting ended
            came = answer.done() and not answer.cancelled() and answer.exception() is None
            if came and (late := too_late) is not None:
                self.do(lambda: late(answer.result()))
            if isinstance(error, TimeoutError):
                raise ServiceTimeoutError(server, "did not answer in time") from error
            raise


class RosGoal:
    """An accepted goal of any action."""

    def __init__(self, calls: Calls, handle: Any, under_way: GoalsUnderWay | None = None) -> None:
        self._calls = calls
        self._handle = handle
        self._under_way = under_way

    async def result(self) -> Any:
        return await self._calls.ask("nav2", self._handle.get_result_async, timeout_s=None)

    async def end(self) -> GoalEnd:
        result = await self.result()
        status = ENDS.get(result.status, GoalStatus.ABORTED)
        return GoalEnd(status, int(result.result.error_code), str(result.result.error_msg)[:500])

    def cancel(self) -> None:
        self._calls.do(self._handle.cancel_goal_async)

    async def was_preempted(self) -> bool:
        await asyncio.sleep(STATUS_S_MAX)
        return self._under_way is not None and self._under_way.other_than(bytes(self._handle.goal_id.uuid))


def _fail(answer: "asyncio.Future[Any]", error: Exception) -> None:
    if not answer.done():
        answer.set_exception(error)
