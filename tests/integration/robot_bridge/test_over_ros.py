"""What only real ROS 2 can show: foreign velocities, senseless messages, lives and deaths of the process."""

import asyncio
import contextlib
import os
import signal
import sys
from collections.abc import AsyncIterator, Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
import rclpy
import redis.asyncio
from geometry_msgs.msg import TwistStamped
from nav2_msgs.action import NavigateToPose
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Image, LaserScan

from contracts.causes import SafetyCause
from contracts.problem import Dependency, DependencyState, Readiness
from contracts.topics import ROBOT_EMERGENCY_STOP, ROBOT_STATE
from support.bridge_behaviour import INSIDE, Rig, running
from support.redis_server import free_port
from support.toy_robot import DOCK, ToyRobot
from support.waiting import until, until_true

pytestmark = pytest.mark.filterwarnings("ignore:failed to send response:RuntimeWarning")

SENSOR = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)


@pytest.fixture
def stranger(ros_domain: int) -> Iterator[Node]:
    """Somebody else's node on the robot's network."""
    context = rclpy.Context()
    rclpy.init(context=context)
    node = Node("stranger", context=context, enable_rosout=False, start_parameter_services=False)
    yield node
    node.destroy_node()
    context.try_shutdown()
    context.destroy()


async def test_nav2_velocity_without_a_goal_of_ours_moves_nothing(rig: Rig) -> None:
    """The toy sends cmd_vel_nav all the time."""
    before = len(rig.toy.velocities)
    await until(lambda: len(rig.toy.velocities) > before + 20)
    assert set(rig.toy.velocities) == {(0.0, 0.0)}


async def test_zeros_go_on_going_out_when_nothing_is_asked_for(rig: Rig) -> None:
    before = len(rig.toy.velocities)
    await until(lambda: len(rig.toy.velocities) >= before + 40)
    assert set(rig.toy.velocities) == {(0.0, 0.0)}


async def test_whoever_else_drives_the_base_is_named_and_not_mixed_with(rig: Rig, stranger: Node) -> None:
    driving = stranger.create_publisher(TwistStamped, "cmd_vel", 10)

    async def told() -> Dependency:
        ready = Readiness.model_validate_json((await rig.client.get("/ready")).content)
        return next(each for each in ready.dependencies if each.name == "drivers")

    async def named() -> bool:
        return "stranger can drive" in (await told()).detail

    await until_true(named)
    assert (await told()).state is DependencyState.WARNING
    assert SafetyCause.STRANGER not in (await rig.lease()).causes
    foreign = TwistStamped()
    foreign.twist.linear.x = 0.21

    async def left_alone() -> bool:
        driving.publish(foreign)
        reply = await rig.lease()
        return SafetyCause.STRANGER in reply.causes and reply.sent.linear_x == 0.0

    await until_true(left_alone)
    assert (await told()).state is DependencyState.NOT_READY
    assert "0.21 m/s" in (await told()).detail
    stranger.destroy_publisher(driving)
    await rig.ready()


async def test_a_localiser_that_waits_for_a_pose_is_told_where_the_dock_is(tmp_path: Path, toy: ToyRobot) -> None:
    toy.silent.add("pose")
    toy.put_on_dock()
    async with running(tmp_path, toy, None, dock_pose=DOCK, nav2_active_wait_s=30.0) as rig:  # ready: localised
        assert toy.initial_poses == [(DOCK.x, DOCK.y)]
        assert (await rig.state()).pose is not None


async def test_senseless_messages_are_dropped_and_counted_and_nothing_dies(rig: Rig, stranger: Node) -> None:
    scan = stranger.create_publisher(LaserScan, "scan", SENSOR)
    rgb = stranger.create_publisher(Image, "oakd/rgb/preview/image_raw", SENSOR)
    depth = stranger.create_publisher(Image, "oakd/stereo/image_raw", SENSOR)
    info = stranger.create_publisher(CameraInfo, "oakd/rgb/preview/camera_info", SENSOR)
    publishers = (scan, rgb, depth, info)
    await until(lambda: all(each.get_subscription_count() for each in publishers))
    nan_scan = LaserScan(range_max=12.0, angle_increment=0.1, ranges=[float("nan")] * 10)
    nan_scan.header.frame_id, nan_scan.angle_min = "laser", float("nan")

    async def counts() -> dict[str, float]:
        lines = (await rig.client.get("/metrics")).text.splitlines()
        named = (line.split() for line in lines if line.startswith("robot_bridge_ros_malformed_total{"))
        return {name.split('"')[1]: float(value) for name, value in named}

    before = await counts()
    topics = ("scan", "oakd/rgb/preview/image_raw", "oakd/stereo/image_raw", "oakd/rgb/preview/camera_info")
    now = before
    async with asyncio.timeout(45.0):
        while not all(now.get(topic, 0.0) > before.get(topic, 0.0) for topic in topics):
            scan.publish(nan_scan)
            rgb.publish(Image(encoding="rgb8", width=0, height=0))
            depth.publish(Image(encoding="16UC1", width=640, height=400, step=1280, data=b"\0"))
            info.publish(CameraInfo(width=250, height=250))
            await asyncio.sleep(0.02)
            now = await counts()
    await rig.ready()


