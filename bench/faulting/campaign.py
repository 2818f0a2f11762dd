"""A running mesh with a faulty wire and a mortal Nav2, and the hands to break both."""

import math
import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx

from bench.faulting.wire import TOPICS
from contracts.geometry import Pose2D
from contracts.mission import Mission, Outcome
from contracts.problem import Readiness
from demo.ready import missing, wait_until_ready
from demo.stack import ROOT, Stack
from geometry.poses import compose
from support.mesh_run import STILL_M_S, MeshRun

Observed = dict[str, Any]
LONG_S = 60.0
BEGINS_S = 600.0
MISSION_S = 400.0
"""As long as a mission may take, on a machine that others use too."""
UNDOCKED_M = 0.5
CIRCLE = {"linear_x": 0.1, "angular_z": 0.5}
"""Moves, and stays where it is."""


class Lease:
    """Renews a lease on the wheels ten times a second, as teleoperation does; `replies` are the bridge's."""

    def __init__(self, url: str, twist: dict[str, float]) -> None:
        self.replies: list[dict[str, Any]] = []
        self._url = url
        self._twist = twist
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._live)

    def __enter__(self) -> "Lease":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()

    @property
    def reason(self) -> str:
        return str(self.replies[-1].get("reason", "")) if self.replies else ""

    def held_by(self, causes: Collection[str]) -> bool:
        """Whether the last reply names one of these causes."""
        return bool(self.replies) and not set(causes).isdisjoint(self.replies[-1].get("causes", ()))

    def _live(self) -> None:
        with httpx.Client(base_url=self._url, trust_env=False, timeout=5.0) as http:
            while not self._ended.wait(0.1):
                try:
                    epoch = http.get("/emergency-stop").json()["epoch"]
                    body = {"twist": self._twist, "source": "faults", "epoch": epoch, "duration_s": 1.5}
                    self.replies.append(http.post("/velocity", json=body).json())
                except (httpx.HTTPError, ValueError):
                    continue


