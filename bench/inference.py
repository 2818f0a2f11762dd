"""What the inference service costs beside its models: overhead, latency, throughput, memory, backends side by side.

    python -m bench.inference [--pictures FOLDER] [--frames 7200] [--quick]

Starts the real service (`python -m inference`) with a Redis and a stand-in of the robot's camera at 30 Hz, each a
process of its own. Run it on an otherwise idle machine. Without `--pictures` it renders forty of homes that no training
saw. Writes out/bench/inference.json, backends.png and memory.png.
"""

import argparse
import asyncio
import http.client
import json
import statistics
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx
import numpy as np

from bench.results import save
from bench.seeing.plots import save_bars, save_memory
from bench.seeing.running import Running, running_service
from bench.seeing.statistics import percentiles
from bench.votes import HELD_OUT_SEED
from contracts.mission import MissionTarget
from contracts.topics import MISSION_TARGET, VISION_DETECTIONS
from contracts.vision import Detections, Target
from inference.adapters.exports import FILES, Exports
from inference.adapters.loading import detector_exports, load_clip, load_detector
from inference.adapters.yolo import YoloDetector
from inference.perception.images import decode
from inference.perception.models import Loaded, Models
from inference.perception.worker import Worker
from inference.settings import Backend, Settings
from mesh.bus import open_bus
from sim.training.dataset import render_homes

OUT = Path("out/bench")
PICTURES, HOMES = 40, 5
CALLERS = (1, 4, 16)
CAMERA_HZ = 30.0
RETRY_S = 0.02
TARGET = Target(label="bottle", description="red bottle")


@dataclass(frozen=True)
class Plan:
    """How long each part goes on."""

    calls: int
    throughput_s: float
    perception_s: float
    frames: int


