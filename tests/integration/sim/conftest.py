"""The simulated robot as a real process on a ROS domain of its own, and somebody to talk to it."""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
from geometry_msgs.msg import TwistStamped
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from mesh.dds import use_mesh_profile
from support.redis_server import free_port
from support.simulated_robot import Mission, SimProcess, wait_for

DOMAIN = 40 + os.getpid() % 60
RELAY = Path(__file__).with_name("velocity_relay.py")


@pytest.fixture(scope="package")
def ros_environment() -> Iterator[dict[str, str]]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(DOMAIN))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        use_mesh_profile()
        yield dict(os.environ)


@pytest.fixture(scope="package")
def sim(ros_environment: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimProcess]:
    """Started once for all modules here; at the end it must go, by SIGTERM, with exit code 0."""
    port = free_port()
    log_path = tmp_path_factory.mktemp("sim") / "sim.log"
    command = [sys.executable, "-m", "sim", "--seed", "3", "--want", "red bottle", "--port", str(port)]
    with log_path.open("wb") as log:
        process = subprocess.Popen(command, env=ros_environment, stderr=log)
        started = SimProcess(process, f"http://127.0.0.1:{port}")
        try:
            wait_for(lambda: started.status("/ready") == 200, "the simulated robot", timeout_s=90.0)
            yield started
            process.send_signal(signal.SIGTERM)
            assert process.wait(timeout=60) == 0, log_path.read_text()
        finally:
            process.kill()
            process.wait()


@pytest.fixture(scope="package")
def mission(ros_environment: dict[str, str], sim: SimProcess) -> Iterator[Mission]:
    """A client in this process; `relaying` makes it pass the stand-in's velocities on to the base."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=DOMAIN)
    node = Node("test_mission", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    client = Mission(node)
    cmd_vel = node.create_publisher(TwistStamped, "cmd_vel", 10)

    def relay(message: TwistStamped) -> None:
        client.newest["cmd_vel_nav"] = message
        if client.relaying:
            cmd_vel.publish(message)

    node.create_subscription(TwistStamped, "cmd_vel_nav", relay, 10)
    spinning = threading.Thread(target=executor.spin)
    spinning.start()
    yield client
    executor.shutdown()
    spinning.join()
    node.destroy_node()
    context.try_shutdown()


@pytest.fixture
def relay_process(ros_environment: dict[str, str], sim: SimProcess) -> Iterator["subprocess.Popen[bytes]"]:
    """A process that drives the base, as robot_bridge does, until it is killed."""
    process = subprocess.Popen([sys.executable, str(RELAY)], env=ros_environment)
    yield process
    process.kill()
    process.wait()
