"""Kills, pauses and cuts off each container of the running mesh, and tells what the robot did. See docs/faults.md.

    UI_SPEECH_URL=http://speech:8005 docker compose --profile sim --profile speech up -d --wait
    .venv/bin/python -m bench.compose_faults [NAME ...]

Containers are killed as a crash would kill them: their process, by its number, as root. Motion is the simulator's
truth, and so is the time to rest (simulated seconds); other times are the wall's. A round that was cut off goes on
where it was: what has succeeded is not done again. Each fault begins where the robot starts, before its dock.
"""

import argparse
import json
import math
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import httpx

from bench.results import save
from contracts.geometry import Pose2D
from geometry.poses import compose

PORTS: Final = {"coordinator": 8001, "inference": 8002, "memory": 8003, "robot_bridge": 8004, "ui": 8080, "sim": 8006}
SPEECH_PORT: Final = 8005
HEALTH: Final = "{{.State.Health.Status}}"
SAID: Final = "find the red bottle"
CIRCLE: Final = {"linear_x": 0.1, "angular_z": 0.5}
LONG_S: Final = 150.0
UNDOCKED_M: Final = 0.5
HOLDER: Final = "bench"
TARGET: Final = {"kind": "bottle", "colour": "red"}
Seen = dict[str, Any]


