"""A second process that answers, and this process's ends of the same wire."""

import os
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

with warnings.catch_warnings():
    # rclpy's first message imports a parser that uses deprecated modules; tests turn that into an error.
    warnings.filterwarnings("ignore", "module 'sre_.+' is deprecated", DeprecationWarning)
    import rosidl_generator_py  # noqa: F401

TIMEOUT_S = 60.0
TRIES = 12
ANSWER_S = 5.0
"""Two ends that only just found each other may lose an answer or a feedback: it is asked for again after this long."""
KEPT = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class WireClient(Node):
    """Sends and waits; every wait ends when its condition holds, or fails the test."""

    def __init__(self, name: str, *, namespace: str) -> None:
        super().__init__(name, namespace=namespace)
        self._actions: dict[str, ActionClient] = {}

    def until(self, condition: Callable[[], bool]) -> None:
        assert self.within(TIMEOUT_S, condition), "nothing came back in time"

    def within(self, seconds: float, condition: Callable[[], bool]) -> bool:
        deadline_s = time.monotonic() + seconds
        while not condition() and time.monotonic() < deadline_s:
            rclpy.spin_once(self, timeout_sec=0.05)
        return condition()

    def answer(self, ask: Callable[[], Any]) -> Any:
        """What the future of `ask` becomes, asked again when nothing comes."""
        for _ in range(TRIES):
            future = ask()
            if self.within(ANSWER_S, future.done):
                return future.result()
        raise AssertionError("nothing came back in time")

    def start_goal(self, kind: Any, name: str, goal: Any) -> tuple[Any, list[Any]]:
        """The handle of a goal that was judged, and the list to which its feedback comes."""
        feedback: list[Any] = []
        client = self._action(kind, name)
        return self.answer(
            lambda: client.send_goal_async(goal, lambda message: feedback.append(message.feedback))
        ), feedback

    def start_goal_with_feedback(self, kind: Any, name: str, goal: Any) -> tuple[Any, list[Any]]:
        """The handle of an accepted goal that has sent feedback."""
        for _ in range(TRIES):
            handle, feedback = self.start_goal(kind, name, goal)
            assert handle.accepted
            if self.within(ANSWER_S, lambda: bool(feedback)):  # noqa: B023 - called before the next turn
                return handle, feedback
        raise AssertionError("no feedback came back in time")

    def finish_goal(self, kind: Any, name: str, goal: Any) -> tuple[int, Any]:
        """The goal's final status and its result."""
        handle, _ = self.start_goal(kind, name, goal)
        assert handle.accepted
        return self.outcome(handle)

    def outcome(self, handle: Any) -> tuple[int, Any]:
        outcome = self.answer(handle.get_result_async)
        assert outcome.status != GoalStatus.STATUS_UNKNOWN
        return outcome.status, outcome.result

    def call(self, kind: Any, name: str, request: Any) -> Any:
        client = self.create_client(kind, name)
        self.until(client.service_is_ready)
        return self.answer(lambda: client.call_async(request))

    def _action(self, kind: Any, name: str) -> ActionClient:
        if name not in self._actions:
            self._actions[name] = ActionClient(self, kind, name)
        self.until(self._actions[name].server_is_ready)
        return self._actions[name]

    def echo(self, message: Any) -> Any:
        """The message as it comes back from the other process."""
        kind, came_back = type(message), []
        self.create_subscription(kind, f"{kind.__name__}_echo", came_back.append, KEPT)
        self.create_publisher(kind, kind.__name__, KEPT).publish(message)
        self.until(lambda: bool(came_back))
        return came_back[0]


@pytest.fixture(scope="module")
def wire() -> Iterator[WireClient]:
    """A client of a server process of its own, in a ROS domain and a namespace that nobody else uses."""
    domain_id, namespace = 1 + os.getpid() % 100, f"/wire_{os.getpid()}"
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        environment.setenv("ROS_DOMAIN_ID", str(domain_id))
        server = subprocess.Popen([sys.executable, str(Path(__file__).parent / "wire_server.py"), namespace])
        rclpy.init(domain_id=domain_id)
        try:
            node = WireClient("wire_client", namespace=namespace)
            yield node
            node.destroy_node()
        finally:
            rclpy.try_shutdown()
            server.terminate()
            server.wait(timeout=TIMEOUT_S)
