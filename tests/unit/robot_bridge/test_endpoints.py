"""Whether those on the bridge's topics speak in its types."""

import pytest

from contracts.problem import DependencyState
from robot_bridge.sensing.endpoints import Endpoint, dependency, mismatches

OURS = Endpoint("/cmd_vel_nav", "robot_bridge", "geometry_msgs/msg/TwistStamped", "RIHS01_ours")
RIGHT = Endpoint("/cmd_vel_nav", "controller_server", "geometry_msgs/msg/TwistStamped", "RIHS01_ours")
UNHASHED = Endpoint("/cmd_vel_nav", "old_node", "geometry_msgs/msg/TwistStamped")
PLAIN = Endpoint("/cmd_vel_nav", "collision_monitor", "geometry_msgs/msg/Twist", "RIHS01_plain")
LYRICAL = Endpoint("/cmd_vel_nav", "bt_navigator", "geometry_msgs/msg/TwistStamped", "RIHS01_other")


@pytest.mark.parametrize(
    ("others", "state"),
    [
        ((), DependencyState.READY),
        ((RIGHT,), DependencyState.READY),
        ((UNHASHED,), DependencyState.READY),
        ((RIGHT, PLAIN), DependencyState.WARNING),
        ((PLAIN,), DependencyState.NOT_READY),
        ((LYRICAL,), DependencyState.NOT_READY),
        ((RIGHT, LYRICAL), DependencyState.NOT_READY),
    ],
)
def test_another_type_beside_a_right_one_is_a_warning_and_what_is_misread_keeps_from_ready(
    others: tuple[Endpoint, ...], state: DependencyState
) -> None:
    assert dependency(mismatches(OURS, others)).state is state


def test_a_stranger_is_named_with_topic_and_both_types() -> None:
    detail = dependency(mismatches(OURS, (PLAIN, LYRICAL))).detail
    assert all(
        word in detail for word in ("/cmd_vel_nav", "collision_monitor", "msg/Twist,", "bt_navigator", "misread")
    )
