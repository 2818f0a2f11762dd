"""The cancel of every goal of an action, whoever sent it: asked for until the action's server has answered it."""

from typing import Any

import structlog
from action_msgs.srv import CancelGoal
from rclpy.node import Node

from mesh.clock import Clock
from mesh.errors import UnavailableError
from mesh.latest_value import LatestValue
from robot_bridge.arm.owed_cancel import AGAIN_S, OwedCancel

log = structlog.get_logger()


class GoalCancels:
    """Of one action. Owed from the start: an earlier process may have left goals. A server that is out of reach is
    asked once it is back. Made and polled in the robot's thread."""

    def __init__(self, node: Node, action: str, server: str, clock: Clock) -> None:
        """`server` names who runs the goals, in errors."""
        self._client = node.create_client(CancelGoal, f"{action}/_action/cancel_goal")
        self._action = action
        self._server = server
        self._clock = clock
        self._owed = OwedCancel()
        self._settled: LatestValue[bool] = LatestValue()
        self._asked: Any = None
        self._there = False
        self._refused = False

    def owe(self) -> None:
        """From any thread, before `poll`: from here on `settle` waits."""
        self._owed.owe(self._clock.now_s())

    def poll(self) -> None:
        """Every second, and at once after `owe`."""
        now_s = self._clock.now_s()
        self._there = self._client.service_is_ready()
        if not self._there:
            return
        self._owed.there(True, now_s)
        if (number := self._owed.due(now_s)) is None:
            return
        if self._asked is not None:
            self._client.remove_pending_request(self._asked)
        self._asked = self._client.call_async(CancelGoal.Request())  # no id, no time: every goal
        self._asked.add_done_callback(lambda done: self._answered(number, done))

    @property
    def owed(self) -> bool:
        return self._owed.owed

    def late(self) -> bool:
        """Whether something has been owed for longer than an answer takes."""
        return self._owed.owed_for_s(self._clock.now_s()) > AGAIN_S

    async def settle(self, timeout_s: float) -> None:
        """In asyncio: a goal sent before this returns could be taken for one of those that are to be cancelled. Raises
        `UnavailableError` where the server is not there or does not answer in time."""
        if self.owed and await self._settled.wait_for(lambda _: not self.owed, timeout_s) is None:
            why = "has not answered yet that its goals are cancelled" if self._there else "is not there"
            raise UnavailableError(self._server, why)

    def _answered(self, number: int, done: Any) -> None:
        if done.cancelled() or done.exception() is not None or (answer := done.result()) is None:
            return
        refused = answer.return_code == CancelGoal.Response.ERROR_REJECTED
        if refused and not self._refused:
            log.error("the goals of an action go on though they are to be cancelled; asking again", action=self._action)
        self._refused = refused
        if refused:
            return
        if left := len(answer.goals_canceling):
            log.info("goals are cancelled", action=self._action, goals=left)
        self._owed.answered(number)
        self._settled.put(True, self._clock.now_s())
