"""The simulated robot as a process, and a client's node that talks to it over DDS."""

import json
import subprocess
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from rclpy.action import ActionClient
from rclpy.node import Node


def wait_for(condition: Callable[[], Any], what: str, *, timeout_s: float = 45.0) -> Any:
    """The first true value of `condition()`; fails the test when there is none in time."""
    deadline = time.monotonic() + timeout_s
    pause = threading.Event()
    while time.monotonic() < deadline:
        if value := condition():
            return value
        pause.wait(0.01)
    raise AssertionError(f"waited {timeout_s} s in vain for {what}")


@dataclass
class SimProcess:
    """A running `python -m sim`."""

    process: "subprocess.Popen[bytes]"
    base_url: str

    def get(self, path: str) -> Any:
        with urllib.request.urlopen(self.base_url + path, timeout=30) as response:
            return json.load(response)

    def status(self, path: str) -> int:
        try:
            with urllib.request.urlopen(self.base_url + path, timeout=30) as response:
                return int(response.status)
        except urllib.error.HTTPError as error:
            return error.code
        except OSError:
            return 0

    def truth(self) -> Any:
        return self.get("/truth")

    def at_rest(self) -> bool:
        twist = self.truth()["twist"]
        return abs(twist["linear_x"]) < 0.01 and abs(twist["angular_z"]) < 0.03


@dataclass
class Mission:
    """A client's node: subscriptions that keep the newest message, actions, services, and a relay of velocities."""

    node: Node
    newest: dict[str, Any] = field(default_factory=dict)
    relaying: bool = False

    def listen(self, topic: str, kind: Any, qos: Any) -> None:
        def keep(message: Any) -> None:
            self.newest[topic] = message

        self.node.create_subscription(kind, topic, keep, qos)

    def hear(self, topic: str) -> Any:
        return wait_for(lambda: self.newest.get(topic), f"a message on {topic}")

    def hear_new(self, topic: str) -> Any:
        self.newest.pop(topic, None)
        return self.hear(topic)

    def send_goal(self, client: ActionClient, goal: Any, on_feedback: Callable[[Any], None] | None = None) -> Any:
        """The goal handle, accepted or not."""
        assert client.wait_for_server(timeout_sec=60.0)
        return answered(lambda: client.send_goal_async(goal, feedback_callback=on_feedback))

    def run_goal(self, client: ActionClient, goal: Any, *, timeout_s: float = 90.0) -> Any:
        """(status, result) of an accepted goal at its end."""
        handle = self.send_goal(client, goal)
        assert handle.accepted
        return done(handle.get_result_async(), timeout_s=timeout_s)

    def call(self, kind: Any, name: str, request: Any) -> Any:
        client = self.node.create_client(kind, name)
        assert client.wait_for_service(timeout_sec=60.0)
        return answered(lambda: client.call_async(request))


def answered(ask: Callable[[], Any]) -> Any:
    """Asked again when nothing comes: two ends that only just found each other may lose the first answer."""
    futures: list[Any] = []

    def any_done() -> Any:
        return next((future for future in futures if future.done()), None)

    for _ in range(5):
        futures.append(ask())
        try:
            return wait_for(any_done, "an answer", timeout_s=15.0).result()
        except AssertionError:
            continue
    raise AssertionError("asked five times in vain")


def done(future: Any, *, timeout_s: float = 90.0) -> Any:
    wait_for(future.done, "an answer", timeout_s=timeout_s)
    return future.result()