class Campaign:
    """`light` leaves out the services that a fault of the bridge's own does not concern."""

    def __init__(self, stack: Stack, folder: Path, *, light: bool) -> None:
        self.stack = stack
        self.light = light
        self.mesh = MeshRun(stack)
        self.url = stack.ports.url("robot_bridge")
        self._folder = folder
        self._environment = os.environ | {
            "ROS_DOMAIN_ID": str(stack.ports.ros_domain_id),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(folder / "ros"),
        }
        self._chance = random.Random(1)

    def __enter__(self) -> "Campaign":
        self._wire = self._start("bench.faulting.wire", stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.start_nav2()
        return self

    def __exit__(self, *_: object) -> None:
        self.mesh.http.close()
        for process in (self._wire, self._nav2):
            process.kill()
            process.wait()

    def _start(self, module: str, **options: Any) -> "subprocess.Popen[Any]":
        return subprocess.Popen([sys.executable, "-m", module], env=self._environment, cwd=ROOT, **options)

    def wire(self, mode: str, *topics: str) -> None:
        """Returns when the wire obeys."""
        assert self._wire.stdin is not None
        assert self._wire.stdout is not None
        for topic in topics:
            self._wire.stdin.write(f"{topic} {mode}\n")
            self._wire.stdin.flush()
            self._wire.stdout.readline()

    def start_nav2(self) -> None:
        self._nav2 = self._start("bench.faulting.nav2_relay")

    def kill_nav2(self) -> None:
        self._nav2.kill()
        self._nav2.wait()

    def step_clock(self, seconds: int) -> bool:
        """Sets the wall clock of every process of the mesh off by so much; false where libfaketime is not installed."""
        clock = self._folder / "clock"
        if not clock.exists():
            return False
        beside = clock.with_suffix(".new")
        beside.write_text(f"{seconds:+d}\n")
        beside.replace(clock)
        return True

    def begin(self) -> None:
        """Waits until everything is there. Raises `StackError`, which names what is missing."""
        self.mesh.until(self.stack.running, timeout_s=LONG_S, what="a supervisor")
        if self.light:
            for name in set(self.stack.calls) - {"robot_bridge"}:
                self.supervise("stopProcess", name)
            self.mesh.until(self.ready, timeout_s=BEGINS_S, what="the bridge ready")
        else:
            wait_until_ready(
                self.stack, timeout_s=BEGINS_S, on_ready=lambda part, seconds: None, alive=self.stack.running
            )

    def ready(self) -> bool:
        return not self.missing() if self.light else self.mesh.ready()

    def rested(self) -> None:
        """Ready, not stopped, standing still: where every fault begins."""
        if not self.light:
            self.mesh.rested()
            return
        self.mesh.until(self.ready, timeout_s=LONG_S * 2, what="a ready bridge")
        self.reset()
        self.mesh.until(self.mesh.still, timeout_s=LONG_S, what="a robot at rest")

    def mend(self) -> None:
        """Everything as it was, whatever a fault has left."""
        self.wire("pass", *TOPICS)
        self.step_clock(0)
        if self._nav2.poll() is not None:
            self.start_nav2()
        for name in ("redis",) if self.light else ("redis", *self.stack.calls):
            if self.stack.states().get(name) in {"STOPPED", "EXITED", "FATAL"}:
                self.supervise("startProcess", name)
        if pid := self.mesh.pid("coordinator"):
            os.kill(pid, signal.SIGCONT)
        try:
            self.mesh.until(self.ready, timeout_s=LONG_S * 2, what="the mesh ready again")
        except AssertionError as error:
            lacking = self.missing() if self.light else self.mesh.lacking()
            raise AssertionError(f"{error}; {lacking}, {self.stack.states()}") from error

    def supervise(self, method: str, name: str) -> None:
        self.stack._ask(method, name)

    @contextmanager
    def circling(self) -> Iterator[Lease]:
        """The robot drives in a small circle on a lease renewed over HTTP."""
        with Lease(self.url, CIRCLE) as lease:
            self.mesh.until(self.translating, timeout_s=LONG_S, what="a driving robot")
            yield lease

    def translating(self) -> bool:
        return abs(self.mesh.truth()["twist"]["linear_x"]) > 0.05

    def standing(self) -> bool:
        return abs(self.mesh.truth()["twist"]["linear_x"]) < STILL_M_S

    def seconds_until(self, condition: Callable[[], bool], what: str, *, timeout_s: float = 20.0) -> float:
        """Simulated seconds until it holds. Fails the attempt when it never does."""
        since_s = self.mesh.simulated_s()
        self.mesh.until(condition, timeout_s=timeout_s, what=what)
        return round(self.mesh.simulated_s() - since_s, 2)

    def rest_after(self, since_s: float) -> float:
        """Simulated seconds from `since_s` to the robot's last motion, as the simulation kept it."""
        self.mesh.until(self.mesh.still, timeout_s=LONG_S, what="a robot at rest")
        return round(max(0.0, float(self.mesh.truth()["moved_at_s"]) - since_s), 2)

    def drives(self, seconds: float) -> float:
        """Metres driven while so much simulated time passes."""
        begun = self.mesh.truth()
        end_s = begun["time_s"] + seconds
        self.mesh.until(lambda: self.mesh.truth()["time_s"] >= end_s, timeout_s=LONG_S, what="time passing")
        return round(float(self.mesh.truth()["path_length_m"] - begun["path_length_m"]), 2)

    def drives_on(self, seconds: float, *, before_m: float) -> float:
        """As `drives`, once it is half of what it was before the fault. Fails the attempt if it never is.

        Measured against itself: on a busy machine the simulated robot drives less than it was asked to, fault or none.
        """
        assert before_m > 0.0, "it did not drive before the fault either"
        metres = 0.0

        def as_before() -> bool:
            nonlocal metres
            metres = self.drives(seconds)
            return metres >= before_m / 2.0

        self.mesh.until(
            as_before, timeout_s=LONG_S, what=f"half of the {before_m} m in {seconds} s from before the fault"
        )
        return metres

    def end(self, name: str) -> Observed:
        """Has supervisord end it as an update does (SIGTERM), and waits: how long it took. Fails the attempt where it
        had to be killed, or ended with another status than 0."""
        began_s = time.monotonic()
        self.supervise("stopProcess", name)
        seconds = round(time.monotonic() - began_s, 1)
        status = self.stack._ask("getProcessInfo", name)["exitstatus"]
        assert status == 0, f"{name} ended with {status} after {seconds} s"
        return {"ended_after_s": seconds}

    def start(self, name: str) -> Observed:
        """Returns when it is ready."""
        began_s = time.monotonic()
        self.supervise("startProcess", name)
        self.mesh.until(lambda: not self.lacks(name), timeout_s=LONG_S * 2, what=f"{name} ready again")
        return {"ready_after_s": round(time.monotonic() - began_s, 1)}

    def lacks(self, name: str) -> str:
        """What a service is not ready for, in words; empty when it is ready."""
        return missing(self.mesh.http, self.stack.ports, name) or ""

    def before_the_dock(self) -> None:
        """Where the robot began: far enough from what a mission has found before."""
        told = self.mesh.get("truth", "/home")["dock"]
        dock = Pose2D(x=told["x_m"], y=told["y_m"], yaw=told["yaw"])
        start = compose(dock, Pose2D(x=-UNDOCKED_M, y=0.0, yaw=math.pi))
        epoch = self.mesh.get("robot_bridge", "/emergency-stop")["epoch"]
        body = {"candidates": [{"pose": start.model_dump()}], "epoch": epoch, "timeout_s": 300.0}
        goal = self.mesh.post("robot_bridge", "/navigation/goals", body).raise_for_status().json()
        self.mesh.until(
            lambda: self.goal_status(goal["id"]) == "SUCCEEDED", timeout_s=MISSION_S, what="a drive to the dock"
        )
        self.mesh.until(self.mesh.still, timeout_s=LONG_S, what="a robot at rest")

    def end_of(self, mission_id: str) -> Observed:
        """How a mission ended, once it has and the robot is idle. Fails the attempt where it never does, says nothing
        of why, or says *found* where ground truth does not."""

        def told() -> Mission:
            return Mission.model_validate(self.mesh.get("coordinator", f"/missions/{mission_id}"))

        self.mesh.until(lambda: told().outcome is not None, timeout_s=MISSION_S, what="an end of the mission")
        ended, score = told(), {"kind": "bottle", "colour": "red"}
        assert ended.outcome is not None
        assert ended.reason, "it ended without a reason"
        near = self.mesh.http.get(self.mesh.url("truth", "/score"), params=score).raise_for_status().json()["correct"]
        assert near or ended.outcome is not Outcome.FOUND, "it says that it found what is not there"
        self.mesh.until(
            lambda: self.mesh.get("coordinator", "/state")["state"] == "IDLE", timeout_s=LONG_S, what="an idle robot"
        )
        return {"mission": ended.outcome.value}

    def goal_far_away(self) -> str:
        """A goal under way: its id, once the robot drives."""
        state = self.mesh.get("robot_bridge", "/state")
        epoch, here = state["emergency_stop"]["epoch"], state["pose"]
        for _ in range(200):
            x, y = (here[axis] + self._chance.uniform(-4.0, 4.0) for axis in ("x", "y"))
            pose = {"x": x, "y": y, "yaw": 0.0}
            path = self.mesh.post("robot_bridge", "/navigation/path", {"goal": pose})
            if path.status_code == 200 and path.json()["reachable"] and 2.0 < path.json()["length_m"] < 7.0:
                break
        else:
            raise AssertionError("no goal was found to drive to")
        body = {"candidates": [{"pose": pose}], "epoch": epoch, "timeout_s": 300.0}
        goal = self.mesh.post("robot_bridge", "/navigation/goals", body).raise_for_status().json()
        self.mesh.until(self.translating, timeout_s=LONG_S, what="a robot on its way")
        return str(goal["id"])

    def goal_status(self, goal_id: str) -> str:
        return str(self.mesh.get("robot_bridge", f"/navigation/goals/{goal_id}")["status"])

    def missing(self) -> list[str]:
        """What the bridge says it is not ready for."""
        answer = Readiness.model_validate_json(self.mesh.http.get(f"{self.url}/ready").content)
        return [each.name for each in answer.dependencies if not each.ok]

    def metric(self, name: str) -> float:
        """The sum over its labels."""
        lines = self.mesh.http.get(f"{self.url}/metrics").text.splitlines()
        return sum(float(line.split()[-1]) for line in lines if line.startswith(name))

    def stop(self) -> float:
        """The emergency stop, ms until its answer."""
        began_s = time.monotonic()
        answer = self.mesh.post("robot_bridge", "/emergency-stop").raise_for_status().json()
        assert answer["state"]["latched"]
        return round((time.monotonic() - began_s) * 1000.0, 1)

    def reset(self) -> None:
        self.mesh.post("robot_bridge", "/emergency-stop/reset").raise_for_status()
