"""What a TurtleBot 4's base does as its computer sees it, behind create3_republisher: one suite for the toy's and the
simulator's.

A module that runs it defines the fixture `mission`, a client's node beside the robot, and a class inheriting this one.
"""

from typing import Any

import pytest
from irobot_create_msgs.msg import DockStatus, WheelStatus
from irobot_create_msgs.srv import EStop
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import BatteryState

from support.simulated_robot import Mission, wait_for

KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
ON_CHANGE: list[tuple[str, Any]] = [
    ("battery_state", BatteryState),
    ("dock_status", DockStatus),
    ("wheel_status", WheelStatus),
]


class BaseBehaviour:
    """The suite."""

    @pytest.mark.parametrize(("topic", "kind"), ON_CHANGE)
    def test_what_it_told_once_is_kept_for_late_listeners(self, mission: Mission, topic: str, kind: Any) -> None:
        mission.listen(topic, kind, KEPT)
        assert mission.hear(topic) is not None
        offers = [each.qos_profile for each in mission.node.get_publishers_info_by_topic(topic)]
        kept = [(each.reliability, each.durability) for each in offers]
        assert set(kept) == {(ReliabilityPolicy.RELIABLE, DurabilityPolicy.TRANSIENT_LOCAL)}

    def test_its_stop_is_done_and_told_by_the_wheels_once_whatever_the_service_answers(self, mission: Mission) -> None:
        told: list[bool] = []

        def heard(message: WheelStatus) -> None:
            told.append(message.wheels_enabled)

        mission.node.create_subscription(WheelStatus, "wheel_status", heard, KEPT)
        wait_for(lambda: told == [True], "wheels that are enabled")
        for stopped in (True, True, False, False):
            answer = mission.call(EStop, "e_stop", EStop.Request(e_stop_on=stopped))
            assert (answer.success, answer.message) == (False, "")
            wait_for(lambda stopped=stopped: told[-1] is not stopped, "wheels that say so")
        assert told == [True, False, True]

    def test_it_listens_to_velocities_as_the_republisher_does(self, mission: Mission) -> None:
        ears = wait_for(lambda: mission.node.get_subscriptions_info_by_topic("cmd_vel"), "the base")
        assert [each.qos_profile.reliability for each in ears] == [ReliabilityPolicy.BEST_EFFORT]
