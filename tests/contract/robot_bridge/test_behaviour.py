"""The bridge's behaviour over the fake robot; integration/robot_bridge runs the same over ROS 2."""

from support.bridge_behaviour import BridgeBehaviour


class TestBridgeWithAFakeRobot(BridgeBehaviour):
    pass
