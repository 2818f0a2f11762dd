"""The twin of the fake arm: the simulated one, a process of its own, moved through the bridge over ROS.

What a stop does is measured by a third participant that hears joint_states alone.
"""

import asyncio
import contextlib
import signal
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import httpx
import pytest
import rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint

from contracts.arm import ArmEnd, ArmReply
from robot_bridge.arm.models import SO101
from robot_bridge.settings import Settings
from support.arm_behaviour import (
    REACHED,
    STILL,
    ArmBehaviour,
    arm_state,
    near,
    post_settled,
    stands,
    starts_moving,
    trajectory,
)
from support.bridge_behaviour import LONG_S, Rig, running
from support.redis_server import free_port
from support.toy_robot import ToyRobot
from support.waiting import until, until_true

SETTLED_S = 0.3
"""After a stop no joint moves any more, but for a settling."""
SETTLING_RAD = 0.02
WATCHED_S = 2.0
MOVED_RAD = 0.005

# a bridge that has ended does not wait for the robot's answers
pytestmark = [
    pytest.mark.filterwarnings("ignore:failed to send response:RuntimeWarning"),
    pytest.mark.timeout(600),
]


@dataclass
class Heard:
    """joint_states as they came, by the monotonic clock; and another client of the arm's controller."""

    context: rclpy.Context
    node: Node
    samples: list[tuple[float, dict[str, float]]] = field(default_factory=list)

    def on_states(self, message: JointState) -> None:
        self.samples.append((time.monotonic(), dict(zip(message.name, message.position, strict=True))))

    def positions_since(self, moment_s: float) -> list[dict[str, float]]:
        return [positions for at_s, positions in self.samples if at_s >= moment_s]

    def send(self, to: tuple[float, ...], seconds: int) -> None:
        """A goal past the bridge, as a MoveIt beside it would send one."""
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = list(SO101.names)
        point = JointTrajectoryPoint(positions=to, velocities=STILL)
        point.time_from_start.sec = seconds
        goal.trajectory.points = [point]
        client = ActionClient(self.node, FollowJointTrajectory, "arm_controller/follow_joint_trajectory")
        assert client.wait_for_server(timeout_sec=LONG_S)
        client.send_goal_async(goal)


def furthest(from_rad: dict[str, float], samples: list[dict[str, float]]) -> float:
    """How far any joint is from where it was, in any of the samples, rad."""
    return max((abs(each[name] - from_rad[name]) for each in samples for name in each), default=0.0)


@pytest.fixture(scope="module")
def module_domain() -> Iterator[None]:
    from mesh.dds import use_mesh_profile

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(1 + (free_port() + 17) % 39))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        use_mesh_profile()
        yield