class Mesh:
    """The containers as Docker has them, and the services behind their published ports."""

    def __init__(self) -> None:
        self.http = httpx.Client(timeout=10.0)

    def __enter__(self) -> "Mesh":
        """With an operator's key, made as a person makes theirs."""
        self.keys("revoke", HOLDER)
        told = self.keys("make", HOLDER, "--role", "operator")
        (key,) = re.findall(r"shown this once: (\S+)", told)
        self.http.headers["Authorization"] = f"Bearer {key}"
        return self

    def __exit__(self, *_: object) -> None:
        self.keys("revoke", HOLDER)
        self.http.close()

    def keys(self, *arguments: str) -> str:
        command = ["docker", "compose", "run", "--rm", "-T", "keys", *arguments]
        return subprocess.run(command, check=False, capture_output=True, text=True).stdout

    def docker(self, *arguments: str) -> str:
        return subprocess.run(["docker", *arguments], check=True, capture_output=True, text=True).stdout.strip()

    def container(self, name: str) -> str:
        return self.docker("compose", "--profile", "sim", "--profile", "speech", "ps", "-aq", name)

    def pid(self, name: str) -> int:
        return int(self.docker("inspect", "-f", "{{.State.Pid}}", self.container(name)))

    def kill(self, pid: int) -> float:
        """SIGKILL from outside, so that Docker takes it for a crash: `docker kill` would be taken for a wish.

        Returns the simulated moment at which it was sent.
        """
        killed_s = self.truth()["now_s"]
        os.kill(pid, signal.SIGKILL)
        return killed_s

    def ready(self, name: str) -> bool:
        with suppress(httpx.HTTPError):
            return self.get(name, "/ready").status_code == 200
        return False

    def all_ready(self) -> bool:
        return all(self.ready(name) for name in PORTS)

    def get(self, name: str, path: str, **query: str) -> httpx.Response:
        return self.http.get(f"http://127.0.0.1:{PORTS[name]}{path}", params=query)

    def post(self, name: str, path: str, **body: Any) -> httpx.Response:
        return self.http.post(f"http://127.0.0.1:{PORTS[name]}{path}", json=body)

    def spoken_and_heard(self) -> str:
        """What speech reads of what the page had it say, both through the published ports. Raises `HTTPError`."""
        spoken = self.post("ui", "/speech/speak", text=SAID).raise_for_status()
        heard = self.http.post(
            f"http://127.0.0.1:{SPEECH_PORT}/transcribe",
            content=spoken.content,
            params={"hot_words": ["red bottle"]},
            headers={"content-type": "audio/wav"},
            timeout=60.0,
        )
        return str(heard.raise_for_status().json()["hot_text"])

    def truth(self) -> Seen:
        return self.get("sim", "/truth").raise_for_status().json()

    def moves(self) -> bool:
        return abs(self.truth()["twist"]["linear_x"]) > 0.03 or abs(self.truth()["twist"]["angular_z"]) > 0.05

    def seconds_to_rest(self, since_s: float) -> float:
        """Simulated, from `since_s` to the last motion before a second without any. Raises `TimeoutError`."""

        def rested() -> bool:
            truth = self.truth()
            return truth["time_s"] > max(since_s, truth["moved_at_s"]) + 1.0

        self.seconds_until(rested, "rest")
        return round(max(0.0, self.truth()["moved_at_s"] - since_s), 2)

    def seconds_until(self, condition: Callable[[], bool], what: str) -> float:
        """Raises `TimeoutError` when it never holds."""
        began_s = time.monotonic()
        while not condition():
            if time.monotonic() > began_s + LONG_S:
                raise TimeoutError(f"never: {what}")
            time.sleep(0.1)
        return round(time.monotonic() - began_s, 1)

    def metres_in(self, seconds: float) -> float:
        before = self.truth()
        self.seconds_until(lambda: self.truth()["time_s"] >= before["time_s"] + seconds, "time passing")
        return round(self.truth()["path_length_m"] - before["path_length_m"], 2)

    def stop(self) -> float:
        """Milliseconds to the answer; latched afterwards."""
        began_s = time.monotonic()
        self.post("robot_bridge", "/emergency-stop").raise_for_status()
        return round(1000.0 * (time.monotonic() - began_s), 1)

    def at_rest(self) -> None:
        """Where every fault begins: all ready, nothing latched, no mission, the robot standing before its dock."""
        self.seconds_until(self.all_ready, "all ready")
        self.post("robot_bridge", "/emergency-stop/reset").raise_for_status()
        if (state := self.state())["mission"] is not None:
            self.post("coordinator", f"/missions/{state['mission']['id']}/cancel")
        self.seconds_until(lambda: self.state()["state"] == "IDLE", "an idle coordinator")
        self.drive_to_the_dock()
        self.seconds_to_rest(self.truth()["now_s"])

    def drive_to_the_dock(self) -> None:
        told = self.get("sim", "/home").raise_for_status().json()["dock"]
        dock = Pose2D(x=told["x_m"], y=told["y_m"], yaw=told["yaw"])
        start = compose(dock, Pose2D(x=-UNDOCKED_M, y=0.0, yaw=math.pi))
        goal = self.post(
            "robot_bridge", "/navigation/goals", candidates=[{"pose": start.model_dump()}], epoch=self.epoch()
        ).raise_for_status()
        path = f"/navigation/goals/{goal.json()['id']}"
        self.seconds_until(
            lambda: self.get("robot_bridge", path).json()["status"] == "SUCCEEDED", "a drive to the dock"
        )

    def epoch(self) -> int:
        return self.get("robot_bridge", "/emergency-stop").raise_for_status().json()["epoch"]

    def state(self) -> Seen:
        return self.get("coordinator", "/state").raise_for_status().json()

    @contextmanager
    def circling(self) -> Generator[None]:
        """On a lease that is renewed over HTTP, as a person at the stick would."""
        over = threading.Event()
        epoch = self.epoch()

        def renew() -> None:
            while not over.wait(0.2):
                with suppress(httpx.HTTPError):
                    self.post("robot_bridge", "/velocity", twist=CIRCLE, source="bench", epoch=epoch, duration_s=0.5)

        thread = threading.Thread(target=renew)
        thread.start()
        try:
            self.seconds_until(self.moves, "a moving robot")
            yield
        finally:
            over.set()
            thread.join()

    @contextmanager
    def on_a_mission(self) -> Generator[str]:
        """Yields its id once the robot drives."""
        mission = self.post("coordinator", "/missions", command="find the red bottle").raise_for_status().json()
        self.seconds_until(lambda: self.truth()["twist"]["linear_x"] > 0.1, "a mission that drives")
        yield mission["id"]


