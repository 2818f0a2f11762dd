"""The same behaviour over the in-process simulated robot: physics, rendered cameras and the Nav2 stand-in, no ROS."""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from support.bridge_behaviour import BridgeBehaviour, Rig, running
from support.simulated_toy import SimulatedRobot, SimulatedToy


@pytest.fixture
async def rig(tmp_path: Path) -> AsyncIterator[Rig]:
    toy = SimulatedToy()
    async with running(tmp_path, toy, SimulatedRobot(toy), nav2_active_wait_s=30.0) as rig:
        yield rig


class TestBridgeWithTheSimulatedRobot(BridgeBehaviour):
    pass
