"""From `curl -X POST .../emergency-stop` to the first zero Twist that a ROS process of its own hears.

Idle: scan and odometry only. Loaded: beside them a 30 Hz camera of noise, 4 MJPEG viewers, 100 state requests a second
and a stream of velocities. The time counts from before curl is started to the callback of the listener; both read
CLOCK_MONOTONIC. Before each stop the robot is driving, so that a zero can only come from the stop.
"""

import argparse
import contextlib
import itertools
import json
import os
import random
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import numpy as np

from demo.stack import redis_server

START_S_MAX = 90.0
HEAR_S_MAX = 10.0
ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Heard:
    at_ns: int
    linear_x: float
    angular_z: float

    @property
    def zero(self) -> bool:
        return (self.linear_x, self.angular_z) == (0.0, 0.0)


class Listener:
    """What the listening process has heard, newest last."""

    def __init__(self, process: "subprocess.Popen[str]") -> None:
        self.process = process
        self.heard: deque[Heard] = deque(maxlen=100_000)
        self._some = threading.Condition()
        self._reading = threading.Thread(target=self._read, daemon=True)
        self._reading.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            at_ns, linear_x, angular_z = line.split()
            with self._some:
                self.heard.append(Heard(int(at_ns), float(linear_x), float(angular_z)))
                self._some.notify_all()

    def first(self, wanted: Callable[[Heard], bool], *, since_ns: int, timeout_s: float) -> Heard:
        """The first message after `since_ns` that is `wanted`. Raises TimeoutError."""
        deadline = time.monotonic() + timeout_s
        with self._some:
            while True:
                for each in self.heard:
                    if each.at_ns >= since_ns and wanted(each):
                        return each
                if (left_s := deadline - time.monotonic()) <= 0.0:
                    raise TimeoutError("the listener did not hear it")
                self._some.wait(left_s)

    def forget(self) -> None:
        with self._some:
            self.heard.clear()


