"""What a camera says about itself."""

import math

from sensor_msgs.msg import CameraInfo

from robot_bridge.adapters.ros.convert.pictures import IMAGE_SIDE_PX_MAX
from robot_bridge.senses import Intrinsics


def intrinsics(message: CameraInfo) -> Intrinsics:
    k = [float(value) for value in message.k]
    if not all(math.isfinite(value) for value in k) or k[0] <= 0.0 or k[4] <= 0.0:
        raise ValueError("the camera_info has no focal length")
    if not (0 < message.width <= IMAGE_SIDE_PX_MAX and 0 < message.height <= IMAGE_SIDE_PX_MAX):
        raise ValueError("the camera_info has no size")
    return Intrinsics(message.header.frame_id, message.width, message.height, k[0], k[4], k[2], k[5])
