"""ROS messages to the bridge's own values. Every function raises `ValueError` for a message that makes no sense."""

import math
from typing import Any

import cv2
import numpy as np
from geometry_msgs.msg import Pose, PoseStamped, Transform
from irobot_create_msgs.msg import (
    AudioNote,
    AudioNoteVector,
    DockStatus,
    HazardDetectionVector,
    LedColor,
    LightringLeds,
)
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Odometry as OdometryMessage
from sensor_msgs.msg import BatteryState, CameraInfo, Image, LaserScan

from contracts.geometry import Pose2D, Twist2D
from contracts.robot import Battery
from robot_bridge import maps
from robot_bridge.celebration import Celebration
from robot_bridge.senses import ColourImage, DepthImage, DockView, Grid, Hazard, Intrinsics, Odometry, Scan
from robot_bridge.transforms import Matrix, matrix, planar, quaternion_xyzw

HAZARDS = (
    Hazard.BACKUP_LIMIT,
    Hazard.BUMP,
    Hazard.CLIFF,
    Hazard.STALL,
    Hazard.WHEEL_DROP,
    Hazard.OBJECT_PROXIMITY,
)
"""By irobot_create_msgs/HazardDetection's type."""
IMAGE_SIDE_PX_MAX = 8192
BEAMS_MAX = 20_000
BLIND_COSINE = 0.5
LEVEL_COSINE = math.cos(math.radians(2.0))
"""Of the tilt that an origin may have by rounding."""


def stamp_s(stamp: Any) -> float:
    """builtin_interfaces/Time in seconds."""
    return float(stamp.sec) + float(stamp.nanosec) * 1e-9


def pose(message: Pose) -> Pose2D:
    p, q = message.position, message.orientation
    return planar(matrix((p.x, p.y, p.z), (q.x, q.y, q.z, q.w)))


def transform(message: Transform) -> Matrix:
    t, q = message.translation, message.rotation
    return matrix((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))


def odometry(message: OdometryMessage) -> Odometry:
    twist = message.twist.twist
    measured = Twist2D(linear_x=min(max(twist.linear.x, -2.0), 2.0), angular_z=min(max(twist.angular.z, -4.0), 4.0))
    return Odometry(stamp_s(message.header.stamp), pose(message.pose.pose), measured)


def scan(message: LaserScan, laser_in_base: Matrix) -> Scan:
    """Hits as points in base_link; a beam that says neither a range nor 'nothing' (inf) is unknown."""
    ranges = np.asarray(message.ranges, dtype=np.float64)
    if ranges.size == 0 or ranges.size > BEAMS_MAX:
        raise ValueError("no scan has so many beams")
    if not (math.isfinite(message.angle_min) and math.isfinite(message.angle_increment)):
        raise ValueError("the scan's angles are no numbers")
    near, far = message.range_min, message.range_max
    hit = np.isfinite(ranges) & (ranges >= near) & (ranges <= far)
    nothing = (ranges == np.inf) | (np.isfinite(ranges) & (ranges > far))
    angles = message.angle_min + message.angle_increment * np.flatnonzero(hit)
    r = ranges[hit]
    local = np.stack([r * np.cos(angles), r * np.sin(angles), np.zeros_like(r), np.ones_like(r)])
    points = (laser_in_base @ local)[:2].T
    ahead, behind = _known(hit | nothing, message, laser_in_base)
    heading = math.atan2(float(laser_in_base[1, 0]), float(laser_in_base[0, 0]))
    away = message.angle_min + message.angle_increment * np.flatnonzero(nothing) + heading
    open_rad = np.asarray((away + math.pi) % (2.0 * math.pi) - math.pi, dtype=np.float64)
    return Scan(stamp_s(message.header.stamp), np.ascontiguousarray(points), ahead, behind, open_rad)


def _known(said: "np.ndarray[Any, Any]", message: LaserScan, laser_in_base: Matrix) -> tuple[float, float]:
    """Of the beams within 60 degrees of base_link's x axis, and of its opposite: the part that said anything."""
    bearings = message.angle_min + message.angle_increment * np.arange(said.size)
    forward = np.stack([np.cos(bearings), np.sin(bearings)], axis=1) @ laser_in_base[0, :2]
    parts = [said[there] for there in (forward >= BLIND_COSINE, forward <= -BLIND_COSINE)]
    return tuple(float(part.mean()) if part.size else 0.0 for part in parts)  # type: ignore[return-value]


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


def intrinsics(message: CameraInfo) -> Intrinsics:
    k = [float(value) for value in message.k]
    if not all(math.isfinite(value) for value in k) or k[0] <= 0.0 or k[4] <= 0.0:
        raise ValueError("the camera_info has no focal length")
    if not (0 < message.width <= IMAGE_SIDE_PX_MAX and 0 < message.height <= IMAGE_SIDE_PX_MAX):
        raise ValueError("the camera_info has no size")
    return Intrinsics(message.header.frame_id, message.width, message.height, k[0], k[4], k[2], k[5])


def grid(message: OccupancyGrid) -> Grid:
    info = message.info
    p, q = info.origin.position, info.origin.orientation
    try:
        origin = matrix((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))
    except ValueError as error:
        raise ValueError("the map's origin is not a pose: its quaternion is zero or no number") from error
    if origin[2, 2] < LEVEL_COSINE:
        raise ValueError("the map's origin is tilted or upside down: only a map on the level floor can be read")
    return maps.understood(message.data, info.width, info.height, float(info.resolution), planar(origin))


def battery(message: BatteryState) -> Battery:
    if not math.isfinite(message.percentage):
        raise ValueError("the battery does not tell its charge")
    charging = message.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_CHARGING
    return Battery(percentage=min(max(message.percentage * 100.0, 0.0), 100.0), charging=charging)


def dock(message: DockStatus) -> DockView:
    return DockView(is_docked=bool(message.is_docked), dock_visible=bool(message.dock_visible))


def hazards(message: HazardDetectionVector) -> frozenset[Hazard]:
    return frozenset(HAZARDS[each.type] for each in message.detections if each.type < len(HAZARDS))


def pose_stamped(value: Pose2D, frame_id: str) -> PoseStamped:
    """Unstamped: 'the newest transform', whatever the clocks say."""
    message = PoseStamped()
    message.header.frame_id = frame_id
    message.pose.position.x = value.x
    message.pose.position.y = value.y
    q = message.pose.orientation
    q.x, q.y, q.z, q.w = quaternion_xyzw(value.yaw)
    return message


def notes(celebration: Celebration) -> AudioNoteVector:
    message = AudioNoteVector(append=False)
    for note in celebration.notes:
        each = AudioNote(frequency=note.frequency_hz)
        each.max_runtime.sec, each.max_runtime.nanosec = _split(note.duration_s)
        message.notes.append(each)
    return message


def lights(celebration: Celebration) -> LightringLeds:
    red, green, blue = celebration.led_rgb
    return LightringLeds(leds=[LedColor(red=red, green=green, blue=blue) for _ in range(6)], override_system=True)


def _split(seconds: float) -> tuple[int, int]:
    nanoseconds = round(seconds * 1e9)
    return nanoseconds // 1_000_000_000, nanoseconds % 1_000_000_000


def set_duration(message: Any, seconds: float) -> None:
    """Fills a builtin_interfaces/Duration."""
    message.sec, message.nanosec = _split(seconds)


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
