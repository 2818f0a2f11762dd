"""A stop outlives a Nav2 that is out of reach: a real action server of Nav2's type, which comes and goes."""

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest
import rclpy
from action_msgs.srv import CancelGoal
from irobot_create_msgs.action import Undock
from nav2_msgs.action import NavigateToPose
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from contracts.geometry import Pose2D
from mesh.clock import SystemClock
from mesh.errors import UnavailableError
from robot_bridge.adapters.ros.goal_cancels import GoalCancels
from robot_bridge.adapters.ros.robot import RosRobot
from robot_bridge.settings import Settings
from support.ros_arm_controller import RosArmController

# a robot that has ended does not wait for the servers' answers
pytestmark = [
    pytest.mark.filterwarnings("ignore:failed to send response:RuntimeWarning"),
    pytest.mark.timeout(180),
]
ROS = Settings().ros
THERE = Pose2D(x=1.0, y=2.0, yaw=0.0)


@dataclass
class Reach:
    """The adapter, as the bridge opens it, and another client of Nav2's action beside it."""

    robot: RosRobot
    others: ActionClient

    async def nav2_is(self, said: Callable[[str], bool]) -> None:
        found = await self.robot.senses.nav2_missing.wait_for(lambda reading: said(reading.value), 45.0)
        assert found is not None, self.robot.senses.nav2_missing.value


async def somebody_else_drives(stranger: ActionClient, nav2: RosArmController) -> None:
    await wait_until(stranger.server_is_ready)
    stranger.send_goal_async(NavigateToPose.Goal())
    await wait_until(lambda: nav2.started > 0)


async def wait_until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(45.0):
        while not condition():  # noqa: ASYNC110 - nobody tells
            await asyncio.sleep(0.02)


@contextlib.contextmanager
def spun(name: str) -> Iterator[Node]:
    """A node of its own, served by a thread of its own."""
    context = rclpy.Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    node = Node(name, context=context, start_parameter_services=False, enable_rosout=False)
    executor, closing = SingleThreadedExecutor(context=context), threading.Event()
    executor.add_node(node)

    def spin() -> None:
        while not closing.is_set():
            executor.spin_once(timeout_sec=0.05)

    thread = threading.Thread(target=spin, name=name)
    thread.start()
    try:
        yield node
    finally:
        closing.set()
        thread.join()
        executor.shutdown()
        node.destroy_node()
        context.try_shutdown()
        context.destroy()


@pytest.fixture
def stranger(ros_domain: int) -> Iterator[ActionClient]:
    with spun("stranger") as node:
        client = ActionClient(node, NavigateToPose, ROS.navigate_action)
        yield client
        client.destroy()


@pytest.fixture
async def reach(ros_domain: int, stranger: ActionClient) -> AsyncIterator[Reach]:
    deaths: list[str] = []
    ros = ROS.model_copy(update={"nav2_lifecycle_nodes": ()})
    settings = Settings().model_copy(update={"ros": ros, "nav2_timeout_s": 3.0})
    robot = RosRobot(settings, SystemClock(), on_death=lambda: deaths.append("the robot's thread"))
    await robot.start(tick=lambda: None, navigation_velocity=lambda linear, angular: None)
    yield Reach(robot, stranger)
    await robot.close()
    assert deaths == []


@contextlib.contextmanager
def alive(action: Any, name: str) -> Iterator[RosArmController]:
    server = RosArmController(action, name)
    server.open()
    try:
        yield server
    finally:
        server.close()


@pytest.fixture
def cancels(ros_domain: int) -> Iterator[GoalCancels]:
    """Polled when a test says so, on a node of its own: else nobody knows what came first, the goal or the cancel."""
    with spun("bridge") as node:
        yield GoalCancels(node, ROS.navigate_action, "nav2", SystemClock())


async def polled_until(cancels: GoalCancels, condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(45.0):
        while not condition():
            cancels.poll()
            await asyncio.sleep(0.05)


async def test_a_stop_while_nav2_is_out_of_reach_cancels_its_goals_when_it_is_back(
    cancels: GoalCancels, stranger: ActionClient
) -> None:
    with alive(NavigateToPose, ROS.navigate_action):
        await polled_until(cancels, lambda: not cancels.owed)
    await wait_until(lambda: not stranger.server_is_ready())
    cancels.owe()
    cancels.poll()
    with alive(NavigateToPose, ROS.navigate_action) as back:
        await somebody_else_drives(stranger, back)
        assert cancels.owed
        await polled_until(cancels, lambda: back.cancelled == 1)
        await polled_until(cancels, lambda: not cancels.owed)


async def test_a_goal_of_ours_is_not_sent_before_the_owed_cancel_is_answered_and_not_taken_for_an_old_one(
    reach: Reach,
) -> None:
    with alive(NavigateToPose, ROS.navigate_action):
        await reach.nav2_is(lambda missing: missing == "")
    await reach.nav2_is(lambda missing: missing != "")
    reach.robot.cancel_all_goals()
    with pytest.raises(UnavailableError, match="is not there"):
        await reach.robot.navigate(THERE, lambda left_m: None)
    with alive(NavigateToPose, ROS.navigate_action) as back:
        await reach.nav2_is(lambda missing: missing == "")
        assert await reach.robot.navigate(THERE, lambda left_m: None) is not None
        await wait_until(lambda: back.started == 1)
        assert back.cancelled == 0
        reach.robot.cancel_all_goals()
        await wait_until(lambda: back.cancelled == 1)


async def test_a_nav2_that_refuses_to_cancel_is_asked_until_it_does_and_nothing_is_sent_to_it_meanwhile(
    cancels: GoalCancels,
) -> None:
    """The cancel service alone: an action server of rclpy does not say that it refused, one of rclcpp does."""
    answers = [CancelGoal.Response.ERROR_REJECTED, CancelGoal.Response.ERROR_REJECTED]

    def cancel(request: CancelGoal.Request, response: CancelGoal.Response) -> CancelGoal.Response:
        response.return_code = answers.pop() if answers else CancelGoal.Response.ERROR_NONE
        return response

    with spun("nav2") as node:
        node.create_service(CancelGoal, f"{ROS.navigate_action}/_action/cancel_goal", cancel)
        await polled_until(cancels, lambda: len(answers) < 2)
        assert cancels.owed
        with pytest.raises(UnavailableError, match="has not answered yet that its goals are cancelled"):
            await cancels.settle(0.05)
        await polled_until(cancels, lambda: not cancels.owed)
        assert (answers, cancels.late()) == ([], False)
        await cancels.settle(0.0)


async def test_a_base_that_comes_later_has_its_docking_cancelled_and_then_takes_ours(reach: Reach) -> None:
    reach.robot.cancel_all_goals()
    with pytest.raises(UnavailableError, match="is not there"):
        await reach.robot.undock()
    with alive(Undock, ROS.undock_action) as base:
        undocking = asyncio.create_task(reach.robot.undock())
        await wait_until(lambda: base.started == 1)
        assert base.cancelled == 0
        reach.robot.cancel_all_goals()
        assert await undocking is False
        assert base.cancelled == 1
