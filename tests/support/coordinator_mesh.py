"""The coordinator's app over a fake world in fake time."""

import asyncio
import math
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass

import httpx
from asgi_lifespan import LifespanManager

from contracts.geometry import Pose2D
from contracts.mission import Mission, MissionEvent, MissionState
from coordinator.app import create_app
from coordinator.exploration_ports import CopiedJournal
from coordinator.ports import MissionLog
from coordinator.settings import Settings
from support.bus import MemoryBus
from support.coordinator_world import FakeInference, FakeMemory, FakeRobot, Thing, World
from support.described import described_bus
from support.exploration_memory import KeptHomes
from support.fake_clock import FakeClock
from support.memory_log import MemoryLog
from support.mission_script import STEP_BY_STEP


@dataclass
class Mesh:
    client: httpx.AsyncClient
    world: World
    robot: FakeRobot
    inference: FakeInference
    memory: FakeMemory
    clock: FakeClock
    bus: MemoryBus
    running: asyncio.Task[None]
    journal: KeptHomes
    transport: httpx.ASGITransport
    """To the service, for a client of another's."""

    def silence(self) -> None:
        """The robot and the eyes say nothing any more."""
        self.running.cancel()

    def away_m(self, thing: Thing) -> float:
        """From the camera."""
        return math.hypot(self.world.pose.x - thing.x, self.world.pose.y - thing.y) - 0.06

    def bearing_rad(self, thing: Thing) -> float:
        pose = self.world.pose
        return math.remainder(math.atan2(thing.y - pose.y, thing.x - pose.x) - pose.yaw, math.tau)

    async def post_mission(self, command: str = "find the red bottle") -> Mission:
        response = await self.client.post("/missions", json={"command": command})
        assert response.status_code == 201, response.text
        return Mission.model_validate_json(response.content)

    async def mission(self, mission_id: str) -> Mission:
        return Mission.model_validate_json((await self.client.get(f"/missions/{mission_id}")).content)

    async def timeline(self, mission_id: str) -> list[MissionEvent]:
        answer = await self.client.get(f"/missions/{mission_id}/events")
        return [MissionEvent.model_validate(event) for event in answer.json()]

    async def advance_until(
        self, holds: Callable[[], Awaitable[bool]], *, within_s: float, step_s: float = 0.4
    ) -> None:
        until_s = self.clock.now_s() + within_s
        while not await holds():
            assert self.clock.now_s() < until_s, "it did not happen in time"
            await self.clock.advance(step_s)

    async def until_state(self, state: MissionState, *, within_s: float = 900.0) -> None:
        async def reached() -> bool:
            return (await self.client.get("/state")).json()["state"] == state.value

        await self.advance_until(reached, within_s=within_s)

    async def until_over(self, mission_id: str, *, within_s: float = 1000.0) -> Mission:
        async def over() -> bool:
            return (await self.mission(mission_id)).outcome is not None

        await self.advance_until(over, within_s=within_s, step_s=1.0)
        return await self.mission(mission_id)


OpenMesh = Callable[..., AbstractAsyncContextManager[Mesh]]


@asynccontextmanager
async def opened_mesh(
    *things: Thing,
    views: tuple[Pose2D, ...] = (),
    keep_out: tuple[tuple[float, float, float], ...] = (),
    colours_unknown: bool = False,
    log: MissionLog | None = None,
    journal: CopiedJournal | None = None,
    described: bool = True,
    **settings: object,
) -> AsyncIterator[Mesh]:
    clock, bus = FakeClock(), described_bus() if described else MemoryBus()
    world = World(clock, bus, things=list(things), keep_out=list(keep_out), colours_unknown=colours_unknown)
    robot, inference, memory = FakeRobot(world), FakeInference(world), FakeMemory(views)
    kept = KeptHomes()
    deaths: list[str] = []
    app = create_app(
        Settings.model_validate(STEP_BY_STEP | settings),
        bus=bus,
        robot=robot,
        inference=inference,
        memory=memory,
        clock=clock,
        log=MemoryLog() if log is None else log,
        journal=kept if journal is None else journal,
        on_death=lambda: deaths.append("a task died"),
    )
    async with LifespanManager(app) as manager:
        running = asyncio.create_task(world.run())
        transport = httpx.ASGITransport(app=manager.app)
        async with httpx.AsyncClient(transport=transport, base_url="http://coordinator") as client:
            await clock.advance(0.3)
            yield Mesh(client, world, robot, inference, memory, clock, bus, running, kept, transport)
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
    assert deaths == []
