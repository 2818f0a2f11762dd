"""The toy's base is a twin of the simulator's: one suite over both."""

import threading
from collections.abc import Iterator

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from support.base_behaviour import BaseBehaviour
from support.simulated_robot import Mission
from support.toy_robot import ToyRobot


@pytest.fixture
def mission(toy: ToyRobot) -> Iterator[Mission]:
    context = rclpy.Context()
    rclpy.init(context=context)
    node = Node("client", context=context, enable_rosout=False, start_parameter_services=False)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    spinning = threading.Thread(target=executor.spin)
    spinning.start()
    yield Mission(node)
    executor.shutdown()
    spinning.join()
    node.destroy_node()
    context.try_shutdown()
    context.destroy()


class TestRepublishedToyBase(BaseBehaviour):
    pass
