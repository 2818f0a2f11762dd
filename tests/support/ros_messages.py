"""Healthy messages of a small robot, to be spoilt one field at a time."""

import math
from typing import Any

import cv2
import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from numpy.typing import NDArray
from sensor_msgs.msg import BatteryState, CameraInfo, CompressedImage, Image, LaserScan
from tf2_msgs.msg import TFMessage

from support.toy_robot import CAMERA_X_M, CAMERA_Z_M, OPTICAL_XYZW

BEAMS = 72


def stamp(seconds: float) -> Time:
    whole = math.floor(seconds)
    return Time(sec=whole, nanosec=round((seconds - whole) * 1e9) % 1_000_000_000)


def turned(message: TransformStamped, xyzw: tuple[float, float, float, float]) -> TransformStamped:
    q = message.transform.rotation
    q.x, q.y, q.z, q.w = xyzw
    return message


def transform(parent: str, child: str, at_s: float = 0.0) -> TFMessage:
    """One transform: the child lies in its parent's place."""
    one = TransformStamped(child_frame_id=child)
    one.header.frame_id, one.header.stamp = parent, stamp(at_s)
    return TFMessage(transforms=[turned(one, (0.0, 0.0, 0.0, 1.0))])


def mount(frame: str) -> TFMessage:
    """Where the laser, or the camera, sits on the robot."""
    message = transform("base_link", frame)
    if frame == "optical":
        mounted = next(iter(message.transforms))
        turned(mounted, OPTICAL_XYZW)
        place = mounted.transform.translation
        place.x, place.z = CAMERA_X_M, CAMERA_Z_M
    return message


def correction(at_s: float) -> TFMessage:
    return transform("map", "odom", at_s)


def still_odometry(at_s: float = 0.0) -> Odometry:
    message = Odometry(child_frame_id="base_link")
    message.header.frame_id, message.header.stamp = "odom", stamp(at_s)
    message.pose.pose.orientation.w = 1.0
    return message


def round_room(radius_m: float = 3.0, beams: int = BEAMS) -> LaserScan:
    step = math.tau / beams
    message = LaserScan(angle_min=-math.pi, angle_max=math.pi - step, angle_increment=step)
    message.header.frame_id = "laser"
    message.range_min, message.range_max = 0.15, 12.0
    message.scan_time, message.time_increment = 0.1, 0.1 / beams
    message.ranges = [radius_m] * beams
    return message


def localised() -> PoseWithCovarianceStamped:
    message = PoseWithCovarianceStamped()
    message.header.frame_id = "map"
    message.pose.pose.orientation.w = 1.0
    return message


def picture(encoding: str = "bgr8", data: NDArray[Any] | None = None, *, width: int = 64, height: int = 48) -> Image:
    """`data` holds the rows as they lie, (rows, bytes or values a row); plain bgr8 otherwise."""
    rows = data if data is not None else np.full((height, width * 3), 90, np.uint8)
    message = Image(encoding=encoding, width=width, height=height, step=rows.shape[1] * rows.itemsize)
    message.header.frame_id = "optical"
    message.data = rows.tobytes()
    return message


def depth(metres: float = 1.5, *, encoding: str = "16UC1") -> Image:
    kind, unit = {"16UC1": ("<u2", 1000.0), "32FC1": ("<f4", 1.0), "64FC1": ("<f8", 1.0)}[encoding]
    return picture(encoding, np.full((48, 64), metres * unit, kind))


def compressed(format_: str, pixels: NDArray[Any], *, suffix: str, head: bytes = b"") -> CompressedImage:
    message = CompressedImage(format=format_)
    message.header.frame_id = "optical"
    message.data = head + cv2.imencode(suffix, pixels)[1].tobytes()
    return message


def camera_info() -> CameraInfo:
    message = CameraInfo(width=64, height=48)
    message.header.frame_id = "optical"
    message.k = [50.0, 0.0, 32.0, 0.0, 50.0, 24.0, 0.0, 0.0, 1.0]
    return message


def battery() -> BatteryState:
    return BatteryState(percentage=0.8, voltage=14.4)


def room_map() -> OccupancyGrid:
    message = OccupancyGrid()
    message.header.frame_id = "map"
    message.info.width, message.info.height, message.info.resolution = 40, 30, 0.05
    message.info.origin.orientation.w = 1.0
    message.data = [0] * 1200
    return message
