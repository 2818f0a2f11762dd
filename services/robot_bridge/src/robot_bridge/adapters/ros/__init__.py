"""The robot over ROS 2: the only place of the service that knows rclpy."""

from robot_bridge.adapters.ros.robot import RosRobot

__all__ = ["RosRobot"]
