"""What a camera says about itself: believed only where a camera can be like that."""

import math

from sensor_msgs.msg import CameraInfo

from robot_bridge.adapters.ros.convert.rows import IMAGE_SIDE_PX_MAX
from robot_bridge.sensing.sensor_readings import Intrinsics

FOCAL_WIDTHS_MIN, FOCAL_WIDTHS_MAX = 0.1, 20.0
"""Of the picture's width: from a fish-eye of 157 degrees to a telephoto lens of 3."""
PIXEL_RATIO_MAX = 2.0
"""How much longer than wide a pixel may be."""
BINNING_MAX = 16


def intrinsics(message: CameraInfo) -> Intrinsics:
    """Of the pictures that come: K is that of the whole sensor, which binning and a region of interest make smaller."""
    k, frame = [float(value) for value in message.k], message.header.frame_id
    if not frame:
        raise ValueError("it names no frame")
    if not all(map(math.isfinite, k)) or k[0] <= 0.0 or k[4] <= 0.0:
        raise ValueError("its K has no focal length")
    if k[8] != 1.0:
        raise ValueError(f"the last number of its K is {k[8]:g}, not 1")
    x_px, y_px, width_px, height_px = _region(message)
    across, down = _binning(message.binning_x), _binning(message.binning_y)
    seen = Intrinsics(
        frame,
        width_px // across,
        height_px // down,
        k[0] / across,
        k[4] / down,
        (k[2] - x_px) / across,
        (k[5] - y_px) / down,
    )
    if why := _why_no_camera(seen):
        raise ValueError(why)
    return seen


def _region(message: CameraInfo) -> tuple[int, int, int, int]:
    """x, y, width and height of the part of the sensor that is read, px."""
    width_px, height_px, roi = int(message.width), int(message.height), message.roi
    if not (0 < width_px <= IMAGE_SIDE_PX_MAX and 0 < height_px <= IMAGE_SIDE_PX_MAX):
        raise ValueError(f"its size is {width_px} x {height_px} pixels")
    if not roi.width and not roi.height:
        return 0, 0, width_px, height_px
    inside = roi.x_offset + roi.width <= width_px and roi.y_offset + roi.height <= height_px
    if not (inside and roi.width and roi.height):
        raise ValueError("its region of interest is not a part of the picture")
    return int(roi.x_offset), int(roi.y_offset), int(roi.width), int(roi.height)


def _binning(pixels: int) -> int:
    if pixels > BINNING_MAX:
        raise ValueError(f"it puts {pixels} pixels into one")
    return max(1, int(pixels))


def _why_no_camera(camera: Intrinsics) -> str:
    if not (0.0 < camera.cx < camera.width_px and 0.0 < camera.cy < camera.height_px):
        size = f"{camera.width_px} x {camera.height_px}"
        return f"its principal point ({camera.cx:g}, {camera.cy:g}) lies outside of its {size} pixels"
    if not FOCAL_WIDTHS_MIN <= camera.fx / camera.width_px <= FOCAL_WIDTHS_MAX:
        return f"its focal length is {camera.fx:g} pixels, its width {camera.width_px}"
    if not 1.0 / PIXEL_RATIO_MAX <= camera.fx / camera.fy <= PIXEL_RATIO_MAX:
        return f"its focal lengths are {camera.fx:g} and {camera.fy:g} pixels"
    return ""
