"""ROS_DISCOVERY_SERVER, as TurtleBot 4s are often set up: the bridge finds its robot through the server alone."""

import contextlib
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
from rclpy.node import Node

from mesh.dds import use_mesh_profile
from support.bridge_behaviour import running
from support.redis_server import free_port
from support.ros_robot import RosToyRobot
from support.toy_robot import ToyRobot
from support.waiting import until

pytestmark = pytest.mark.filterwarnings("ignore:failed to send response:RuntimeWarning")


def server_program() -> str | None:
    """Of the wheels, or of a sourced ROS."""
    return shutil.which("fast-discovery-server", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")


@pytest.fixture
def discovery_server(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    program = server_program()
    if program is None:
        pytest.skip("Fast DDS came without its discovery server")
    address = f"127.0.0.1:{free_port()}"
    host, port = address.split(":")
    process = subprocess.Popen([program, "-i", "0", "-l", host, "-p", port], stdout=subprocess.DEVNULL)
    monkeypatch.setenv("ROS_DISCOVERY_SERVER", address)
    monkeypatch.setenv("ROS_DOMAIN_ID", "0")
    monkeypatch.delenv("ROS_AUTOMATIC_DISCOVERY_RANGE", raising=False)
    use_mesh_profile()
    yield address
    process.terminate()
    process.wait(30.0)


@contextlib.contextmanager
def stranger() -> Iterator[Node]:
    """A node that looks for others by itself, without the server."""
    server = os.environ.pop("ROS_DISCOVERY_SERVER")
    context = rclpy.Context()
    rclpy.init(context=context)
    node = Node("stranger", context=context, enable_rosout=False, start_parameter_services=False)
    os.environ["ROS_DISCOVERY_SERVER"] = server
    yield node
    node.destroy_node()
    context.try_shutdown()
    context.destroy()


async def test_the_bridge_and_its_robot_meet_through_the_discovery_server_and_only_there(
    tmp_path: Path, discovery_server: str
) -> None:
    toy = ToyRobot()
    robot = RosToyRobot(toy)
    robot.open()
    try:
        with stranger() as other:
            async with running(tmp_path, toy, None, nav2_active_wait_s=30.0) as rig:  # ready: every topic flows
                assert (await rig.velocity(duration_s=1.0)).json()["accepted"]
                await until(lambda: toy.linear_x == 0.2, timeout_s=30.0)
                assert (await rig.goal(clear_costmaps=False)).json()["status"] == "EXECUTING"
                assert other.count_publishers("scan") == 0
    finally:
        robot.close()
