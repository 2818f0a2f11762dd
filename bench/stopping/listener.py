"""Hears `cmd_vel` in a ROS process of its own and writes one line for each: monotonic time in ns, m/s, rad/s."""

import signal
import sys
import threading
import time

import rclpy
from geometry_msgs.msg import TwistStamped
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from mesh.dds import use_mesh_profile


def main() -> None:
    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: ended.set())
    use_mesh_profile()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = Node("stop_listener", enable_rosout=False, start_parameter_services=False)

    def heard(message: TwistStamped) -> None:
        at_ns = time.monotonic_ns()
        sys.stdout.write(f"{at_ns} {message.twist.linear.x} {message.twist.angular.z}\n")
        sys.stdout.flush()

    node.create_subscription(TwistStamped, "cmd_vel", heard, 100)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    while not ended.is_set():
        executor.spin_once(timeout_sec=0.2)
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
