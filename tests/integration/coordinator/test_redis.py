"""The coordinator over a real Redis: what it keeps there, and what it hears."""

import asyncio
from collections.abc import AsyncIterator
from dataclasses import dataclass

import httpx
import pytest
from websockets.asyncio.client import connect

from contracts.mission import MissionState
from contracts.robot import EmergencyStop
from contracts.topics import (
    MISSION_EVENTS,
    MISSION_STATE,
    MISSION_TARGET,
    ROBOT_DESCRIPTION,
    ROBOT_EMERGENCY_STOP,
    ROBOT_STATE,
    VISION_DETECTIONS,
)
from coordinator.app import create_app
from coordinator.settings import Settings
from mesh.bus import RedisBus, open_bus
from mesh.clock import SystemClock
from support.bus import MemoryBus
from support.coordinator_world import FakeInference, FakeMemory, FakeRobot, Thing, World
from support.described import DESCRIPTION
from support.memory_log import MemoryLog
from support.served import served
from support.waiting import until, until_true

RED = Thing("bottle", "red", 3.5, 2.5)


@dataclass
class Rig:
    client: httpx.AsyncClient
    bus: RedisBus
    world: World
    url: str


async def live(world: World, bus: RedisBus) -> None:
    """The robot and the eyes, over Redis, in real time."""
    while True:
        await bus.publish(ROBOT_STATE, world.state())
        await bus.publish(VISION_DETECTIONS, world.detections())
        await asyncio.sleep(0.05)


@pytest.fixture
async def rig(redis_url: str) -> AsyncIterator[Rig]:
    world = World(SystemClock(), MemoryBus(), things=[RED])  # type: ignore[arg-type]
    app = create_app(
        Settings(redis_url=redis_url, scan_speed_rad_s=1.9),
        robot=FakeRobot(world),
        inference=FakeInference(world),
        memory=FakeMemory(),
        log=MemoryLog(),
    )
    async with open_bus(redis_url) as bus:
        await bus.publish(ROBOT_EMERGENCY_STOP, world.stop)  # kept by Redis, as is the state: the last test's are over
        await bus.publish(ROBOT_STATE, world.state())
        await bus.publish(ROBOT_DESCRIPTION, DESCRIPTION)
        async with served(app) as url, httpx.AsyncClient(base_url=url) as client:
            living = asyncio.create_task(live(world, bus))

            async def ready() -> bool:
                return (await client.get("/ready")).status_code == 200

            await until_true(ready)
            yield Rig(client, bus, world, url)
            living.cancel()
            await asyncio.gather(living, return_exceptions=True)


async def state(rig: Rig) -> str:
    return str((await rig.client.get("/state")).json()["state"])


async def test_idle_is_kept_in_redis_for_late_listeners(rig: Rig) -> None:
    kept = await rig.bus.last(MISSION_STATE)
    target = await rig.bus.last(MISSION_TARGET)
    assert kept is not None
    assert kept.state is MissionState.IDLE
    assert target is not None
    assert target.target is None


async def test_a_mission_is_told_on_redis_and_its_target_is_kept(rig: Rig) -> None:
    heard: list[str] = []

    async def note(event: object) -> None:
        heard.append(str(event))

    listening = asyncio.create_task(rig.bus.listen(MISSION_EVENTS, note))
    await asyncio.sleep(0)
    mission = (await rig.client.post("/missions", json={"command": "find the red bottle"})).json()
    await until(lambda: bool(heard))

    async def kept(description: str | None) -> bool:
        target = await rig.bus.last(MISSION_TARGET)
        return target is not None and (target.target.description if target.target else None) == description

    await until_true(lambda: kept("red bottle"))
    await rig.client.post(f"/missions/{mission['id']}/cancel")
    await until_true(lambda: kept(None))
    listening.cancel()
    await asyncio.gather(listening, return_exceptions=True)


async def test_a_stop_heard_on_redis_aborts_the_mission(rig: Rig) -> None:
    mission = (await rig.client.post("/missions", json={"command": "find the red bottle"})).json()
    rig.world.stop = EmergencyStop(latched=True, epoch=1, reason="test")
    await rig.bus.publish(ROBOT_EMERGENCY_STOP, rig.world.stop)

    async def stopped() -> bool:
        return await state(rig) == "EMERGENCY_STOP"

    await until_true(stopped, timeout_s=45.0)
    ended = (await rig.client.get(f"/missions/{mission['id']}")).json()
    assert ended["outcome"] == "aborted"


async def test_the_timeline_streams_from_an_event_on(rig: Rig) -> None:
    mission = (await rig.client.post("/missions", json={"command": "find the red bottle"})).json()
    address = rig.url.replace("http", "ws", 1) + "/events?after=0"
    async with connect(address, proxy=None) as socket:
        first = await asyncio.wait_for(socket.recv(), 45.0)
        assert '"id":1,' in str(first)
        await rig.client.post(f"/missions/{mission['id']}/cancel")
        texts = [str(first)]
        async with asyncio.timeout(45.0):
            while "cancelled by the operator" not in texts[-1]:
                texts.append(str(await socket.recv()))
    assert mission["id"] in texts[-1]