@dataclass(frozen=True)
class Fault:
    """What is done, and what the robot is designed to do then."""

    name: str
    designed: str
    happen: Callable[[Mesh], Seen]


def nothing(mesh: Mesh) -> Seen:
    with mesh.on_a_mission() as mission:
        return end(mesh, mission)


def redis_killed(mesh: Mesh) -> Seen:
    with mesh.circling():
        mesh.kill(mesh.pid("redis"))
        return {"drove_m": mesh.metres_in(2.0), "stop_ms": mesh.stop(), **back(mesh)}


def redis_paused(mesh: Mesh) -> Seen:
    redis = mesh.container("redis")
    with mesh.circling():
        mesh.docker("pause", redis)
        try:
            missed_s = mesh.seconds_until(lambda: not mesh.ready("coordinator"), "redis missed")
            drove_m = mesh.metres_in(3.0)
            stop_ms = mesh.stop()
        finally:
            mesh.docker("unpause", redis)
    return {"drove_m": drove_m, "missed_after_s": missed_s, "stop_ms": stop_ms, **back(mesh)}


def bridge_killed(mesh: Mesh) -> Seen:
    bridge = mesh.pid("robot_bridge")
    with mesh.circling():
        killed_s = mesh.kill(bridge)
    rest_s = mesh.seconds_to_rest(killed_s)
    return {"rest_s": rest_s, **back(mesh), "moves_by_itself": mesh.moves()}


def sim_killed(mesh: Mesh) -> Seen:
    mesh.kill(mesh.pid("sim"))
    missed_s = mesh.seconds_until(lambda: not mesh.ready("robot_bridge"), "the robot missed")
    return {"missed_after_s": missed_s, **back(mesh)}


def killed_in_a_mission(name: str) -> Callable[[Mesh], Seen]:
    def happen(mesh: Mesh) -> Seen:
        with mesh.on_a_mission() as mission:
            mesh.kill(mesh.pid(name))
            return {"back_s": mesh.seconds_until(lambda: mesh.ready(name), name), **end(mesh, mission), **back(mesh)}

    return happen


def speech_killed(mesh: Mesh) -> Seen:
    """Docker starts it again; nobody but the page asks it for anything."""
    if not (speech := mesh.container("speech")):
        return {"skipped": "started without --profile speech"}
    heard = mesh.spoken_and_heard()
    with mesh.on_a_mission() as mission:
        mesh.kill(mesh.pid("speech"))
        others_ready = mesh.all_ready()
        ended = end(mesh, mission)
        back_s = mesh.seconds_until(lambda: mesh.docker("inspect", "-f", HEALTH, speech) == "healthy", "speech back")
    return {
        "heard": heard,
        "others_ready": others_ready,
        **ended,
        "back_s": back_s,
        "heard_again": mesh.spoken_and_heard(),
    }


def coordinator_killed(mesh: Mesh) -> Seen:
    coordinator = mesh.pid("coordinator")
    with mesh.on_a_mission() as mission:
        rest_s = mesh.seconds_to_rest(mesh.kill(coordinator))
    return {"rest_s": rest_s, **back(mesh), **end(mesh, mission), "moves_by_itself": mesh.moves()}


def coordinator_cut_off(mesh: Mesh) -> Seen:
    container = mesh.container("coordinator")
    (network,) = json.loads(mesh.docker("inspect", "-f", "{{json .NetworkSettings.Networks}}", container))
    with mesh.on_a_mission() as mission:
        cut_s = mesh.truth()["now_s"]
        mesh.docker("network", "disconnect", network, container)
        try:
            rest_s = mesh.seconds_to_rest(cut_s)
        finally:
            mesh.docker("network", "connect", "--alias", "coordinator", network, container)
    return {"rest_s": rest_s, **back(mesh), **end(mesh, mission)}


