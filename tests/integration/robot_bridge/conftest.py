"""A ROS domain of this session's own, and the toy robot on it."""

import os
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import pytest

from mesh.dds import use_mesh_profile
from support.bridge_behaviour import Rig, running
from support.ros_robot import RosToyRobot
from support.toy_robot import ToyRobot


@pytest.fixture
def ros_domain() -> Iterator[int]:
    domain = 1 + os.getpid() % 39
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(domain))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        use_mesh_profile()
        yield domain


@pytest.fixture
def toy(ros_domain: int) -> Iterator[ToyRobot]:
    """The toy robot, alive on DDS."""
    toy = ToyRobot()
    robot = RosToyRobot(toy)
    robot.open()
    yield toy
    robot.close()


@pytest.fixture
async def rig(tmp_path: Path, toy: ToyRobot) -> AsyncIterator[Rig]:
    # a busy machine is no failure: what waits for Nav2 here waits long
    async with running(
        tmp_path, toy, None, nav2_active_wait_s=30.0, preflight_s_max=30.0, costmap_timeout_s=10.0
    ) as rig:
        yield rig
