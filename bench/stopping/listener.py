"""Hears `cmd_vel` in a ROS process of its own and writes one line for each: monotonic time in ns, m/s, rad/s."""

import sys
import time

from geometry_msgs.msg import TwistStamped

from bench.ros_process import run_node


def heard(message: TwistStamped) -> None:
    at_ns = time.monotonic_ns()
    sys.stdout.write(f"{at_ns} {message.twist.linear.x} {message.twist.angular.z}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    run_node("stop_listener", lambda node: node.create_subscription(TwistStamped, "cmd_vel", heard, 100))
