"""A goal that was accepted is somebody's: who asked for it, or nobody, and then it is cancelled."""

import asyncio
from collections.abc import Callable
from typing import Any

import pytest

from mesh.errors import ServiceTimeoutError
from robot_bridge.adapters.ros.calls import Calls


class Later:
    """A future of rclpy's, as far as `Calls` looks at one."""

    def __init__(self) -> None:
        self._callbacks: list[Callable[[Any], None]] = []
        self._result: Any = None

    def add_done_callback(self, callback: Callable[[Any], None]) -> None:
        self._callbacks.append(callback)

    def exception(self) -> None:
        return None

    def result(self) -> Any:
        return self._result

    def finish(self, result: Any) -> None:
        self._result = result
        for callback in self._callbacks:
            callback(self)


class Handle:
    accepted = True

    def __init__(self) -> None:
        self.cancels = 0

    def cancel_goal_async(self) -> None:
        self.cancels += 1


class Server:
    """An action's client, as far as `Calls` looks at one."""

    def __init__(self) -> None:
        self.acceptance = Later()

    def server_is_ready(self) -> bool:
        return True

    def send_goal_async(self, goal: Any, *, feedback_callback: Any) -> Later:
        return self.acceptance


def calls(accept_s_max: float = 60.0) -> Calls:
    return Calls(asyncio.get_running_loop(), lambda work: work(), accept_s_max=accept_s_max)


async def turn() -> None:
    """Whatever is ready to run in the loop runs, and what that makes ready."""
    for _ in range(5):
        await asyncio.sleep(0)


async def test_who_goes_away_before_the_acceptance_leaves_no_goal() -> None:
    server, handle = Server(), Handle()
    asking = asyncio.create_task(calls().send_goal(server, "arm", None))  # type: ignore[arg-type]
    await turn()
    asking.cancel()
    await turn()
    server.acceptance.finish(handle)
    await turn()
    assert handle.cancels == 1


async def test_who_goes_away_in_the_turn_of_the_acceptance_leaves_no_goal() -> None:
    server, handle = Server(), Handle()
    asking = asyncio.create_task(calls().send_goal(server, "arm", None))  # type: ignore[arg-type]
    await turn()
    server.acceptance.finish(handle)
    asyncio.get_running_loop().call_soon(asking.cancel)
    with pytest.raises(asyncio.CancelledError):
        await asking
    await turn()
    assert handle.cancels == 1


async def test_an_acceptance_in_the_turn_in_which_the_time_is_over_leaves_no_goal() -> None:
    server, handle = Server(), Handle()
    asking = asyncio.create_task(calls(accept_s_max=0.05).send_goal(server, "arm", None))  # type: ignore[arg-type]
    await turn()
    loop = asyncio.get_running_loop()
    waited_until_s = loop.time() + 0.06
    while loop.time() < waited_until_s:
        pass  # the loop is held up until both are due in one turn
    server.acceptance.finish(handle)
    with pytest.raises(ServiceTimeoutError):
        await asking
    await turn()
    assert handle.cancels == 1


async def test_a_goal_that_is_waited_for_is_left_alone() -> None:
    server, handle = Server(), Handle()
    asking = asyncio.create_task(calls().send_goal(server, "arm", None))  # type: ignore[arg-type]
    await turn()
    server.acceptance.finish(handle)
    assert await asking is not None
    assert handle.cancels == 0
