"""A stop outlives an arm's controller that is out of reach: real controllers' actions, which come and go."""

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest
import rclpy
from control_msgs.action import FollowJointTrajectory, GripperCommand
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from contracts.arm import ArmPart, TrajectoryPoint
from mesh.clock import SystemClock
from robot_bridge.adapters.ros.arm import RosArm
from robot_bridge.adapters.ros.calls import Calls, Handover
from robot_bridge.arm.models import SO101
from robot_bridge.settings import Settings
from support.ros_arm_controller import RosArmController

pytestmark = [
    pytest.mark.filterwarnings("ignore:failed to send response:RuntimeWarning"),
    pytest.mark.timeout(180),
]
ROS = Settings().ros
POINTS = (TrajectoryPoint(time_s=60.0, positions_rad=SO101.home_rad),)


@dataclass
class Adapter:
    """The adapter on a node of its own, polled when a test says so; and another client of the arm's controller."""

    arm: RosArm
    calls: Calls
    others: ActionClient

    async def polled_until(self, condition: Callable[[], bool]) -> None:
        async with asyncio.timeout(45.0):
            while not condition():
                self.calls.do(self.arm.poll)
                await asyncio.sleep(0.05)

    async def somebody_else_moves(self, controller: RosArmController) -> None:
        async with asyncio.timeout(45.0):
            while not self.others.server_is_ready():  # noqa: ASYNC110 - nobody tells
                await asyncio.sleep(0.05)
            self.calls.do(lambda: self.others.send_goal_async(FollowJointTrajectory.Goal()))
            while not controller.started:  # noqa: ASYNC110
                await asyncio.sleep(0.05)


@pytest.fixture
async def adapter(ros_domain: int) -> AsyncIterator[Adapter]:
    context = rclpy.Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    node = Node("bridge", context=context, start_parameter_services=False, enable_rosout=False)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    closing = threading.Event()
    calls = Calls(asyncio.get_running_loop(), Handover(executor).put, accept_s_max=20.0)
    arm = RosArm(SO101, ROS, SystemClock())
    arm.open(node, calls)
    others = ActionClient(node, FollowJointTrajectory, ROS.arm_action)

    def spin() -> None:
        while not closing.is_set():
            executor.spin_once(timeout_sec=0.2)

    thread = threading.Thread(target=spin, name="bridge")
    thread.start()
    yield Adapter(arm, calls, others)
    closing.set()
    await asyncio.to_thread(thread.join)
    executor.shutdown()
    arm.shut()
    others.destroy()
    node.destroy_node()
    context.try_shutdown()
    context.destroy()


@contextlib.contextmanager
def alive(action: Any, name: str) -> Iterator[RosArmController]:
    controller = RosArmController(action, name)
    controller.open()
    try:
        yield controller
    finally:
        controller.close()


async def test_a_gripper_that_comes_later_leaves_the_arms_own_motion_alone(adapter: Adapter) -> None:
    arm = adapter.arm
    with alive(FollowJointTrajectory, ROS.arm_action) as joints:
        await adapter.polled_until(lambda: not arm.owes_cancel(ArmPart.ARM))
        assert arm.owes_cancel(ArmPart.GRIPPER)
        assert await arm.follow(POINTS) is not None
        with alive(GripperCommand, ROS.gripper_action):
            await adapter.polled_until(lambda: not arm.owes_cancel(ArmPart.GRIPPER))
            await adapter.polled_until(lambda: arm.missing() == "")
        assert (joints.started, joints.cancelled) == (1, 0)


async def test_a_stop_while_the_controller_is_out_of_reach_is_not_lost(adapter: Adapter) -> None:
    arm = adapter.arm
    with alive(FollowJointTrajectory, ROS.arm_action):
        await adapter.polled_until(lambda: not arm.owes_cancel(ArmPart.ARM))
    await adapter.polled_until(lambda: ROS.arm_action in arm.missing())
    arm.cancel(ArmPart.ARM)
    with alive(FollowJointTrajectory, ROS.arm_action) as back:
        await adapter.somebody_else_moves(back)
        assert arm.owes_cancel(ArmPart.ARM)
        await adapter.polled_until(lambda: not arm.owes_cancel(ArmPart.ARM))
        await adapter.polled_until(lambda: back.cancelled == 1)


async def test_what_went_on_while_the_controller_was_out_of_reach_is_cancelled(adapter: Adapter) -> None:
    """Nobody stopped anything; whose goals they are is not known any more."""
    arm = adapter.arm
    with alive(FollowJointTrajectory, ROS.arm_action):
        await adapter.polled_until(lambda: not arm.owes_cancel(ArmPart.ARM))
    await adapter.polled_until(lambda: arm.owes_cancel(ArmPart.ARM))
    with alive(FollowJointTrajectory, ROS.arm_action) as back:
        await adapter.somebody_else_moves(back)
        await adapter.polled_until(lambda: back.cancelled == 1)


async def test_a_controller_that_refuses_to_cancel_is_asked_until_it_does(adapter: Adapter) -> None:
    arm = adapter.arm
    with alive(FollowJointTrajectory, ROS.arm_action) as joints:
        await adapter.polled_until(lambda: not arm.owes_cancel(ArmPart.ARM))
        joints.refuses = True
        assert await arm.follow(POINTS) is not None
        arm.cancel(ArmPart.ARM)
        await adapter.polled_until(lambda: "has not answered" in arm.missing())
        assert arm.owes_cancel(ArmPart.ARM)
        joints.refuses = False
        await adapter.polled_until(lambda: not arm.owes_cancel(ArmPart.ARM))
        await adapter.polled_until(lambda: joints.cancelled == 1)
