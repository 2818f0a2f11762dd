"""What a worker process does: loads the models once, plays episodes, writes their records."""

import asyncio
import gc
import json
import logging
import os
import sys
import time
from pathlib import Path
from typing import Any

from bench.results import quiet as without_logs
from bench.search.play import played
from bench.search.sets import episode
from bench.world.mesh import MeshSettings
from inference.adapters.loading import detector_exports, loader
from inference.perception.models import Loaded
from inference.settings import Backend, ModelSet, Settings


def worked(
    jobs: list[tuple[str, int]], like: dict[str, Any], homes: tuple[int, ...], out: Path, until_s: float
) -> list[dict[str, Any]]:
    """In a process of its own. `like`: what the episodes have in common; `until_s`: monotonic, the same everywhere."""
    records: list[dict[str, Any]] = []
    for name, number in jobs:
        if time.monotonic() > until_s:
            break
        one = episode(name, number, homes).model_copy(update=like)
        models, settings = loaded(one.detector)
        record = played(one, models, settings, tours=out / "tours")
        file = out / f"{one.name}.json"
        file.parent.mkdir(parents=True, exist_ok=True)
        partial = file.with_suffix(".partial")
        partial.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
        partial.replace(file)
        records.append(record)
    return records


_LOADED: dict[str, tuple[Loaded, MeshSettings]] = {}


def loaded(detector: str) -> tuple[Loaded, MeshSettings]:
    """The models and every service's settings, once a process."""
    if detector not in _LOADED:
        settings = inference_settings(detector)
        _LOADED[detector] = loader(settings)(), MeshSettings(Path(), inference=settings)
    return _LOADED[detector]


def inference_settings(detector: str) -> Settings:
    """One backend by name: which is the fastest is not the same each time."""
    return Settings(model_set=ModelSet(detector), detector_backend=Backend.OPENVINO)


def prepare_exports(detector: str) -> None:
    exports = detector_exports(inference_settings(detector))
    if exports.missing():
        say("exporting the detector")
        trouble = asyncio.run(exports.make())
        if trouble:
            raise SystemExit(f"the detector could not be exported: {trouble}")


def say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def begin() -> None:
    """One thread a process: the cores are shared out among processes."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(50_000, 20, 50)  # the usual 700 costs a tenth of the time
    without_logs()
    logging.disable(logging.CRITICAL)
