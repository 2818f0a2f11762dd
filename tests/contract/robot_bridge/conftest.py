"""The bridge behind its front door, with a fake robot."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path

import pytest
import uvicorn

from robot_bridge.app import create_app
from robot_bridge.arm.port import RobotArm
from robot_bridge.settings import Settings
from support.bridge_behaviour import Rig, running
from support.bus import MemoryBus
from support.fake_robot import FakeRobot
from support.redis_server import free_port
from support.toy_robot import ToyRobot
from support.waiting import until


@pytest.fixture
async def rig(tmp_path: Path) -> AsyncIterator[Rig]:
    toy = ToyRobot()
    async with running(tmp_path, toy, FakeRobot(toy)) as rig:
        yield rig


@dataclass
class Served:
    """The app under a real HTTP server: for connections that stay open and break."""

    address: str
    toy: ToyRobot
    bus: MemoryBus


@contextlib.asynccontextmanager
async def serving(settings: Settings, toy: ToyRobot, *, arm: RobotArm | None = None) -> AsyncIterator[Served]:
    bus, port = MemoryBus(), free_port()
    app = create_app(settings, bus=bus, robot=FakeRobot(toy), arm=arm)
    config = uvicorn.Config(app, host="127.0.0.1", port=port, log_level="error", timeout_graceful_shutdown=1)
    server = uvicorn.Server(config)
    running_server = asyncio.create_task(server.serve())
    await until(lambda: server.started)
    try:
        yield Served(f"127.0.0.1:{port}", toy, bus)
    finally:
        server.should_exit = True
        await running_server


@pytest.fixture
async def served(tmp_path: Path) -> AsyncIterator[Served]:
    async with serving(Settings(state_dir=tmp_path), ToyRobot()) as served:
        yield served
