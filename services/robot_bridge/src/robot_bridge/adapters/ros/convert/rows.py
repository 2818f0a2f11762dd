"""The rows of a raw picture, as its message says they lie."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Image

IMAGE_SIDE_PX_MAX = 8192


def check_size(width_px: int, height_px: int) -> None:
    """Raises `ValueError` for what no camera sends."""
    if not (0 < width_px <= IMAGE_SIDE_PX_MAX and 0 < height_px <= IMAGE_SIDE_PX_MAX):
        raise ValueError(f"the picture is {width_px} x {height_px} pixels large")


def rows(message: Image, dtype: np.dtype[Any], channels: int, *, rows_a_row: float = 1.0) -> NDArray[Any]:
    """(height * rows_a_row, width, channels), with whatever padding the rows have cut off."""
    check_size(message.width, message.height)
    row_bytes, height = message.width * channels * dtype.itemsize, round(message.height * rows_a_row)
    if message.step < row_bytes:
        raise ValueError(f"its rows are {message.step} bytes long, {message.encoding} needs {row_bytes}")
    if len(message.data) < message.step * height:
        raise ValueError(f"it holds {len(message.data)} bytes, its size needs {message.step * height}")
    packed = np.frombuffer(message.data, dtype=np.uint8, count=message.step * height)
    cut = np.ascontiguousarray(packed.reshape(height, message.step)[:, :row_bytes])
    return cut.view(dtype).reshape(height, message.width, channels)