class Rig:
    """The processes under measurement: redis, the bridge, a robot and the listener."""

    def __init__(self, folder: Path, port: int, domain: int, camera_hz: float) -> None:
        self.port = port
        self.base_url = f"http://127.0.0.1:{port}"
        self._camera_hz = camera_hz
        self._processes: list[subprocess.Popen[Any]] = []
        self.environment = os.environ | {
            "ROS_DOMAIN_ID": str(domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(folder / "ros"),
            "ROBOT_BRIDGE_PORT": str(port),
            "ROBOT_BRIDGE_REDIS_URL": f"redis://127.0.0.1:{port + 1}/0",
            "ROBOT_BRIDGE_STATE_DIR": str(folder / "state"),
            "ROBOT_BRIDGE_LOG_LEVEL": "ERROR",
            "PYTHONUNBUFFERED": "1",
            "OMP_NUM_THREADS": "1",
        }

    def start(self, *command: str, **options: Any) -> "subprocess.Popen[Any]":
        process = subprocess.Popen(command, env=self.environment, cwd=ROOT, **options)
        self._processes.append(process)
        return process

    def __enter__(self) -> "Rig":
        plain = {key: value for key, value in self.environment.items() if key != "LD_LIBRARY_PATH"}
        redis = [redis_server(), "--port", str(self.port + 1), "--bind", "127.0.0.1", "--save", ""]
        self._processes.append(subprocess.Popen(redis, env=plain, stdout=subprocess.DEVNULL))
        self.bridge = self.start(sys.executable, "-m", "robot_bridge")
        self.start(sys.executable, "-m", "bench.stopping.robot", "--camera-hz", str(self._camera_hz))
        hearing = self.start(sys.executable, "-m", "bench.stopping.listener", stdout=subprocess.PIPE, text=True)
        self.listener = Listener(hearing)
        self.http = httpx.Client(base_url=self.base_url, timeout=30.0, trust_env=False)
        self._until(self._sensing, "a bridge with scan and odometry")
        self.listener.first(lambda _: True, since_ns=0, timeout_s=START_S_MAX)
        return self

    def __exit__(self, *_: object) -> None:
        self.http.close()
        for process in reversed(self._processes):
            process.terminate()
        for process in self._processes:
            try:
                process.wait(20.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def _sensing(self) -> bool:
        with contextlib.suppress(httpx.TransportError):
            sensors = self.http.get("/state").json()["sensors"]
            return bool(sensors["scan"]["valid"] and sensors["odom"]["valid"])
        return False

    def _until(self, condition: Callable[[], bool], what: str) -> None:
        deadline = time.monotonic() + START_S_MAX
        while not condition():
            if time.monotonic() > deadline:
                raise TimeoutError(f"no {what} within {START_S_MAX:.0f} s")
            time.sleep(0.05)

    def bridge_cpu_s(self) -> float:
        """Seconds of CPU time the bridge has used so far."""
        fields = Path(f"/proc/{self.bridge.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def drive(self) -> None:
        """Returns when the listener hears that the robot is told to move."""
        epoch = self.http.post("/emergency-stop/reset").json()["state"]["epoch"]
        since_ns = time.monotonic_ns()
        lease = {"twist": {"linear_x": 0.2}, "source": "bench", "epoch": epoch, "duration_s": 2.0, "priority": 3}
        self.http.post("/velocity", json=lease).raise_for_status()
        self.listener.first(lambda heard: not heard.zero, since_ns=since_ns, timeout_s=HEAR_S_MAX)

    def stop_by_curl(self) -> tuple[float, float]:
        """ms from before curl is started to the first zero heard, and to curl's end."""
        command = ["curl", "-s", "-o", "/dev/null", "-X", "POST", f"{self.base_url}/emergency-stop"]
        began_ns = time.monotonic_ns()
        done = subprocess.run(command, check=True, env=self._curl_environment, close_fds=False)
        ended_ns = time.monotonic_ns()
        assert done.returncode == 0
        zero = self.listener.first(lambda heard: heard.zero, since_ns=began_ns, timeout_s=HEAR_S_MAX)
        return (zero.at_ns - began_ns) / 1e6, (ended_ns - began_ns) / 1e6

    def floor_by_curl(self) -> float:
        """ms from before curl is started to its request's arrival in a process that does nothing but wait for it."""
        with socket.create_server(("127.0.0.1", 0)) as server:
            url = f"http://127.0.0.1:{server.getsockname()[1]}/"
            began_ns = time.monotonic_ns()
            curl = subprocess.Popen(["curl", "-s", "-X", "POST", url], env=self._curl_environment, close_fds=False)
            connection, _ = server.accept()
            with connection:
                connection.recv(1000)
                arrived_ns = time.monotonic_ns()
                connection.sendall(b"HTTP/1.1 204 No Content\r\nConnection: close\r\n\r\n")
            curl.wait(20.0)
        return (arrived_ns - began_ns) / 1e6

    @property
    def _curl_environment(self) -> dict[str, str]:
        return {"PATH": os.environ.get("PATH", "/usr/bin:/bin")}


def measure(rig: Rig, stops: int, chance: random.Random) -> tuple[list[float], list[float], list[float]]:
    """Times of zeros, answers and of curl alone, ms, of `stops` stops at random moments of the 20 Hz beat."""
    zeros, answers, floors = list[float](), list[float](), list[float]()
    for _ in range(stops):
        rig.drive()
        time.sleep(chance.uniform(0.0, 0.06))
        rig.listener.forget()
        zero_ms, answer_ms = rig.stop_by_curl()
        zeros.append(zero_ms)
        answers.append(answer_ms)
        time.sleep(0.05)  # what a stop leaves to be done is done
        floors.append(rig.floor_by_curl())
    return zeros, answers, floors


def measure_requests(rig: Rig, stops: int, chance: random.Random) -> list[float]:
    """ms from a request on a connection that stands already, to the zero: no process is started, none connects."""
    zeros = list[float]()
    for _ in range(stops):
        rig.drive()
        time.sleep(chance.uniform(0.0, 0.06))
        rig.listener.forget()
        began_ns = time.monotonic_ns()
        rig.http.post("/emergency-stop").raise_for_status()
        zero = rig.listener.first(lambda heard: heard.zero, since_ns=began_ns, timeout_s=HEAR_S_MAX)
        zeros.append((zero.at_ns - began_ns) / 1e6)
    return zeros


def periods(rig: Rig, seconds: float) -> list[float]:
    """ms between the velocities heard while the robot drives (no stop, so nothing but the 20 Hz beat)."""
    rig.drive()
    rig.http.post("/emergency-stop/reset")
    rig.listener.forget()
    time.sleep(seconds)
    at_ms = [heard.at_ns / 1e6 for heard in tuple(rig.listener.heard)]
    return [later - earlier for earlier, later in itertools.pairwise(at_ms)]


def quantiles(values_ms: Sequence[float]) -> dict[str, float]:
    found = np.percentile(values_ms, [50, 99, 100])
    return dict(zip(("p50_ms", "p99_ms", "max_ms"), (round(float(value), 2) for value in found), strict=True))


@contextlib.contextmanager
def loading(rig: Rig, *, on: bool) -> Iterator[dict[str, Any]]:
    """Runs the load; what it did stands in the yielded dictionary afterwards."""
    told: dict[str, Any] = {}
    if not on:
        yield told
        return
    command = (sys.executable, "-m", "bench.stopping.load", "--port", str(rig.port))
    process = rig.start(*command, stdout=subprocess.PIPE, text=True)
    time.sleep(2.0)
    try:
        yield told
    finally:
        process.terminate()
        output, _ = process.communicate(timeout=20.0)
        told |= json.loads(output)


def plot(results: dict[str, list[float]], beat: dict[str, list[float]], path: Path) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
    for name, values in results.items():
        ordered = np.sort(values)
        left.plot(ordered, np.arange(1, ordered.size + 1) / ordered.size, label=f"{name} ({ordered.size} stops)")
    left.axhline(0.99, color="grey", linewidth=0.5)
    left.set(xlabel="curl to the first zero Twist heard, ms", ylabel="part of the stops", xscale="log")
    left.legend()
    for name, values in beat.items():
        right.hist(values, bins=np.linspace(30, 70, 81), histtype="step", label=name)
    right.set(xlabel="between two velocities heard, ms", ylabel="times", yscale="log")
    right.legend()
    figure.savefig(path, dpi=110)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stops", type=int, default=500, help="in each of idle and loaded")
    parser.add_argument("--beat-s", type=float, default=30.0, help="how long the 20 Hz beat is watched, each")
    parser.add_argument("--port", type=int, default=18704)
    parser.add_argument("--domain", type=int, default=87, help="ROS_DOMAIN_ID")
    parser.add_argument("--out", type=Path, default=Path("out/bench"))
    parser.add_argument("--quick", action="store_true", help="20 stops each: does it run?")
    arguments = parser.parse_args()
    if shutil.which("curl") is None:
        parser.error("curl is needed: apt-get install -y curl")
    stops, beat_s = (20, 3.0) if arguments.quick else (arguments.stops, arguments.beat_s)
    chance = random.Random(1)
    zeros: dict[str, list[float]] = {}
    answers: dict[str, list[float]] = {}
    floors: dict[str, list[float]] = {}
    requests: dict[str, list[float]] = {}
    cores: dict[str, float] = {}
    beat: dict[str, list[float]] = {}
    for name, camera_hz in (("idle", 0.0), ("loaded", 30.0)):
        with (
            tempfile.TemporaryDirectory() as folder,
            Rig(Path(folder), arguments.port, arguments.domain, camera_hz) as rig,
            loading(rig, on=camera_hz > 0.0) as load,
        ):
            measure(rig, 3, chance)  # warm
            began_s, spent_s = time.monotonic(), rig.bridge_cpu_s()
            beat[name] = periods(rig, beat_s)
            cores[name] = round((rig.bridge_cpu_s() - spent_s) / (time.monotonic() - began_s), 2)
            requests[name] = measure_requests(rig, stops, chance)
            zeros[name], answers[name], floors[name] = measure(rig, stops, chance)
    report = {name: quantiles(values) for name, values in zeros.items()}
    report |= {f"{name}_answer": quantiles(values) for name, values in answers.items()}
    report |= {f"{name}_request": quantiles(values) for name, values in requests.items()}
    report |= {f"{name}_curl_alone": quantiles(values) for name, values in floors.items()}
    report |= {"arbiter_period": quantiles(beat["loaded"]), "arbiter_period_idle": quantiles(beat["idle"])}
    context = {
        "stops": stops,
        "cpus": os.cpu_count(),
        "load_average": os.getloadavg(),
        "bridge_cores": cores,
        "load": load,
    }
    arguments.out.mkdir(parents=True, exist_ok=True)
    (arguments.out / "stop.json").write_text(json.dumps(report | {"context": context}, indent=2) + "\n")
    curves = zeros | {f"kept connection, {name}": values for name, values in requests.items()}
    curves |= {f"curl alone, {name}": values for name, values in floors.items()}
    plot(curves, beat, arguments.out / "stop.png")
    for name, values in report.items():
        told = "  ".join(f"{key.removesuffix('_ms')} {value:7.2f} ms" for key, value in values.items())
        sys.stdout.write(f"{name:<20} {told}\n")
    sys.stdout.write(f"{json.dumps(context)}\n{arguments.out / 'stop.json'}  {arguments.out / 'stop.png'}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
