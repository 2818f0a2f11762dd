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
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench.processes import cpu_s
from bench.results import pyplot, save
from bench.stopping.rig import HEAR_S_MAX, KEY, Rig, rigged
from bench.voice_stop.stops import speech_service


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
def loading(rig: Rig, *, on: bool, secured: bool) -> Iterator[dict[str, Any]]:
    """Runs the load; what it did stands in the yielded dictionary afterwards."""
    told: dict[str, Any] = {}
    if not on:
        yield told
        return
    command = ("-m", "bench.stopping.load", "--port", str(rig.port), *(("--key", KEY) if secured else ()))
    process = rig.processes.python(*command, stdout=subprocess.PIPE, text=True)
    time.sleep(2.0)
    try:
        yield told
    finally:
        process.terminate()
        output, _ = process.communicate(timeout=20.0)
        told |= json.loads(output)


@contextlib.contextmanager
def speaking(rig: Rig, port: int, *, on: bool) -> Iterator[None]:
    """With a speech service that listens to somebody who talks without end."""
    if not on:
        yield
        return
    with speech_service(port):
        rig.processes.python("-m", "bench.stopping.talk", "--port", str(port))
        time.sleep(5.0)  # it has begun to read
        yield


def plot(results: dict[str, list[float]], beat: dict[str, list[float]], path: Path) -> None:
    plt = pyplot()
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
    parser.add_argument("--secured", action="store_true", help="with keys and traces on")
    parser.add_argument("--speech", action="store_true", help="beside a speech service that listens to somebody")
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
            rigged(Path(folder), arguments.port, arguments.domain, camera_hz, secured=arguments.secured) as rig,
            loading(rig, on=camera_hz > 0.0, secured=arguments.secured) as load,
            speaking(rig, arguments.port + 3, on=arguments.speech),
        ):
            measure(rig, 3, chance)  # warm
            began_s, spent_s = time.monotonic(), cpu_s(rig.bridge)
            beat[name] = periods(rig, beat_s)
            cores[name] = round((cpu_s(rig.bridge) - spent_s) / (time.monotonic() - began_s), 2)
            requests[name] = measure_requests(rig, stops, chance)
            zeros[name], answers[name], floors[name] = measure(rig, stops, chance)
    report = {name: quantiles(values) for name, values in zeros.items()}
    report |= {f"{name}_answer": quantiles(values) for name, values in answers.items()}
    report |= {f"{name}_request": quantiles(values) for name, values in requests.items()}
    report |= {f"{name}_curl_alone": quantiles(values) for name, values in floors.items()}
    report |= {"arbiter_period": quantiles(beat["loaded"]), "arbiter_period_idle": quantiles(beat["idle"])}
    context = {
        "stops": stops,
        "secured": arguments.secured,
        "speech": arguments.speech,
        "cpus": os.cpu_count(),
        "load_average": os.getloadavg(),
        "bridge_cores": cores,
        "load": load,
    }
    name = "stop" + "-secured" * arguments.secured + "-speech" * arguments.speech
    save(arguments.out / f"{name}.json", report | {"context": context})
    curves = zeros | {f"kept connection, {name}": values for name, values in requests.items()}
    curves |= {f"curl alone, {name}": values for name, values in floors.items()}
    plot(curves, beat, arguments.out / f"{name}.png")
    for quantity, values in report.items():
        told = "  ".join(f"{key.removesuffix('_ms')} {value:7.2f} ms" for key, value in values.items())
        sys.stdout.write(f"{quantity:<20} {told}\n")
    sys.stdout.write(f"{json.dumps(context)}\n{arguments.out / name}.json, .png\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