def rendered() -> Path:
    """A folder of pictures of homes that no training saw; those that are there already are kept."""
    folder = OUT / "homes/inference"
    render_homes(folder, range(HELD_OUT_SEED, HELD_OUT_SEED + HOMES), PICTURES // HOMES, 2)
    return folder / "images"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pictures", type=Path, help="folder of JPEG files")
    parser.add_argument("--frames", type=int, default=7200, help="an hour's worth at 2 Hz (default 7200)")
    parser.add_argument("--quick", action="store_true", help="a smoke run of half a minute; its numbers mean little")
    arguments = parser.parse_args()
    pictures = sorted((arguments.pictures or rendered()).glob("*.jpg"))[:PICTURES]
    if not pictures:
        raise SystemExit(f"no JPEG files in {arguments.pictures}")
    plan = Plan(20, 1.0, 3.0, 300) if arguments.quick else Plan(300, 6.0, 30.0, arguments.frames)
    report: dict[str, Any] = {"command": " ".join(["python -m bench.inference", *sys.argv[1:]])}
    settings = Settings()
    report |= time_backends(settings, pictures, plan)
    with running_service([], camera_hz=CAMERA_HZ, settings={}) as service:
        report["service"] = httpx.get(f"http://127.0.0.1:{service.port}/models", trust_env=False).json()
        report |= time_overhead(service, settings, pictures, plan)
        report |= time_throughput(service, pictures, plan)
    with running_service(pictures, camera_hz=CAMERA_HZ, settings={}) as service:
        report |= asyncio.run(time_perception(service, plan))
    as_fast_as_it_can = {"INFERENCE_REST_RATE_HZ": "60"}
    with running_service(pictures, camera_hz=100.0, settings=as_fast_as_it_can) as service:
        report |= measure_memory(service, plan)
    save(OUT / "inference.json", report)
    bars = {name: (one["p50"], one["p99"]) for name, one in report["backends"].items()}
    save_bars(OUT / "backends.png", f"Detector, {settings.model_threads} thread, one 250 x 250 picture", bars, "ms")
    save_memory(OUT / "memory.png", report["rss_mb_by_frames"])
    print(json.dumps({key: value for key, value in report.items() if key != "rss_mb_by_frames"}, indent=1))  # noqa: T201


def time_backends(settings: Settings, pictures: list[Path], plan: Plan) -> dict[str, Any]:
    """Each backend that is installed, called in turn, so that a busy neighbour slows all of them."""
    exports = detector_exports(settings)
    if exports.missing():
        trouble = asyncio.run(exports.make())
        if trouble:
            raise SystemExit(f"no exports: {trouble}")
    image = decode(pictures[0].read_bytes())
    calls: dict[str, Callable[[], object]] = {
        name: _looking(path, exports, image) for name, path in candidates(exports).items()
    }
    return {"backends": {name: percentiles(times) for name, times in in_turn(calls, plan.calls // 2).items()}}


def candidates(exports: Exports) -> dict[str, Path]:
    folder = exports.choice().path.parent
    files = {str(backend): folder / file for backend, file in FILES.items() if (folder / file).exists()}
    return {str(Backend.TORCH): exports.weights} | files


def _looking(path: Path, exports: Exports, image: Any) -> Callable[[], object]:
    detector = YoloDetector(path, threshold=0.30, imgsz=exports.imgsz, threads=exports.threads)
    return lambda: detector.detect(image)


def in_turn(calls: dict[str, Callable[[], object]], times: int) -> dict[str, list[float]]:
    """Milliseconds of each call, all of them once a round; the first rounds warm up."""
    took_ms: dict[str, list[float]] = {name: [] for name in calls}
    for round_ in range(times + 5):
        for name, call in calls.items():
            began_s = time.perf_counter()
            call()
            if round_ >= 5:
                took_ms[name].append((time.perf_counter() - began_s) * 1000)
    return took_ms


@dataclass
class Caller:
    """One kept-alive connection: what a client library costs is not the service's."""

    port: int
    connection: http.client.HTTPConnection = field(init=False)

    def __post_init__(self) -> None:
        self.connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60.0)

    def detect(self, jpeg: bytes) -> tuple[int, bytes]:
        self.connection.request("POST", "/detect", body=jpeg, headers={"Content-Type": "image/jpeg"})
        answer = self.connection.getresponse()
        return answer.status, answer.read()


def time_overhead(service: Running, settings: Settings, pictures: list[Path], plan: Plan) -> dict[str, Any]:
    """The same pictures through `/detect` and through the same models in this process, alternately.

    Direct means: pixels ready, detector and colours called, as the service calls them. Decoding, queueing, the change
    of threads, HTTP and JSON are the overhead.
    """
    models = Models(load=lambda: Loaded(load_detector(settings), load_clip(settings)), worker=Worker(1))
    models.loaded = models.load()
    images = [decode(path.read_bytes()) for path in pictures]
    caller, jpegs = Caller(service.port), [path.read_bytes() for path in pictures]
    at = {"direct": 0, "/detect": 0}

    def direct() -> None:
        models.look_here(images[at["direct"] % len(images)])
        at["direct"] += 1

    def over_http() -> None:
        status, body = caller.detect(jpegs[at["/detect"] % len(jpegs)])
        at["/detect"] += 1
        assert status == 200, body

    times = in_turn({"direct": direct, "/detect": over_http}, plan.calls)
    ratios = statistics.median(times["/detect"]) / statistics.median(times["direct"]) - 1.0
    return {
        "detect_overhead_ratio_p50": round(ratios, 4),
        "detect_ms": {name: percentiles(one) for name, one in times.items()},
    }


def time_throughput(service: Running, pictures: list[Path], plan: Plan) -> dict[str, Any]:
    """Answers a second with so many callers at once, each asking again as soon as it is answered."""
    jpegs = [path.read_bytes() for path in pictures]
    found: dict[str, float] = {}
    refused: dict[str, int] = {}
    for callers in CALLERS:
        answered, turned_away = [0] * callers, [0] * callers
        ends_s = time.monotonic() + plan.throughput_s

        def call(who: int, answered: list[int], turned_away: list[int], ends_s: float) -> None:
            caller = Caller(service.port)
            while time.monotonic() < ends_s:
                status, _ = caller.detect(jpegs[answered[who] % len(jpegs)])
                if status == 200:
                    answered[who] += 1
                else:
                    turned_away[who] += 1
                    time.sleep(RETRY_S)

        threads = [threading.Thread(target=call, args=(who, answered, turned_away, ends_s)) for who in range(callers)]
        began_s = time.monotonic()
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        found[str(callers)] = round(sum(answered) / (time.monotonic() - began_s), 1)
        refused[str(callers)] = sum(turned_away)
    return {"throughput_per_s": found, "turned_away": refused}


async def time_perception(service: Running, plan: Plan) -> dict[str, Any]:
    """From the moment a frame appears at the camera to its detections heard on Redis, less the detector's own time."""
    added: dict[str, list[float]] = {"rest": [], "fast": []}
    pace = "rest"

    async def hear(message: Detections) -> None:
        added[pace].append((time.time() - message.stamp_s) * 1000 - message.took_ms)

    async with open_bus(service.redis_url) as bus:
        listener = asyncio.create_task(bus.listen(VISION_DETECTIONS, hear))
        await asyncio.sleep(plan.perception_s)
        pace = "fast"
        await bus.publish(MISSION_TARGET, MissionTarget(target=TARGET, fast=True))
        await asyncio.sleep(plan.perception_s)
        listener.cancel()
        await asyncio.gather(listener, return_exceptions=True)
    both = [*added["rest"], *added["fast"]]
    return {
        "perception_added_ms_p50": percentiles(both)["p50"],
        "perception_added_ms": {name: percentiles(one) | {"frames": len(one)} for name, one in added.items()},
    }


def measure_memory(service: Running, plan: Plan) -> dict[str, Any]:
    """Resident memory of the service while its perception loop goes through the frames as fast as it can."""
    samples: list[tuple[int, float]] = []
    with httpx.Client(base_url=f"http://127.0.0.1:{service.port}", timeout=30.0, trust_env=False) as client:
        while not samples or samples[-1][0] < plan.frames:
            samples.append((frames_seen(client), round(service.rss_mb(), 1)))
            time.sleep(0.5)
    early = [rss for frames, rss in samples if plan.frames * 0.05 <= frames <= plan.frames * 0.15]
    late = [rss for frames, rss in samples if frames >= plan.frames * 0.9]
    return {
        "rss_growth_mb": round(float(np.median(late) - np.median(early)), 1),
        "rss_at_rest_mb": samples[0][1],
        "rss_frames": samples[-1][0],
        "rss_mb_by_frames": samples[:: max(1, len(samples) // 200)],
    }


def frames_seen(client: httpx.Client) -> int:
    lines = client.get("/metrics").text.splitlines()
    return int(next(float(line.split()[1]) for line in lines if line.startswith("inference_frames_total ")))


if __name__ == "__main__":
    main()
