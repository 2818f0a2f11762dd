"""The doctor before the simulated robot, as a process of its own: it has nothing to say."""

import json
import subprocess
import sys

from robot_bridge.doctor.findings import Check
from support.redis_server import free_port
from support.simulated_robot import SimProcess


def test_the_doctor_finds_nothing_on_the_healthy_simulator(ros_environment: dict[str, str], sim: SimProcess) -> None:
    nobody = ros_environment | {"ROBOT_BRIDGE_PORT": str(free_port())}
    command = [sys.executable, "-m", "robot_bridge.doctor", "--json"]
    done = subprocess.run(command, env=nobody, capture_output=True, text=True, timeout=120, check=False)
    # on a busy machine the simulator's pictures come late, and that is said too
    assert [finding for finding in json.loads(done.stdout) if finding["check"] != Check.SLOW] == []
    assert done.returncode == 0
