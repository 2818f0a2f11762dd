"""ROS_DISCOVERY_SERVER, as TurtleBot 4s are often set up: the bridge and its robot meet through the server."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.redis_server import free_port

TESTS = Path(__file__).parents[2]


@pytest.fixture
def discovery_server() -> Iterator[str]:
    """Its address; the program comes with the wheels or with a sourced ROS."""
    places = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    program = shutil.which("fast-discovery-server", path=places)
    assert program is not None, "Fast DDS came without its discovery server"
    port = free_port()
    process = subprocess.Popen([program, "-i", "0", "-l", "127.0.0.1", "-p", str(port)], stdout=subprocess.DEVNULL)
    yield f"127.0.0.1:{port}"
    process.terminate()
    process.wait(30.0)


def test_the_bridge_and_its_robot_meet_through_the_discovery_server(tmp_path: Path, discovery_server: str) -> None:
    environment = os.environ | {
        "ROS_DISCOVERY_SERVER": discovery_server,
        "ROS_DOMAIN_ID": "0",
        "PYTHONPATH": str(TESTS),
    }
    played = subprocess.run(
        [sys.executable, "-m", "support.discovery_scene", "both", str(tmp_path)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=110,
        check=False,
    )
    assert played.returncode == 0, played.stderr[-3000:]