@pytest.fixture(scope="module")
def simulated(module_domain: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The simulated robot with its arm; its log where it does not come up."""
    port, log_path = free_port(), tmp_path_factory.mktemp("sim") / "sim.log"
    command = [sys.executable, "-m", "sim", "--seed", "3", "--arm", "so101", "--port", str(port)]
    with log_path.open("wb") as log:
        process = subprocess.Popen(command, stderr=log)
        try:
            deadline_s = time.monotonic() + 120.0
            while not _is_ready(port):
                assert process.poll() is None, log_path.read_text()
                assert time.monotonic() < deadline_s, log_path.read_text()
                threading.Event().wait(0.2)
            yield log_path.read_text()
            process.send_signal(signal.SIGTERM)
            assert process.wait(timeout=60) == 0, log_path.read_text()
        finally:
            process.kill()
            process.wait()


def _is_ready(port: int) -> bool:
    with contextlib.suppress(httpx.HTTPError):
        return httpx.get(f"http://127.0.0.1:{port}/ready", trust_env=False, timeout=10.0).status_code == 200
    return False


@pytest.fixture
def heard(simulated: str) -> Iterator[Heard]:
    context = rclpy.Context()
    rclpy.init(context=context)
    node = Node("arm_watcher", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    heard = Heard(context, node)
    node.create_subscription(JointState, "joint_states", heard.on_states, 50)
    spinning = threading.Thread(target=executor.spin)
    spinning.start()
    yield heard
    executor.shutdown()
    spinning.join()
    node.destroy_node()
    context.try_shutdown()


@pytest.fixture
async def rig(tmp_path: Path, simulated: str) -> AsyncIterator[Rig]:
    """The bridge with its real adapter; the arm is put home, where another test left it elsewhere."""
    async with running(tmp_path, ToyRobot(), None, arm="so101", arm_speed_rad_s_max=2.0, nav2_timeout_s=20.0) as rig:
        await is_there(rig)
        answer = await post_settled(rig, "/arm/home", {"speed_share": 1.0, "epoch": 0})
        assert ArmReply.model_validate_json(answer.content).end is ArmEnd.COMPLETED
        await stands(rig.client)
        yield rig
        await rig.post("/emergency-stop/reset")  # the base of the next bridge's robot is not left disabled
        await rig.ready()


async def is_there(rig: Rig) -> None:
    async def line() -> bool:
        told = (await rig.client.get("/ready")).json()["dependencies"]
        return [each["state"] for each in told if each["name"] == "arm"] == ["ready"]

    await until_true(line)


def test_an_arm_is_off_by_default() -> None:
    assert Settings().arm == "none"


class TestSimulatedArm(ArmBehaviour):
    pass


async def test_after_a_stop_no_joint_moves_and_nothing_resumes(rig: Rig, heard: Heard) -> None:
    await until(lambda: bool(heard.samples))
    moving = asyncio.create_task(rig.post("/arm/trajectory", trajectory(REACHED, 2.0)))
    await starts_moving(rig.client)
    jaw = asyncio.create_task(rig.post("/arm/gripper", {"opening": 1.0, "epoch": 0}))
    stopped_s = time.monotonic()
    await rig.post("/emergency-stop")
    assert ArmReply.model_validate_json((await moving).content).end is ArmEnd.STOPPED
    await jaw
    await rig.post("/emergency-stop/reset")
    await until(lambda: heard.samples[-1][0] > stopped_s + SETTLED_S + WATCHED_S)
    settled, *later = heard.positions_since(stopped_s + SETTLED_S)
    assert furthest(settled, later) < SETTLING_RAD
    assert not near(tuple(settled[name] for name in SO101.names), REACHED)


async def test_what_another_client_moves_during_a_stop_is_held(rig: Rig, heard: Heard) -> None:
    """The stop holds against whoever is in the robot's DDS domain, as far as its controller takes a cancel."""
    await until(lambda: bool(heard.samples))
    await rig.post("/emergency-stop")
    stood = heard.samples[-1][1]
    heard.send(REACHED, 4)
    begun_s = time.monotonic()

    def has_moved_and_stands() -> bool:
        since, lately = heard.positions_since(begun_s), heard.positions_since(time.monotonic() - 1.0)
        return furthest(stood, since) > MOVED_RAD and len(lately) > 10 and furthest(lately[0], lately) < MOVED_RAD

    await until(has_moved_and_stands)
    assert furthest(stood, [heard.samples[-1][1]]) < 0.3
    assert not near(await stands(rig.client), REACHED)


async def test_a_bridge_that_begins_ends_what_an_earlier_one_left(tmp_path: Path, simulated: str, heard: Heard) -> None:
    heard.send(REACHED, 30)
    await until(lambda: bool(heard.samples))
    async with running(tmp_path, ToyRobot(), None, arm="so101") as rig:
        await is_there(rig)
        await stands(rig.client)
        state = await arm_state(rig.client)
        assert state.under_way == ()
        told = tuple(joint.position_rad or 0.0 for joint in state.joints)
        assert not near(told, REACHED)
