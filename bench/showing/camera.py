"""The standing robot with a camera whose frames are numbered: 16 black or white squares along the top edge.

Writes one line for each frame: its number, and the wall-clock time in ms just before it was published.
"""

import argparse
import array
import signal
import sys
import threading
import time
from typing import Any

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import CameraInfo, Image

from bench.stopping.robot import SIDE_PX, StandingRobot
from mesh.dds import use_mesh_profile

BITS = 16
SQUARE_PX = SIDE_PX // BITS


def marked(picture: np.ndarray, number: int) -> np.ndarray:
    """A copy of the picture (height, width, 3) with the number along its top, lowest bit first."""
    copy = picture.copy()
    for bit in range(BITS):
        copy[:SQUARE_PX, bit * SQUARE_PX : (bit + 1) * SQUARE_PX] = 255 if number >> bit & 1 else 0
    return copy


class NumberedCamera(StandingRobot):
    """Every frame carries its number."""

    def __init__(self, node: Any, camera_hz: float) -> None:
        ramp = np.linspace(0, 255, SIDE_PX, dtype=np.uint8)
        self._picture = np.stack([*np.meshgrid(ramp, ramp), np.full((SIDE_PX, SIDE_PX), 90, np.uint8)], axis=2)
        self._number = 0
        super().__init__(node, camera_hz)

    def _publish_image(self) -> None:
        self._number = (self._number + 1) % 2**BITS
        message = Image(height=SIDE_PX, width=SIDE_PX, encoding="bgr8", step=SIDE_PX * 3)
        message.header.stamp, message.header.frame_id = self._now(), "optical"
        message.data = array.array("B", marked(self._picture, self._number).tobytes())
        info = CameraInfo(width=SIDE_PX, height=SIDE_PX, k=[200.0, 0.0, 125.0, 0.0, 200.0, 125.0, 0.0, 0.0, 1.0])
        info.header = message.header
        sys.stdout.write(f"{self._number} {time.time() * 1000.0}\n")
        sys.stdout.flush()
        self._image.publish(message)
        self._info.publish(info)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--camera-hz", type=float, default=10.0)
    arguments = parser.parse_args()
    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: ended.set())
    use_mesh_profile()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("numbered_camera", enable_rosout=False, start_parameter_services=False)
    robot = NumberedCamera(node, arguments.camera_hz)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    while not ended.is_set():
        executor.spin_once(timeout_sec=0.2)
    del robot
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
