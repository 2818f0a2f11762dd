"""Strangers on the ROS graph are named in /ready, and the middleware tells what a type's definition is."""

from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node

from robot_bridge.sensing.endpoints import NAME
from support.bridge_behaviour import Rig
from support.waiting import until, until_true

pytestmark = pytest.mark.filterwarnings("ignore:failed to send response:RuntimeWarning")


@pytest.fixture
def stranger(ros_domain: int) -> Iterator[Node]:
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    node = Node("stranger", context=context, start_parameter_services=False, enable_rosout=False)
    yield node
    node.destroy_node()
    context.try_shutdown()


async def types(rig: Rig) -> Any:
    found = (await rig.client.get("/ready")).json()["dependencies"]
    return next(each for each in found if each["name"] == NAME)


async def test_a_plain_twist_on_a_topic_of_stamped_ones_is_named_in_ready(rig: Rig, stranger: Node) -> None:
    assert (await types(rig))["state"] == "ready"
    stranger.create_publisher(Twist, "cmd_vel_nav", 1)
    stranger.create_subscription(Twist, "cmd_vel", lambda _: None, 1)

    async def named() -> bool:
        told = await types(rig)
        return told["state"] == "warning" and {"/cmd_vel:", "/cmd_vel_nav:"} <= set(told["detail"].split())

    await until_true(named, timeout_s=30.0)

    def versions() -> set[str]:
        return {str(each.topic_type_hash) for each in stranger.get_publishers_info_by_topic("/cmd_vel_nav")}

    await until(lambda: len(versions()) == 2, timeout_s=30.0)
    assert all(version.startswith("RIHS01_") for version in versions())
