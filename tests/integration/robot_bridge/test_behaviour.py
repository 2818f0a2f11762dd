"""The twin: the same behaviour over real rclpy and DDS, against a robot that is another ROS participant."""

import pytest

from support.bridge_behaviour import BridgeBehaviour
from support.recovery_behaviour import RecoveryBehaviour

# a bridge that has ended does not wait for the toy's answers
pytestmark = pytest.mark.filterwarnings("ignore:failed to send response:RuntimeWarning")


class TestBridgeOverRos(BridgeBehaviour, RecoveryBehaviour):
    pass
