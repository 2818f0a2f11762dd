"""A ROS node in a process of its own, until SIGTERM."""

import signal
import threading
from collections.abc import Callable

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from mesh.dds import use_mesh_profile


def run_node(name: str, make: Callable[[Node], object]) -> None:
    """`make` gives the node its publishers, subscriptions and timers; what it returns is kept."""
    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: ended.set())
    use_mesh_profile()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = Node(name, enable_rosout=False, start_parameter_services=False)
    kept = make(node)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    while not ended.is_set():
        executor.spin_once(timeout_sec=0.2)
    del kept
    node.destroy_node()
    rclpy.try_shutdown()
