"""Pictures in colour and in depth."""

from typing import Any

import cv2
import numpy as np
from sensor_msgs.msg import Image

from robot_bridge.adapters.ros.convert.poses import stamp_s
from robot_bridge.senses import ColourImage, DepthImage

IMAGE_SIDE_PX_MAX = 8192


def colour_image(message: Image) -> ColourImage:
    conversions: dict[str, tuple[int, int | None]] = {
        "bgr8": (3, None),
        "rgb8": (3, cv2.COLOR_RGB2BGR),
        "bgra8": (4, cv2.COLOR_BGRA2BGR),
        "rgba8": (4, cv2.COLOR_RGBA2BGR),
        "mono8": (1, cv2.COLOR_GRAY2BGR),
    }
    if message.encoding not in conversions:
        raise ValueError(f"cannot read {message.encoding} as a colour picture")
    channels, conversion = conversions[message.encoding]
    pixels = _rows(message, np.dtype(np.uint8), channels)
    bgr = pixels if conversion is None else cv2.cvtColor(np.ascontiguousarray(pixels), conversion)
    return ColourImage(stamp_s(message.header.stamp), message.header.frame_id, np.asarray(bgr, dtype=np.uint8))


def depth_image(message: Image) -> DepthImage:
    """16UC1 in millimetres or 32FC1 in metres (REP-118)."""
    order = ">" if message.is_bigendian else "<"
    if message.encoding in {"16UC1", "mono16"}:
        metres = _rows(message, np.dtype(f"{order}u2"), 1)[:, :, 0].astype(np.float32) * np.float32(0.001)
    elif message.encoding == "32FC1":
        metres = _rows(message, np.dtype(f"{order}f4"), 1)[:, :, 0].astype(np.float32)
    else:
        raise ValueError(f"cannot read {message.encoding} as depth")
    return DepthImage(stamp_s(message.header.stamp), message.header.frame_id, metres)


def _rows(message: Image, dtype: np.dtype[Any], channels: int) -> "np.ndarray[Any, Any]":
    """(height, width, channels), with whatever padding the rows have cut off."""
    row_bytes = message.width * channels * dtype.itemsize
    if not (0 < message.width <= IMAGE_SIDE_PX_MAX and 0 < message.height <= IMAGE_SIDE_PX_MAX):
        raise ValueError("the image has no size")
    if message.step < row_bytes or len(message.data) < message.step * message.height:
        raise ValueError("the image is shorter than it says")
    rows = np.frombuffer(message.data, dtype=np.uint8, count=message.step * message.height)
    packed = np.ascontiguousarray(rows.reshape(message.height, message.step)[:, :row_bytes])
    return packed.view(dtype).reshape(message.height, message.width, channels)