def any_order(mesh: Mesh) -> Seen:
    """All of them ended, then started alone, one after the other: those first that need the most of the others."""
    containers = [mesh.container(name) for name in ("ui", "coordinator", "memory", "inference", "robot_bridge", "sim")]
    containers.append(mesh.container("redis"))
    mesh.docker("stop", *containers)
    for one in containers:
        mesh.docker("start", one)
    return back(mesh)


def back(mesh: Mesh) -> Seen:
    return {"all_ready_s": mesh.seconds_until(mesh.all_ready, "all ready again")}


def end(mesh: Mesh, mission: str) -> Seen:
    """How the mission ended, as ground truth has it too; it may take as long as a mission takes."""
    began_s = time.monotonic()
    for _ in range(2):
        with suppress(TimeoutError):
            mesh.seconds_until(lambda: outcome(mesh, mission) is not None, "an end of the mission")
            break
    correct = bool(mesh.get("sim", "/score", **TARGET).raise_for_status().json()["correct"])
    return {
        "mission": outcome(mesh, mission),
        "correct": correct,
        "ended_after_s": round(time.monotonic() - began_s, 1),
    }


def outcome(mesh: Mesh, mission: str) -> str | None:
    with suppress(httpx.HTTPError):
        return mesh.get("coordinator", f"/missions/{mission}").raise_for_status().json()["outcome"]
    return None


FAULTS: Final = (
    Fault("nothing", "a mission through the published ports finds the red bottle", nothing),
    Fault("redis_killed", "drives on, the stop stops, all ready again by itself", redis_killed),
    Fault("redis_paused", "drives on, /ready misses it, the stop stops, all ready again by itself", redis_paused),
    Fault("bridge_killed", "the base stops by itself, nothing resumes", bridge_killed),
    Fault(
        "coordinator_killed",
        "its session ends: at rest; the mission ends interrupted, nothing resumes",
        coordinator_killed,
    ),
    Fault("coordinator_cut_off", "its session falls silent for 1 s: at rest", coordinator_cut_off),
    Fault("inference_killed", "the mission waits for it and goes on", killed_in_a_mission("inference")),
    Fault("memory_killed", "the mission goes on", killed_in_a_mission("memory")),
    Fault("ui_killed", "the mission goes on", killed_in_a_mission("ui")),
    Fault("speech_killed", "the others stay ready, the mission goes on, it hears again", speech_killed),
    Fault("sim_killed", "the bridge misses its robot, and is ready when it is back", sim_killed),
    Fault("any_order", "started one by one in the wrong order, all get ready", any_order),
)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="FAULT", help=f"all of {', '.join(one.name for one in FAULTS)}")
    parser.add_argument("--again", action="store_true", help="forget the round before")
    parser.add_argument("--out", type=Path, default=Path("out/bench/compose_faults.json"))
    arguments = parser.parse_args()
    kept = arguments.out.exists() and not arguments.again
    results: dict[str, Seen] = json.loads(arguments.out.read_text(encoding="utf-8")) if kept else {}
    with Mesh() as mesh:
        for fault in FAULTS:
            done = fault.name in results and "failed" not in results[fault.name]
            if fault.name in arguments.names or not (arguments.names or done):
                results[fault.name] = {"designed": fault.designed, **attempt(mesh, fault)}
                sys.stdout.write(f"{fault.name:20} {json.dumps(results[fault.name])}\n")
                sys.stdout.flush()
                save(arguments.out, results)
    return int(any("failed" in one for one in results.values()))


def attempt(mesh: Mesh, fault: Fault) -> Seen:
    try:
        mesh.at_rest()
        return fault.happen(mesh)
    except (TimeoutError, httpx.HTTPError, KeyError, ValueError, subprocess.CalledProcessError) as error:
        return {"failed": f"{type(error).__name__}: {error}"[:300]}


if __name__ == "__main__":
    sys.exit(main())
