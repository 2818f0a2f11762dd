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
KEPT = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class WireClient(Node):
    """Sends and waits; every wait ends when its condition holds, or fails the test."""

    def until(self, condition: Callable[[], bool]) -> None:
        deadline_s = time.monotonic() + TIMEOUT_S
        while not condition():
            assert time.monotonic() < deadline_s, "nothing came back in time"
            rclpy.spin_once(self, timeout_sec=0.05)

    def answer(self, future: Any) -> Any:
        self.until(future.done)
        return future.result()

    def start_goal(self, kind: Any, name: str, goal: Any) -> tuple[Any, list[Any]]:
        """The goal's handle, accepted or not, and the list to which its feedback comes."""
        feedback: list[Any] = []
        client = ActionClient(self, kind, name)
        self.until(client.server_is_ready)
        future = client.send_goal_async(goal, feedback_callback=lambda message: feedback.append(message.feedback))
        return self.answer(future), feedback

    def finish_goal(self, kind: Any, name: str, goal: Any) -> tuple[int, Any, list[Any]]:
        """The goal's final status, its result and its feedback so far."""
        handle, feedback = self.start_goal(kind, name, goal)
        assert handle.accepted
        outcome = self.answer(handle.get_result_async())
        assert outcome.status != GoalStatus.STATUS_UNKNOWN
        return outcome.status, outcome.result, feedback

    def call(self, kind: Any, name: str, request: Any) -> Any:
        client = self.create_client(kind, name)
        self.until(client.service_is_ready)
        return self.answer(client.call_async(request))

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
