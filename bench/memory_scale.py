"""`make bench-memory`: a simulated year of sightings into memory, and into the JSON file of the documents' design.

Writes out/bench/memory.json and .png. The JSON design, as the documents describe it: every sighting is a record, each
class is kept sorted by confidence, the whole file is rewritten every 5 s, and a recall loads it.
"""

import argparse
import asyncio
import gc
import json
import math
import os
import time
from bisect import insort
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from bench.memory_year import SIDE_M, STAYS, WANDERS, frames
from bench.results import pyplot, save
from contracts.geometry import Pose2D
from contracts.memory import Look, LookBatch, Observation, ObservationBatch, RecallRequest, SeenBox
from contracts.vision import Target
from memory.adapters.store import SqlStore
from memory.memory_service import MemoryService
from memory.retention import Retention
from memory.settings import Settings
from mesh.bus import open_bus
from mesh.clock import SystemClock

BATCH = 1000
CHECKPOINTS = (1_000, 10_000, 30_000, 100_000, 300_000, 1_000_000)
LOOK_EVERY = 100
TIDY_EVERY = 20_000
REWRITE_S = 5.0


@dataclass
class JsonFile:
    """The documents' design. `busy_s` is its own clock: the seconds it has worked."""

    path: Path
    records: dict[str, list[tuple[float, dict[str, float]]]] = field(default_factory=dict)
    busy_s: float = 0.0
    written_s: float = 0.0
    rewrite_s: float = 0.0

    def add(self, batch: list[Observation]) -> None:
        began_s = time.perf_counter()
        for one in batch:
            record = {"x": one.pose.x, "y": one.pose.y, "yaw": one.pose.yaw, "confidence": one.confidence}
            record["time"] = one.stamp_s
            insort(self.records.setdefault(one.label, []), (-one.confidence, record), key=lambda pair: pair[0])
        self.busy_s += time.perf_counter() - began_s
        if self.busy_s - self.written_s >= REWRITE_S:
            self.rewrite()

    def rewrite(self) -> None:
        began_s = time.perf_counter()
        whole = {label: [record for _, record in records] for label, records in self.records.items()}
        self.path.write_text(json.dumps(whole), encoding="utf-8")
        self.rewrite_s = time.perf_counter() - began_s
        self.busy_s += self.rewrite_s
        self.written_s = self.busy_s

    def recall(self, label: str) -> list[dict[str, float]]:
        found: list[dict[str, float]] = json.loads(self.path.read_text(encoding="utf-8")).get(label, [])
        return found[:20]

    def measured(self, folder: Path, taken: int, ingest_per_s: float, rng: np.random.Generator) -> dict[str, Any]:
        times_s: list[float] = []
        for _ in range(max(5, min(200, 1_000_000 // taken))):
            began_s = time.perf_counter()
            self.recall(request(rng).target.label)
            times_s.append(time.perf_counter() - began_s)
        p50, p99 = quantiles_ms(times_s)
        mb = size_mb(folder, self.path.name)
        return {
            "sightings": taken,
            "ingest_per_s": round(ingest_per_s),
            "recall_p50_ms": p50,
            "recall_p99_ms": p99,
            "file_mb": mb,
            "startup_s": round(times_s[0], 3),
            "rewrite_s": round(self.rewrite_s, 3),
            "written_mb_per_s": round(mb / REWRITE_S, 3),
        }


def quantiles_ms(times_s: list[float]) -> tuple[float, float]:
    p50, p99 = np.percentile(np.array(times_s) * 1000.0, [50, 99])
    return round(float(p50), 3), round(float(p99), 3)


def request(rng: np.random.Generator) -> RecallRequest:
    label, other = rng.choice(STAYS + WANDERS, 2, replace=False)
    x, y, yaw = rng.uniform(0.0, SIDE_M), rng.uniform(0.0, SIDE_M), rng.uniform(-math.pi, math.pi)
    return RecallRequest(
        memory_object=str(other) if rng.random() < 0.3 else None,
        target=Target(label=str(label), description=f"red {label}" if rng.random() < 0.5 else str(label)),
        pose=Pose2D(x=float(x), y=float(y), yaw=float(yaw)),
    )


async def recalls(memory: MemoryService, count: int, rng: np.random.Generator) -> dict[str, float]:
    """Wall time by quantiles, and the processor's time a recall: on a busy machine they differ."""
    times_s: list[float] = []
    cpu_s = time.process_time()
    for _ in range(count):
        wanted = request(rng)
        began_s = time.perf_counter()
        await memory.recall(wanted)
        times_s.append(time.perf_counter() - began_s)
    p50, p99 = quantiles_ms(times_s)
    cpu_ms = (time.process_time() - cpu_s) / count * 1000.0
    return {"recall_p50_ms": p50, "recall_p99_ms": p99, "recall_cpu_ms": round(cpu_ms, 3)}


def size_mb(folder: Path, stem: str) -> float:
    return round(sum(file.stat().st_size for file in folder.glob(f"{stem}*")) / 1e6, 2)


async def start_again(settings: Settings, rng: np.random.Generator) -> float:
    """Seconds from nothing to the first answer: the whole file is checked for damage on the way."""
    began_s = time.perf_counter()
    store = SqlStore.from_settings(settings)
    async with open_bus("redis://127.0.0.1:1/0") as bus:
        await MemoryService(settings, store, bus, SystemClock(), None).recall(request(rng))
    took_s = time.perf_counter() - began_s
    await store.aclose()
    return took_s


async def measure(
    folder: Path,
    sightings: int,
    recall_count: int,
    seed: int,
    told: Callable[[list[dict[str, Any]], list[dict[str, Any]]], None],
) -> None:
    """The same batches into both; each is timed by itself."""
    rng = np.random.default_rng(seed + 1)
    settings = Settings(database_url=f"sqlite:///{folder}/memory.db")
    store = SqlStore.from_settings(settings)
    theirs = JsonFile(folder / "seeds.json")
    ours_by_size: list[dict[str, Any]] = []
    theirs_by_size: list[dict[str, Any]] = []
    async with open_bus("redis://127.0.0.1:1/0") as bus:
        memory = MemoryService(settings, store, bus, SystemClock(), None)
        retention = Retention(settings, store, SystemClock(), memory.writing)
        await memory.labels(1)
        taken, looking_s, observe_cpu_s, acknowledged_s = 0, 0.0, 0.0, list[float]()
        source = batches(sightings, seed)
        for checkpoint in (one for one in CHECKPOINTS if one <= sightings):
            before, before_theirs_s = taken, theirs.busy_s
            while taken < checkpoint and (batch := next(source, None)):
                body, look = ObservationBatch(observations=tuple(batch)), looks(batch)
                began_s, cpu_s = time.perf_counter(), time.process_time()
                await memory.observe(body)
                acknowledged_s.append(time.perf_counter() - began_s)
                observe_cpu_s += time.process_time() - cpu_s
                began_s = time.perf_counter()
                await memory.look(look)
                if taken // TIDY_EVERY != (taken + len(batch)) // TIDY_EVERY:
                    await retention.tidy()
                looking_s += time.perf_counter() - began_s
                theirs.add(batch)
                gc.freeze()  # the other design's records are not for our garbage collector to look through
                taken += len(batch)
            theirs.rewrite()
            statistics = await memory.statistics()
            ours_by_size.append(
                {
                    "sightings": taken,
                    "ingest_per_s": round(taken / sum(acknowledged_s)),
                    "ingest_per_cpu_s": round(taken / observe_cpu_s),
                    **await recalls(memory, recall_count, rng),
                    "file_mb": size_mb(folder, "memory.db"),
                    "startup_s": round(await start_again(settings, rng), 3),
                    "views": statistics.views,
                    "objects": sum(statistics.objects.values()),
                    "looks_and_tidying_s": round(looking_s, 1),
                    "batch_acknowledged_p99_ms": quantiles_ms(acknowledged_s)[1],
                }
            )
            rate = (taken - before) / (theirs.busy_s - before_theirs_s)
            theirs_by_size.append(theirs.measured(folder, taken, rate, rng))
            told(ours_by_size, theirs_by_size)
    await store.aclose()


def looks(batch: list[Observation]) -> LookBatch:
    """Some frames of the batch as looks, so that what has been carried off is noticed; nothing hides anything."""
    chosen = [list(group) for _, group in groupby(batch, key=lambda one: one.stamp_s)][::LOOK_EVERY]
    return LookBatch(
        looks=tuple(
            Look(
                pose=seen[0].pose,
                stamp_s=seen[0].stamp_s,
                image_width_px=250,
                image_height_px=250,
                seen=tuple(
                    SeenBox(label=one.label, bbox_xyxy=(0.0, 0.0, 1.0, 1.0), position=one.position) for one in seen
                ),
                ranges_m=(9.0,),
            )
            for seen in chosen
        )
    )


def batches(sightings: int, seed: int) -> Iterator[list[Observation]]:
    """Whole frames, about BATCH observations together."""
    waiting: list[Observation] = []
    for frame in frames(sightings, seed=seed):
        if len(waiting) + len(frame) > BATCH:
            yield waiting
            waiting = []
        waiting = [*waiting, *frame]
    if waiting:
        yield waiting


def plot(ours: list[dict[str, Any]], theirs: list[dict[str, Any]], path: Path) -> None:
    figure, axes = pyplot().subplots(2, 2, figsize=(10, 7), layout="constrained")
    shown = (("recall_p99_ms", "recall p99, ms"), ("ingest_per_s", "sightings taken in a second"),
             ("file_mb", "file, MB"), ("startup_s", "from start to first answer, s"))  # fmt: skip
    for axis, (key, title) in zip(axes.flat, shown, strict=True):
        for rows, name in ((ours, "memory"), (theirs, "JSON file")):
            axis.loglog([row["sightings"] for row in rows], [row[key] for row in rows], "o-", label=name)
        axis.set(title=title, xlabel="sightings")
        axis.grid(visible=True, which="both", alpha=0.3)
    axes.flat[0].legend()
    figure.savefig(path, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sightings", type=int, default=1_000_000)
    parser.add_argument("--recalls", type=int, default=1000, help="at each size")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("out/bench"))
    parser.add_argument("--quick", action="store_true", help="10,000 sightings")
    arguments = parser.parse_args()
    sightings = 10_000 if arguments.quick else arguments.sightings
    folder: Path = arguments.out / "memory"
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.iterdir():
        old.unlink()

    def told(ours: list[dict[str, Any]], theirs: list[dict[str, Any]]) -> None:
        """After each size, so that a run cut short has told what it found."""
        save(arguments.out / "memory.json", {**_result(ours, theirs), "wanted_sightings": sightings})
        plot(ours, theirs, arguments.out / "memory.png")
        print("memory   ", ours[-1], flush=True)  # noqa: T201
        print("JSON file", theirs[-1], flush=True)  # noqa: T201

    asyncio.run(measure(folder, sightings, arguments.recalls, arguments.seed, told))


def _result(ours: list[dict[str, Any]], theirs: list[dict[str, Any]]) -> dict[str, Any]:
    keys = ("ingest_per_s", "recall_p50_ms", "recall_p99_ms", "file_mb", "startup_s")
    return {
        "sightings": ours[-1]["sightings"],
        **{key: ours[-1][key] for key in keys},
        "json_file": {key: theirs[-1][key] for key in keys},
        "by_size": ours,
        "json_file_by_size": theirs,
        "cpus": os.cpu_count(),
        "load_average": round(os.getloadavg()[0], 2),
    }


if __name__ == "__main__":
    main()
