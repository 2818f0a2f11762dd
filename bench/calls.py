"""How many HTTP calls a mission makes: of whom, by whom, on which route.

`make bench-calls`, or `python -m bench.calls --missions 20`. Seeded missions without faults, in simulated time: the
coordinator's own app, its other services simulated at its ports. What each mission's pictures showed is then told to
the real memory service, whose calls to robot_bridge are answered from ground truth. Before the first mission of a home
memory has been shown round in it. Writes out/bench/calls.json.
"""

import argparse
import asyncio
import sys
import tempfile
from collections import Counter
from pathlib import Path

import httpx
import numpy as np

from bench.memory_story import HandClock
from bench.missions.bridge import DESCRIPTION, Frame, SimulatedBridge
from bench.missions.bus import SimulatedBus
from bench.missions.eyes import SimulatedEyes, detections_of
from bench.missions.faults import Faults
from bench.missions.place import SimulatedPlace
from bench.missions.run import Run, run_mission
from bench.missions.scenario import HOMES, scenario, wanted_in
from bench.missions.seeing import Errors, detect
from bench.results import quiet, save
from bench.world.clock import run_simulated
from contracts.measuring import LocalizeReply, LocalizeRequest
from contracts.memory import LookBatch
from contracts.vision import Detections
from memory.adapters.robot_bridge import RobotBridge
from memory.adapters.store import SqlStore
from memory.memory_service import MemoryService
from memory.settings import Settings

Calls = Counter[tuple[str, str, str]]
"""By caller, callee and route."""
TOUR_POSES = 60
START_S = 1000.0
LOOK_ARRIVES_S = 0.3
"""After its picture was taken."""


class CountedBridge:
    """robot_bridge as memory asks it, over HTTP; it answers from the truth of the picture that is meant."""

    def __init__(self, bridge: SimulatedBridge, frames: list[Frame]) -> None:
        self.calls: Counter[str] = Counter()
        self._bridge = bridge
        self._frames = frames

    def answer(self, request: httpx.Request) -> httpx.Response:
        route = f"{request.method} {request.url.path}"
        self.calls[route] += 1
        if route == "GET /map":
            return httpx.Response(200, text=self._bridge.place.map_message.model_dump_json())
        asked = LocalizeRequest.model_validate_json(request.content)
        frame = min(self._frames, key=lambda one: abs(one.stamp_s - (asked.stamp_s or 0.0)))
        found = self._bridge.localize(frame, "memory", asked.boxes_xyxy)
        return httpx.Response(200, text=LocalizeReply(measurements=found).model_dump_json())


def calls_of(run: Run) -> Calls:
    """Everything that went over a wire in the mission, memory's own calls included."""
    stage = run.stage
    assert stage is not None, "the mission was played"
    calls: Calls = Counter()
    for wire in (stage.bridge.wire, stage.eyes.wire, stage.memory.wire):
        for (caller, route), count in wire.calls.items():
            calls[caller, wire.service, route] += count
    for route, count in asyncio.run(_memory_calls(stage.bridge, stage.eyes, stage.memory.told)).items():
        calls["memory", "robot_bridge", route] += count
    return calls


async def _memory_calls(bridge: SimulatedBridge, eyes: SimulatedEyes, looks: list[LookBatch]) -> Counter[str]:
    tour, clock = _tour(bridge.place), HandClock(0.0)
    counted = CountedBridge(bridge, [*tour, *eyes.taken])
    told: list[tuple[float, Detections | LookBatch]] = [(seen.stamp_s, seen) for seen in eyes.told]
    told += [(batch.looks[-1].stamp_s + LOOK_ARRIVES_S, batch) for batch in looks]
    with tempfile.TemporaryDirectory() as folder:
        settings = Settings(database_url=f"sqlite:///{folder}/memory.db", senses_timeout_s=5.0)
        store = SqlStore.from_settings(settings)
        senses = RobotBridge("http://robot_bridge", clock, timeout_s=5.0, transport=httpx.MockTransport(counted.answer))
        memory = MemoryService(settings, store, SimulatedBus(Faults(), np.random.default_rng(0)), clock, senses)
        await memory.describe(DESCRIPTION)
        for frame in tour:
            clock.time_s = frame.stamp_s
            boxes = [found.bbox_xyxy for found, _ in frame.boxes]
            await memory.take(detections_of(frame, bridge.localize(frame, "tour", boxes)))
        await memory.catch_up()
        counted.calls.clear()
        for arrives_s, what in sorted(told, key=lambda one: one[0]):
            clock.time_s = arrives_s
            if isinstance(what, LookBatch):
                await memory.look(what)
            else:
                await memory.take(what)
                await memory.catch_up()
        await senses.aclose()
        await store.aclose()
    return counted.calls


def _tour(place: SimulatedPlace) -> list[Frame]:
    """Pictures from all over the home, taken before the mission."""
    rng, frames = np.random.default_rng(7), list[Frame]()
    for number in range(TOUR_POSES):
        pose = place.random_pose(rng)
        boxes = [(found, one) for one in place.in_picture(pose) if (found := detect(one, rng, Errors())) is not None]
        frames.append(Frame(START_S - TOUR_POSES + number, pose, pose, tuple(boxes)))
    return frames


def table(calls: Calls, missions: int, seconds: float, frames: int) -> str:
    lines = [f"{missions} missions, {seconds:.0f} s, {frames} pictures; calls a mission:"]
    for (caller, callee, route), count in sorted(calls.items(), key=lambda one: (one[0][:2], -one[1])):
        lines.append(f"{caller:12} {callee:14} {route:32} {count / missions:9.1f}")
    lines.append(f"{'all':60} {calls.total() / missions:9.1f}")
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--missions", type=int, default=20)
    parser.add_argument("--out", type=Path, default=Path("out/bench/calls.json"))
    options = parser.parse_args()
    quiet()
    calls: Calls = Counter()
    seconds, frames = 0.0, 0
    for seed in range(options.missions):
        place = SimulatedPlace(seed % HOMES, *wanted_in(seed % HOMES))
        run = run_simulated(lambda place=place, seed=seed: run_mission(place, scenario(seed, faults=Faults())))
        assert run.stage is not None, "the mission was played"
        calls += calls_of(run)
        seconds, frames = seconds + run.took_s, frames + len(run.stage.eyes.taken)
        place.close()
    rows = [{"caller": a, "callee": b, "route": c, "calls": n} for (a, b, c), n in sorted(calls.items())]
    save(options.out, {"missions": options.missions, "seconds": round(seconds), "pictures": frames, "calls": rows})
    sys.stdout.write(table(calls, options.missions, seconds, frames) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
