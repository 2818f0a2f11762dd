"""The page's adapters against the real services' apps, over real sockets and a real Redis; only the robot is a toy."""

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest

import coordinator.app
import coordinator.settings
import robot_bridge.app
import robot_bridge.settings
from contracts.mission import MissionState
from mesh.bus import open_bus
from mesh.clock import SystemClock
from mesh.errors import UpstreamError
from mesh.tasks import Tasks
from support.coordinator_world import FakeInference, FakeMemory, World
from support.coordinator_world import FakeRobot as CoordinatorsRobot
from support.described import described_bus
from support.fake_clock import FakeClock
from support.fake_robot import FakeRobot as ToyBehindTheBridge
from support.memory_log import MemoryLog
from support.served import served
from support.toy_robot import ToyRobot
from support.ui_world import UiWorld, fresh_nicegui
from support.waiting import until
from ui import map_view
from ui.adapters.coordinator import CoordinatorClient
from ui.adapters.robot_bridge import RobotBridgeClient
from ui.app import create_app
from ui.desk import Desk
from ui.settings import Settings


@pytest.fixture
async def bridge_url(tmp_path: Path, redis_url: str) -> AsyncIterator[str]:
    settings = robot_bridge.settings.Settings(state_dir=tmp_path, redis_url=redis_url)
    app = robot_bridge.app.create_app(settings, robot=ToyBehindTheBridge(ToyRobot()))
    async with served(app) as url, httpx.AsyncClient(trust_env=False) as client:
        await _until_ready(client, url)
        yield url


async def _until_ready(client: httpx.AsyncClient, url: str) -> None:
    answers: list[int] = []
    while not answers or answers[-1] != 200:
        assert len(answers) < 1000
        answers.append((await client.get(f"{url}/ready")).status_code)


@dataclass
class Coordinator:
    url: str
    clock: FakeClock


@pytest.fixture
async def the_coordinator() -> AsyncIterator[Coordinator]:
    clock, bus = FakeClock(), described_bus()
    world = World(clock, bus, things=[], keep_out=[], colours_unknown=False)
    app = coordinator.app.create_app(
        coordinator.settings.Settings(),
        bus=bus,
        robot=CoordinatorsRobot(world),
        inference=FakeInference(world),
        memory=FakeMemory(()),
        clock=clock,
        log=MemoryLog(),
    )
    async with Tasks() as tasks, served(app) as url:
        tasks.start("world", world.run())
        yield Coordinator(url, clock)


async def test_stop_and_reset_reach_the_real_bridge_and_come_back_measured(bridge_url: str, redis_url: str) -> None:
    fresh_nicegui()
    app = create_app(Settings(robot_bridge_url=bridge_url, redis_url=redis_url))
    async with served(app) as url, httpx.AsyncClient(trust_env=False) as client:
        reply = (await client.post(f"{url}/stop?how=escape")).json()
        assert reply["state"]["latched"]
        assert reply["state"]["reason"] == "Esc pressed on the page"
        assert reply["state"]["by"] == "ui 127.0.0.1"
        assert reply["first_zero_ms"] < 50.0
        assert (await client.get(f"{bridge_url}/emergency-stop")).json()["latched"]
        assert (await client.get(f"{url}/live/map.png")).content.startswith(b"\x89PNG")
        lines = {
            one["name"]: one["state"] == "ready" for one in (await client.get(f"{url}/ready")).json()["dependencies"]
        }
    assert lines["robot_bridge"]
    assert not lines["coordinator"]


async def test_state_and_map_are_asked_of_the_real_bridge(bridge_url: str) -> None:
    async with AsyncExitStack() as stack:
        robot = RobotBridgeClient(Settings(robot_bridge_url=bridge_url, call_timeout_s=2.0, dock_timeout_s=5.0))
        stack.push_async_callback(robot.aclose)
        assert (await robot.state()).pose is not None
        assert map_view.picture(await robot.map()).frame.width_px > 1
        assert (await robot.dependency()).ok


async def test_the_robots_facts_arrive_over_a_real_redis(bridge_url: str, redis_url: str) -> None:
    async with AsyncExitStack() as stack:
        bus = await stack.enter_async_context(open_bus(redis_url))
        world = UiWorld()
        desk = Desk(
            settings=Settings(),
            bus=bus,
            robot=world.robot,
            inference=world.inference.client(),
            missions=world.missions,
            memory=world.memory,
            clock=SystemClock(),
        )
        desk.start(await stack.enter_async_context(Tasks()))
        await until(lambda: desk.facts.robot is not None and desk.facts.robot.pose is not None)
        assert desk.facts.stop is not None


async def test_missions_are_told_refused_and_ended_by_the_real_coordinator(the_coordinator: Coordinator) -> None:
    async with AsyncExitStack() as stack:
        missions = CoordinatorClient(
            Settings(coordinator_url=the_coordinator.url, call_timeout_s=30.0, command_timeout_s=30.0)
        )
        stack.push_async_callback(missions.aclose)
        await the_coordinator.clock.advance(0.5)
        assert (await missions.status()).state is MissionState.IDLE
        with pytest.raises(UpstreamError) as refusal:
            await missions.start("   ", key="a")
        assert refusal.value.upstream_status == 422
        mission = await missions.start("find the red bottle", key="b")
        again = await missions.start("find the red bottle", key="b")
        assert again.id == mission.id
        second = await missions.start("find the blue cup", key="c")
        assert second.queue_position == 0
        assert (await missions.cancel(second.id)).queue_position is None
        assert (await missions.pause(mission.id)).id == mission.id
        assert (await missions.cancel(mission.id)).id == mission.id
        assert all(one.mission_id == mission.id for one in await missions.events(mission.id))
