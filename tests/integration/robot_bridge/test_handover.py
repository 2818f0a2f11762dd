"""What asyncio hands to the robot's thread."""

import rclpy
from rclpy.executors import SingleThreadedExecutor

from robot_bridge.adapters.ros.calls import Handover


def test_a_busy_thread_does_what_it_was_handed_in_that_order(ros_domain: int) -> None:
    """A stop and the reset after it, say: the other way round the base stays stopped, or is let go while latched."""
    context, done = rclpy.Context(), list[str]()
    rclpy.init(context=context)
    executor = SingleThreadedExecutor(context=context)
    handover = Handover(executor)
    for name in ("stop", "reset", "stop again"):
        handover.put(lambda name=name: done.append(name))
    for _ in range(3):
        executor.spin_once(timeout_sec=1.0)
    executor.shutdown()
    context.try_shutdown()
    context.destroy()
    assert done == ["stop", "reset", "stop again"]
