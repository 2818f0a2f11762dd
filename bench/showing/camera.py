"""The standing robot with a camera whose frames are numbered: 16 black or white squares along the top edge.

Writes one line for each frame: its number, and the wall-clock time in ms just before it was published.
"""

import array
import sys
import time
from typing import Any

import numpy as np

from bench.stopping.robot import SIDE_PX, StandingRobot, run

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

    def _pixels(self) -> "array.array[int]":
        self._number = (self._number + 1) % 2**BITS
        pixels = array.array("B", marked(self._picture, self._number).tobytes())
        sys.stdout.write(f"{self._number} {time.time() * 1000.0}\n")
        sys.stdout.flush()
        return pixels


if __name__ == "__main__":
    run(NumberedCamera, "numbered_camera", __doc__)
