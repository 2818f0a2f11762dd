"""The services that are asked, in one process over fakes, in a state in which every call of a consumer makes sense."""

import asyncio
import contextlib
from collections import Counter
from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import numpy as np

from bench.world.wire import Served, Wire, served
from contracts.geometry import Pose2D
from contracts.memory import ObservationBatch
from coordinator.app import create_app as create_coordinator
from coordinator.settings import Settings as CoordinatorSettings
from geometry.grids import OCCUPIED, OccupancyGrid
from inference.app import create_app as create_inference
from inference.settings import Settings as InferenceSettings
from memory.app import create_app as create_memory
from memory.settings import Settings as MemorySettings
from robot_bridge.app import create_app as create_bridge
from robot_bridge.settings import Settings as BridgeSettings
from speech.app import create_app as create_speech
from speech.settings import Settings as SpeechSettings
from support import coordinator_world
from support.bus import MemoryBus
from support.described import described_bus
from support.fake_clock import FakeClock
from support.fake_robot import FakeRobot
from support.fake_senses import FakeSenses
from support.inference_fakes import FakeCamera, FakeClip, FakeDetector, FakeLanguageModel, bottle, loads, picture
from support.memory_log import MemoryLog
from support.memory_store import FakeStore
from support.observations import seen
from support.speech_fakes import FakeRecognizer, FakeSynthesizer, LoudActivity
from support.toy_robot import DOCK, ToyRobot
from support.waiting import until_true


@contextlib.asynccontextmanager
async def provider(name: str, folder: Path) -> AsyncIterator[Served]:
    """The service, ready; `folder` is the bridge's."""
    async with PROVIDERS[name](folder) as service:
        yield service


async def _ready(service: Served) -> httpx.AsyncClient:
    client = httpx.AsyncClient(transport=Wire("test", service), base_url=f"http://{service.name}")

    async def ready() -> bool:
        return (await client.get("/ready")).is_success

    await until_true(ready)
    return client


REMEMBERED = ObservationBatch(
    observations=(
        seen("cup", 1.0, 1.0, colour="red", at=(2.0, 1.0), confidence=0.8),
        seen("book", 1.0, 2.0, at=(2.0, 3.0)),
    )
)


def _two_rooms() -> OccupancyGrid:
    """8 x 4 m, a wall across its middle with a doorway."""
    cells = np.zeros((80, 160), np.int8)
    cells[:2] = cells[-2:] = cells[:, :2] = cells[:, -2:] = OCCUPIED
    cells[:, 80:82] = OCCUPIED
    cells[30:48, 80:82] = 0
    return OccupancyGrid(cells, 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0))


@contextlib.asynccontextmanager
async def _memory(_: Path) -> AsyncIterator[Served]:
    settings = MemorySettings(robot_bridge_url="")
    senses = FakeSenses(ground=_two_rooms())
    app = create_memory(settings, bus=described_bus(), store=FakeStore(), senses=senses, clock=FakeClock())
    async with served("memory", app, Counter()) as service:
        client = await _ready(service)
        kept = await client.post("/observations", json=REMEMBERED.model_dump(mode="json"))
        assert kept.is_success
        yield service


@contextlib.asynccontextmanager
async def _robot_bridge(folder: Path) -> AsyncIterator[Served]:
    """The robot stands on its dock."""
    toy = ToyRobot()
    toy.put_on_dock()
    settings = BridgeSettings(state_dir=folder, dock_pose=DOCK, scan_age_s_max=60.0, session_timeout_s=10.0)
    app = create_bridge(settings, bus=MemoryBus(), robot=FakeRobot(toy))
    async with served("robot_bridge", app, Counter()) as service:
        await _ready(service)
        yield service


@contextlib.asynccontextmanager
async def _inference(_: Path) -> AsyncIterator[Served]:
    camera, model = FakeCamera(), FakeLanguageModel(says={"answer": "There are 3 cups."})
    camera.show(1.0, picture())
    app = create_inference(
        InferenceSettings(validate_frame_wait_s=0.2, parse_deadline_s=1.0),
        bus=MemoryBus(),
        camera=camera,
        models=loads(detector=FakeDetector((bottle(),)), clip=FakeClip()),
        language_models=[model],
        vlm=model,
    )
    async with served("inference", app, Counter()) as service:
        await _ready(service)
        yield service


@contextlib.asynccontextmanager
async def _coordinator(_: Path) -> AsyncIterator[Served]:
    """It has found a bottle; somebody has put it away since, and it looks for it again."""
    clock, bus = FakeClock(), described_bus()
    world = coordinator_world.World(clock, bus, things=[coordinator_world.Thing("bottle", "red", 3.0, 1.5)])
    app = create_coordinator(
        CoordinatorSettings(),
        bus=bus,
        robot=coordinator_world.FakeRobot(world),
        inference=coordinator_world.FakeInference(world),
        memory=coordinator_world.FakeMemory(),
        clock=clock,
        log=MemoryLog(),
    )
    async with served("coordinator", app, Counter()) as service:
        running = [asyncio.create_task(world.run())]
        client = await _ready(service)

        async def until_newest(field: str, value: str) -> None:
            async def so() -> bool:
                await clock.advance(1.0)
                return (await client.get("/missions")).json()[0][field] == value

            await until_true(so)

        await client.post("/missions", json={"command": "find the red bottle"})
        await until_newest("outcome", "found")
        world.things.clear()
        await client.post("/missions", json={"command": "find the red bottle"})
        await until_newest("state", "SCANNING")
        running.append(asyncio.create_task(_time_passes(clock)))
        try:
            yield service
        finally:
            for task in running:
                task.cancel()
            await asyncio.gather(*running, return_exceptions=True)


@contextlib.asynccontextmanager
async def _speech(_: Path) -> AsyncIterator[Served]:
    app = create_speech(
        SpeechSettings(), recognizer=FakeRecognizer(), activity=LoudActivity(), synthesizers=[FakeSynthesizer()]
    )
    async with served("speech", app, Counter()) as service:
        await _ready(service)
        yield service


async def _time_passes(clock: FakeClock) -> None:
    """Ten times as fast as outside."""
    while True:
        await clock.advance(0.1)
        await asyncio.sleep(0.01)


PROVIDERS = {
    "coordinator": _coordinator,
    "inference": _inference,
    "memory": _memory,
    "robot_bridge": _robot_bridge,
    "speech": _speech,
}
