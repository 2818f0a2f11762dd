"""The services' own clients with the keys that `atom keys make` made, at the real bridge and coordinator."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, aclosing
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI
from pydantic import SecretStr

from atom_cli import keys
from contracts.access import CredentialFile
from contracts.geometry import Pose2D
from contracts.robot import CandidatePose, EmergencyStopRequest, GoalRequest
from coordinator.adapters.robot_bridge import RobotBridgeClient
from coordinator.app import create_app as coordinator_app
from coordinator.settings import Settings as CoordinatorSettings
from inference.adapters.bridge_camera import BridgeCamera
from mesh.access import credentials
from mesh.errors import UnavailableError, UpstreamError
from mesh.http import ServiceClient
from robot_bridge.app import create_app
from robot_bridge.settings import Settings
from support.bus import MemoryBus
from support.coordinator_world import FakeInference, FakeMemory, World
from support.fake_clock import FakeClock
from support.fake_robot import FakeRobot
from support.memory_log import MemoryLog
from support.served import served
from support.toy_robot import ToyRobot
from support.waiting import until, until_true
from ui.adapters.coordinator import CoordinatorClient
from ui.adapters.robot_bridge import RobotBridgeClient as PageRobot
from ui.settings import Settings as PageSettings


@dataclass
class Bridge:
    url: str
    toy: ToyRobot
    bus: MemoryBus
    keys: Path

    def key(self, name: str) -> SecretStr:
        return SecretStr((self.keys / f"{name}.key").read_text().strip())


@pytest.fixture
async def bridge(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Bridge]:
    monkeypatch.setattr(credentials, "LOOK_S", 0.0)
    folder, toy, bus = tmp_path / "keys", ToyRobot(), MemoryBus()
    keys.make(services=True, folder=folder)
    settings = Settings(state_dir=tmp_path, session_timeout_s=10.0, keys_file=folder / "keys.json")
    async with served(create_app(settings, bus=bus, robot=FakeRobot(toy))) as url:
        async with httpx.AsyncClient(base_url=url) as stranger:

            async def ready() -> bool:
                return (await stranger.get("/ready")).status_code == 200

            await until_true(ready, timeout_s=60.0)
        yield Bridge(url, toy, bus, folder)


@pytest.fixture
async def robot(bridge: Bridge) -> AsyncIterator[RobotBridgeClient]:
    """The coordinator's, its session held."""
    settings = CoordinatorSettings(
        robot_bridge_url=bridge.url, key=bridge.key("coordinator"), heartbeat_s=0.05, reconnect_s=0.1
    )
    async with aclosing(RobotBridgeClient(settings)) as client:
        session = asyncio.create_task(client.hold_session())
        await until(lambda: client.session_held)
        yield client
        session.cancel()
        await asyncio.gather(session, return_exceptions=True)


async def test_the_coordinator_drives_and_its_revoked_key_ends_its_session_and_what_moved(
    bridge: Bridge, robot: RobotBridgeClient
) -> None:
    there = GoalRequest(candidates=(CandidatePose(pose=Pose2D(x=4.0, y=3.0, yaw=0.5)),), epoch=0)
    await robot.navigate(there)
    await until(lambda: not bridge.toy.at_rest)
    await asyncio.to_thread(_revoke, bridge.keys, "coordinator")
    await until(lambda: bridge.toy.at_rest)
    await until(lambda: not robot.session_held)


async def test_who_only_looks_sees_the_camera_and_cannot_drive(bridge: Bridge) -> None:
    async with AsyncExitStack() as stack:
        camera = await stack.enter_async_context(aclosing(BridgeCamera(bridge.url, key=bridge.key("inference"))))
        assert await camera.newest(after_s=None, wait_s=5.0) is not None
        for name in ("inference", "memory"):
            client = ServiceClient("robot_bridge", bridge.url, key=bridge.key(name))
            await stack.enter_async_context(aclosing(client))
            with pytest.raises(UpstreamError, match=f"{name} is viewer; this needs operator"):
                await client.call("POST", "/rotate", body=b"{}")


async def test_the_page_holds_the_wheels_with_its_key_and_not_without(bridge: Bridge) -> None:
    async with (
        aclosing(PageRobot(PageSettings(robot_bridge_url=bridge.url, key=bridge.key("ui")))) as page,
        page.wheels(),
    ):
        assert not (await page.stop_state()).latched
    async with aclosing(PageRobot(PageSettings(robot_bridge_url=bridge.url))) as stranger:
        with pytest.raises(UnavailableError):
            await stranger.wheels().__aenter__()


@pytest.mark.parametrize("key", ["revoked", "mal\nformed"])
async def test_the_page_stops_and_knows_that_it_can_whatever_its_key_is_worth(bridge: Bridge, key: str) -> None:
    async with aclosing(PageRobot(PageSettings(robot_bridge_url=bridge.url, key=SecretStr(key)))) as page:
        await page.stop_answers()
        assert (await page.emergency_stop(EmergencyStopRequest())).state.latched


async def test_another_program_in_the_bridges_place_is_no_stop(bridge: Bridge) -> None:
    async with served(FastAPI()) as url, aclosing(PageRobot(PageSettings(robot_bridge_url=url))) as page:
        with pytest.raises(UpstreamError):
            await page.stop_answers()


async def test_anybody_stops_and_only_who_is_known_resets(bridge: Bridge) -> None:
    async with httpx.AsyncClient(base_url=bridge.url) as stranger:
        assert (await stranger.post("/emergency-stop")).json()["state"]["latched"]
        refused = await stranger.post("/emergency-stop/reset")
        assert (refused.status_code, refused.headers["www-authenticate"]) == (401, "Bearer")
        said = {"Authorization": f"Bearer {bridge.key('ui').get_secret_value()}"}
        assert (await stranger.post("/emergency-stop/reset", headers=said)).status_code == 200


async def test_a_mission_goes_from_the_page_over_the_coordinator_to_the_bridge(bridge: Bridge) -> None:
    settings = CoordinatorSettings(
        robot_bridge_url=bridge.url, keys_file=bridge.keys / "keys.json", key=bridge.key("coordinator")
    )
    app = coordinator_app(
        settings,
        bus=bridge.bus,
        inference=FakeInference(World(FakeClock(), MemoryBus())),
        memory=FakeMemory(()),
        log=MemoryLog(),
        on_death=lambda: None,
    )
    async with (
        served(app) as url,
        aclosing(CoordinatorClient(PageSettings(coordinator_url=url, key=bridge.key("ui")))) as page,
        aclosing(CoordinatorClient(PageSettings(coordinator_url=url))) as stranger,
    ):
        with pytest.raises(UpstreamError, match="it needs a key"):
            await stranger.start("find the red bottle", key="k-0")

        async def begun() -> bool:
            try:
                await page.start("find the red bottle", key="k-1")
            except UnavailableError:  # the robot's state is not in yet
                return False
            return True

        await until_true(begun)
        (mission,) = await page.newest(1)
        async with httpx.AsyncClient(base_url=url) as viewer:
            viewer.headers["Authorization"] = f"Bearer {bridge.key('inference').get_secret_value()}"
            assert (await viewer.post("/ask", json={"question": "go on"})).status_code == 403
            assert (await viewer.post("/ask", json={"question": "stop"})).status_code == 200
        assert (await page.newest(1))[0].id == mission.id


def _revoke(folder: Path, name: str) -> None:
    file = folder / "keys.json"
    left = tuple(one for one in CredentialFile.model_validate_json(file.read_bytes()).principals if one.name != name)
    new = folder / "new"
    new.write_text(CredentialFile(principals=left).model_dump_json())
    new.replace(file)