class Process:
    """`python -m robot_bridge` as a supervisor starts it."""

    def __init__(self, state_dir: Path, redis_url: str) -> None:
        self.port = free_port()
        self._environment = os.environ | {
            "ROBOT_BRIDGE_PORT": str(self.port),
            "ROBOT_BRIDGE_STATE_DIR": str(state_dir),
            "ROBOT_BRIDGE_REDIS_URL": redis_url,
        }

    @contextlib.asynccontextmanager
    async def life(self) -> AsyncIterator["tuple[asyncio.subprocess.Process, httpx.AsyncClient]"]:
        process = await asyncio.create_subprocess_exec(sys.executable, "-m", "robot_bridge", env=self._environment)
        base_url = f"http://127.0.0.1:{self.port}"
        async with httpx.AsyncClient(base_url=base_url, timeout=45, trust_env=False) as client:
            try:
                try:
                    await until_true(lambda: _ready(client), timeout_s=90.0)
                except TimeoutError:
                    raise AssertionError(f"not ready: {(await client.get('/ready')).text}") from None
                yield process, client
            finally:
                with contextlib.suppress(ProcessLookupError):
                    process.terminate()
                await asyncio.wait_for(process.wait(), 45.0)


async def _ready(client: httpx.AsyncClient) -> bool:
    with contextlib.suppress(httpx.TransportError):
        return (await client.get("/ready")).status_code == 200
    return False


async def test_a_killed_bridge_wakes_up_latched_and_its_facts_are_in_redis(
    toy: ToyRobot, tmp_path: Path, redis_url: str
) -> None:
    bridge = Process(tmp_path, redis_url)
    async with bridge.life() as (process, client):
        goal: dict[str, Any] = {"candidates": [{"pose": INSIDE}], "epoch": 0}
        assert (await client.post("/navigation/goals", json=goal)).json()["status"] == "EXECUTING"
        await until(lambda: toy.has_driven)
        assert (await client.post("/emergency-stop")).json()["state"]["latched"]
        process.kill()
        await process.wait()
    await until(lambda: toy.at_rest)
    toy.base_stop = None  # a base that was switched off and on: only the second life can tell it
    async with bridge.life() as (process, client):
        assert (await client.get("/emergency-stop")).json()["latched"]
        await until(lambda: toy.base_stop is True)
        store = redis.asyncio.Redis.from_url(redis_url)

        async def located() -> bool:
            state = await store.get(ROBOT_STATE.kept_key)
            return state is not None and ROBOT_STATE.decode(state).pose is not None

        await until_true(located)
        kept = ROBOT_EMERGENCY_STOP.decode(await store.get(ROBOT_EMERGENCY_STOP.kept_key))
        await store.aclose()
        assert (kept.latched, kept.epoch) == (True, 1)
        process.send_signal(signal.SIGTERM)
        assert await asyncio.wait_for(process.wait(), 45.0) in {
            0,
            -signal.SIGTERM,
        }  # uvicorn raises it again at the end


def spin(executor: SingleThreadedExecutor, condition: Callable[[], bool]) -> None:
    """Serves a node until the condition holds; the test's own timeout ends it otherwise."""
    while not condition():
        executor.spin_once(timeout_sec=0.02)


async def test_goals_left_by_an_earlier_life_are_cancelled_and_never_driven(
    toy: ToyRobot, tmp_path: Path, redis_url: str, stranger: Node
) -> None:
    executor = SingleThreadedExecutor(context=stranger.context)
    executor.add_node(stranger)
    client = ActionClient(stranger, NavigateToPose, "navigate_to_pose")
    spin(executor, client.server_is_ready)
    sending = client.send_goal_async(NavigateToPose.Goal())
    spin(executor, sending.done)
    assert sending.result().accepted
    async with Process(tmp_path, redis_url).life():
        assert toy.cancelled == 1
        await until(lambda: len(toy.velocities) > 5)
        assert set(toy.velocities) == {(0.0, 0.0)}
    client.destroy()
    executor.shutdown()
