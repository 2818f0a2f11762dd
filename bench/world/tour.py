"""The tour somebody drove before: what it left on the robot's disk, played once a home and copied from then on."""

import asyncio
import fcntl
import hashlib
import json
import shutil
from pathlib import Path

import demo.mapping
import inference
import memory
import robot_bridge
import sim
from bench.world.clock import TOOK_S, run_simulated
from bench.world.drawn import drawn_from
from bench.world.mesh import MeshSettings, open_mesh
from contracts.memory import Observation, ObservationsReply
from contracts.vision import Detections
from demo.mapping import TourEyes, agreed, batches, jpeg_of
from inference.perception.models import Loaded
from sim.home import Home
from sim.world import World
from sim.world.tour import tour_frames

FRAME_S = 0.02
TOURED_S = 1_000_000.0
"""When it was; episodes are an hour later."""


def toured(home: Home, models: Loaded, settings: MeshSettings, kept_in: Path) -> Path:
    """A folder with what the robot remembers of `home`; made where it is not there yet."""
    folder = kept_in / f"{home.seed}-{_digest(home, settings)}"
    kept_in.mkdir(parents=True, exist_ok=True)
    with (kept_in / f"{folder.name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # another process may be at it
        if not folder.exists():
            _make(home, models, settings, folder)
    return folder


def _make(home: Home, models: Loaded, settings: MeshSettings, folder: Path) -> None:
    partial = folder.with_name(f"{folder.name}.partial")
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    at_work = MeshSettings(partial, settings.coordinator, settings.inference, settings.memory, settings.bridge)
    with drawn_from(home.seed):
        run_simulated(lambda: _tour(home, models, at_work), start_s=TOURED_S, took_s=TOOK_S)
    for left in partial.glob("coordinator.db*"):
        left.unlink()
    partial.rename(folder)


async def _tour(home: Home, models: Loaded, settings: MeshSettings) -> None:
    """As `demo.mapping`: placed at each pose, each picture looked at by the real detector, measured, told to memory."""
    with World(home, seed=home.seed) as parked, World(home, seed=home.seed) as driven:
        async with open_mesh(parked, parked.grid, models, settings) as mesh:
            await asyncio.sleep(2.0)
            eyes, remembering = mesh.client(mesh.inference), mesh.client(mesh.memory)
            sight, told = TourEyes(driven.rgb_camera, driven.depth_camera), list[Observation]()
            for frame in tour_frames(driven):
                seen = await eyes.post("/detect", jpeg_of(frame), Detections)
                told += sight.observations(frame, seen, asyncio.get_running_loop().time())
                await asyncio.sleep(FRAME_S)
            for batch in batches(agreed(told)):
                await remembering.post("/observations", batch, ObservationsReply)
            await asyncio.sleep(2.0)


def _digest(home: Home, settings: MeshSettings) -> str:
    """Of all that a tour depends on: the home, the weights, what is set, and the code of who takes part."""
    weights = (settings.inference.detector_file, settings.inference.clip_file)
    packages = (sim, inference, memory, robot_bridge)
    code = (file for package in packages for file in sorted(Path(package.__path__[0]).rglob("*.py")))
    parts = [
        repr(home),
        settings.inference.model_dump_json(exclude={"openai_api_key", "exports_dir"}),
        settings.memory.model_dump_json(exclude={"database_url"}),
        *(
            hashlib.sha256(file.read_bytes()).hexdigest()
            for file in (*weights, Path(__file__), Path(demo.mapping.__file__), *code)
        ),
    ]
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:12]
