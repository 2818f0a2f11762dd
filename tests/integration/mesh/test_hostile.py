"""The coordinator's app and the bridge's stop, on fakes, behind the real server, among `bench.hostile`'s clients."""

import asyncio
import random
from collections.abc import Callable
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI

from bench.hostility.attacks import ATTACKS, Target, attack
from bench.hostility.drawing import Document, Request
from bench.hostility.wire import answer, connection, encoded
from coordinator.app import create_app as coordinator_app
from coordinator.settings import Settings as CoordinatorSettings
from robot_bridge.app import create_app as bridge_app
from robot_bridge.settings import Settings as BridgeSettings
from support.bus import MemoryBus
from support.coordinator_world import FakeInference, FakeMemory, World
from support.coordinator_world import FakeRobot as FakeBridge
from support.described import described_bus
from support.fake_clock import FakeClock
from support.fake_robot import FakeRobot
from support.memory_log import MemoryLog
from support.served import served
from support.toy_robot import ToyRobot

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


SERVICES: dict[Callable[[Path], FastAPI], tuple[str, tuple[str, ...]]] = {
    coordinator: ("/missions", ("/events",)),
    robot_bridge: ("/velocity", ("/velocity", "/session")),
}


async def drawn(port: int, request: Request) -> str:
    """What one request is answered."""
    async with connection(port) as (reader, writer), asyncio.timeout(30.0):
        writer.write(encoded(request, f"127.0.0.1:{port}", {}))
        return f"{(await answer(reader, request.method))[0]} to {request.method} {request.path[:80]}"


@pytest.mark.parametrize("service", [coordinator], ids=lambda service: service.__name__)
async def test_hostile_requests_are_answered_without_a_500_and_it_serves_on(
    service: Callable[[Path], FastAPI], tmp_path: Path
) -> None:
    chance = random.Random(1)
    async with served(service(tmp_path)) as base, httpx.AsyncClient(base_url=base, timeout=30.0) as http:
        url = httpx.URL(base)
        assert url.port is not None
        target = Target(url.port, *SERVICES[service], "")
        document = Document((await http.get("/openapi.json")).json(), chance)
        requests = [document.request() for _ in range(DRAWN)]
        bounded = [one for one in requests if not any(part in one.path for part in ENDLESS)]
        attacks = [attack(name, target, chance) for name in ATTACKS for _ in range(2)]
        said = await asyncio.gather(*(drawn(url.port, one) for one in bounded), *attacks)
        assert [one for one in said if one.startswith(("500", "silent"))] == []
        assert (await http.get("/health")).status_code == 200


async def test_the_stop_is_answered_while_clients_are_hostile(tmp_path: Path) -> None:
    chance = random.Random(2)
    async with served(robot_bridge(tmp_path)) as base, httpx.AsyncClient(base_url=base, timeout=30.0) as http:
        port = httpx.URL(base).port
        assert port is not None
        target = Target(port, *SERVICES[robot_bridge], "")
        attacking = asyncio.gather(*(attack(name, target, chance) for name in ATTACKS for _ in range(3)))
        stops = [(await http.post("/emergency-stop")).status_code for _ in range(50)]
        assert not attacking.done()
        assert stops == [200] * 50
        await attacking
