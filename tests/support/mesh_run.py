"""A running mesh as a test sees it: HTTP from outside, ground truth, and signals to its processes."""

import os
import signal
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

import httpx

from demo.ready import missing, parts_of
from demo.stack import Stack

STILL_M_S = 0.005
STILL_RAD_S = 0.02


class MeshRun:
    """Everything is asked over HTTP; `truth` is the simulator's own, for judging only."""

    def __init__(self, stack: Stack) -> None:
        self.stack = stack
        self.ports = stack.ports
        self.http = httpx.Client(trust_env=False, timeout=30.0)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.http.close()

    def url(self, service: str, path: str) -> str:
        return f"{self.ports.url(service)}{path}"

    def get(self, service: str, path: str) -> Any:
        return self.http.get(self.url(service, path)).raise_for_status().json()

    def post(self, service: str, path: str, body: Any = None) -> httpx.Response:
        return self.http.post(self.url(service, path), json=body)

    def truth(self) -> dict[str, Any]:
        return self.get("truth", "/truth")

    def simulated_s(self) -> float:
        """Now, on the simulated clock."""
        return float(self.truth()["now_s"])

    def still(self) -> bool:
        twist = self.truth()["twist"]
        return abs(twist["linear_x"]) < STILL_M_S and abs(twist["angular_z"]) < STILL_RAD_S

    def pid(self, name: str) -> int:
        return self.stack.pid(name)

    def kill(self, name: str, number: signal.Signals = signal.SIGKILL) -> float:
        """Ends one process of the mesh, which is started again; returns the simulated time at which it was told to."""
        pid = self.pid(name)
        at_s = self.simulated_s()
        os.kill(pid, number)
        return at_s

    def ready(self) -> bool:
        return not self.lacking()

    def lacking(self) -> dict[str, str]:
        """What is not ready yet of each part that is not."""
        told = {part: missing(self.http, self.ports, part) for part in parts_of(self.stack)}
        return {part: why for part, why in told.items() if why is not None}

    def until(self, condition: Callable[[], bool], *, timeout_s: float, what: str) -> None:
        """Returns as soon as the condition holds; a service that is away counts as not yet."""
        deadline = time.monotonic() + timeout_s
        while time.monotonic() < deadline:
            try:
                if condition():
                    return
            except httpx.HTTPError:
                pass
            time.sleep(0.02)
        raise AssertionError(f"within {timeout_s} s this did not happen: {what}")

    def rested(self) -> None:
        """Ready, no mission, not stopped, standing still: where every test begins."""
        self.until(self.ready, timeout_s=120.0, what="every service ready")
        self.post("robot_bridge", "/emergency-stop/reset")
        mission = self.get("coordinator", "/state")["mission"]
        if mission is not None and mission["outcome"] is None:
            self.post("coordinator", f"/missions/{mission['id']}/cancel")
        self.until(lambda: self.get("coordinator", "/state")["state"] == "IDLE", timeout_s=60.0, what="an idle robot")
        self.until(self.still, timeout_s=45.0, what="a robot at rest")

    def driving(self, command: str = "find the red bottle") -> str:
        """Starts a mission and returns its id once the robot drives at more than 0.15 m/s."""
        mission_id = str(self.post("coordinator", "/missions", {"command": command}).raise_for_status().json()["id"])
        self.until(lambda: self.truth()["twist"]["linear_x"] > 0.15, timeout_s=120.0, what="a driving robot")
        return mission_id

    def stays_at_rest_for(self, seconds: float) -> None:
        """Watches the robot for a simulated time; any motion fails the test."""
        begun = self.truth()
        end_s = begun["time_s"] + seconds
        while (now := self.truth())["time_s"] < end_s:
            assert abs(now["twist"]["linear_x"]) < STILL_M_S, now
            assert now["path_length_m"] - begun["path_length_m"] < 0.01, now
