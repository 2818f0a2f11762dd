"""The bridge's behaviour over the fake robot; integration/robot_bridge runs the same over ROS 2."""

from support.bridge_behaviour import BridgeBehaviour
from support.recovery_behaviour import RecoveryBehaviour


class TestBridgeWithAFakeRobot(BridgeBehaviour, RecoveryBehaviour):
    pass
