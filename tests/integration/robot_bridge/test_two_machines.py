"""The bridge as its container runs it (the host's network, UDP alone) and a robot elsewhere, with real packets."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from support.source import ROOT

TESTS = ROOT / "tests"
NAMESPACES = ("--net", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc")


@pytest.mark.parametrize(
    "robot",
    [
        pytest.param("cable", id="a robot on a machine of its own, found by multicast"),
        pytest.param("server", id="the same, found through a discovery server on the robot"),
        pytest.param("beside", id="nodes on the same machine that do not share the container's memory"),
    ],
)
def test_the_bridge_of_the_container_finds_and_drives(robot: str, tmp_path: Path) -> None:
    may = () if os.geteuid() == 0 else ("--user", "--map-root-user")
    command = ["unshare", *may, *NAMESPACES, "bash", TESTS / "support/two_machines.sh", robot, sys.executable, tmp_path]
    environment = os.environ | {
        "ROS_DOMAIN_ID": "0",
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET",
        "BRIDGE_PROFILE": str(ROOT / "services/robot_bridge/fastdds.xml"),
        "PYTHONPATH": str(TESTS),
    }
    played = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=110, check=False)
    assert played.returncode == 0, played.stderr[-3000:]
