"""Keeps the base turning at 20 Hz until somebody kills it: what robot_bridge is to the base, at its least."""

import threading

import rclpy
from geometry_msgs.msg import TwistStamped
from rclpy.node import Node


def main() -> None:
    rclpy.init()
    node = Node("velocity_relay")
    publisher = node.create_publisher(TwistStamped, "cmd_vel", 10)
    message = TwistStamped()
    message.twist.angular.z = 0.8
    pause = threading.Event()
    while not pause.wait(0.05):
        publisher.publish(message)


if __name__ == "__main__":
    main()
