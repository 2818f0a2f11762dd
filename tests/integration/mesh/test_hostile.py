"""Each service, on fakes, behind the real server, among `bench.hostile`'s clients: malformed, huge, slow, half-open."""

import asyncio
import random
from collections.abc import Callable
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI

from bench.hostile import POSTS, SOCKETS
from bench.hostility.attacks import ATTACKS, Target, attack
from bench.hostility.drawing import Document, Request
from bench.hostility.wire import answer, connection, encoded
from coordinator.app import create_app as coordinator_app
from coordinator.settings import Settings as CoordinatorSettings
from inference.app import create_app as inference_app
from inference.settings import Settings as InferenceSettings
from memory.app import create_app as memory_app
from memory.settings import Settings as MemorySettings
from robot_bridge.app import create_app as bridge_app
from robot_bridge.settings import Settings as BridgeSettings
from speech.app import create_app as speech_app
from speech.settings import Settings as SpeechSettings
from support.bus import MemoryBus
from support.coordinator_world import FakeInference, FakeMemory, World
from support.coordinator_world import FakeRobot as FakeBridge
from support.described import described_bus
from support.fake_clock import FakeClock
from support.fake_robot import FakeRobot
from support.inference_fakes import FakeCamera, FakeClip, FakeDetector, FakeLanguageModel, bottle, loads, picture
from support.memory_log import MemoryLog
from support.served import served
from support.speech_fakes import FakeRecognizer, FakeSynthesizer, LoudActivity
from support.toy_robot import ToyRobot
from support.ui_world import UiWorld, fresh_nicegui
from ui.app import create_app as ui_app
from ui.settings import Settings as UiSettings

DRAWN = 60
ENDLESS = ("/stream", "/rotate", "/drive", "/celebrate", "/dock", "/undock")
"""What goes on for longer than this test may."""


def coordinator(_: Path) -> FastAPI:
    clock, bus = FakeClock(), described_bus()
    world = World(clock, bus)
    inference, robot = FakeInference(world), FakeBridge(world)
    return coordinator_app(
        CoordinatorSettings(),
        bus=bus,
        robot=robot,
        inference=inference,
        memory=FakeMemory(),
        clock=clock,
        log=MemoryLog(),
    )


def robot_bridge(folder: Path) -> FastAPI:
    return bridge_app(BridgeSettings(state_dir=folder), bus=MemoryBus(), robot=FakeRobot(ToyRobot()))


def inference(_: Path) -> FastAPI:
    camera, model = FakeCamera(), FakeLanguageModel(says={"answer": "There are 3 cups."})
    camera.show(1.0, picture())
    return inference_app(
        InferenceSettings(validate_frame_wait_s=0.2, parse_deadline_s=1.0),
        bus=MemoryBus(),
        camera=camera,
        models=loads(detector=FakeDetector((bottle(),)), clip=FakeClip()),
        language_models=[model],
        vlm=model,
    )


def memory(folder: Path) -> FastAPI:
    """With a database: what is sent gets as far as SQL."""
    settings = MemorySettings(robot_bridge_url="", database_url=f"sqlite:///{folder}/memory.db")
    return memory_app(settings, bus=described_bus())


def speech(_: Path) -> FastAPI:
    return speech_app(
        SpeechSettings(), activity=LoudActivity(), recognizer=FakeRecognizer(), synthesizers=[FakeSynthesizer()]
    )


def ui(_: Path) -> FastAPI:
    fresh_nicegui()
    world = UiWorld()
    return ui_app(
        UiSettings(),
        bus=world.bus,
        robot=world.robot,
        inference=world.inference.client(),
        missions=world.missions,
        memory=world.memory,
        on_death=lambda: pytest.fail("a task of the page died"),
    )


SERVICES: tuple[Callable[[Path], FastAPI], ...] = (coordinator, inference, memory, robot_bridge, speech, ui)


def target(service: Callable[[Path], FastAPI], url: httpx.URL) -> Target:
    assert url.port is not None
    return Target(url.port, POSTS[service.__name__], SOCKETS.get(service.__name__, ()), "")


async def drawn(port: int, request: Request) -> str:
    """What one request is answered."""
    async with connection(port) as (reader, writer), asyncio.timeout(30.0):
        writer.write(encoded(request, f"127.0.0.1:{port}", {}))
        return f"{(await answer(reader, request.method))[0]} to {request.method} {request.path[:80]}"


@pytest.mark.parametrize("service", SERVICES, ids=lambda service: service.__name__)
async def test_hostile_requests_are_answered_without_a_500_and_it_serves_on(
    service: Callable[[Path], FastAPI], tmp_path: Path
) -> None:
    chance = random.Random(1)
    async with served(service(tmp_path)) as base, httpx.AsyncClient(base_url=base, timeout=30.0) as http:
        attacked = target(service, httpx.URL(base))
        document = Document((await http.get("/openapi.json")).json(), chance)
        requests = [document.request() for _ in range(DRAWN)]
        bounded = [one for one in requests if not any(part in one.path for part in ENDLESS)]
        attacks = [attack(name, attacked, chance) for name in ATTACKS for _ in range(2)]
        said = await asyncio.gather(*(drawn(attacked.port, one) for one in bounded), *attacks)
        assert [one for one in said if one.startswith(("500", "silent"))] == []
        assert (await http.get("/health")).status_code == 200


async def test_the_stop_is_answered_while_clients_are_hostile(tmp_path: Path) -> None:
    chance = random.Random(2)
    async with served(robot_bridge(tmp_path)) as base, httpx.AsyncClient(base_url=base, timeout=30.0) as http:
        attacked = target(robot_bridge, httpx.URL(base))
        attacking = asyncio.gather(*(attack(name, attacked, chance) for name in ATTACKS for _ in range(3)))
        stops = [(await http.post("/emergency-stop")).status_code for _ in range(50)]
        assert not attacking.done()
        assert stops == [200] * 50
        await attacking
