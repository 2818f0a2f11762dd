"""What the simulated robot measures, as ROS messages (REP-103 axes, REP-105 frames)."""

import array
from collections.abc import Iterable

import numpy as np
from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Pose, PoseStamped, PoseWithCovarianceStamped, Transform, TransformStamped
from irobot_create_msgs.msg import DockStatus, HazardDetection, HazardDetectionVector, WheelStatus
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from numpy.typing import NDArray
from sensor_msgs.msg import BatteryState, CameraInfo, Image, Imu, LaserScan
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from contracts.geometry import Pose2D, Twist2D
from geometry.poses import quaternion_xyzw, yaw_of
from sim import world

MAP, ODOM, BASE, LASER = "map", "odom", "base_link", "rplidar_link"
RGB_OPTICAL = "oakd_rgb_camera_optical_frame"
STEREO_OPTICAL = "oakd_stereo_camera_optical_frame"
CHARGE_A, DRAIN_A = 1.0, 0.8
_OPTICAL_QUATERNION = (-0.5, 0.5, -0.5, 0.5)


def stamp(stamp_ns: int) -> Time:
    return Time(sec=stamp_ns // 1_000_000_000, nanosec=stamp_ns % 1_000_000_000)


def header(frame_id: str, stamp_ns: int) -> Header:
    return Header(frame_id=frame_id, stamp=stamp(stamp_ns))


def duration(seconds: float) -> Duration:
    return Duration(sec=int(seconds), nanosec=int((seconds % 1.0) * 1e9))


def seconds(of: Duration) -> float:
    return of.sec + of.nanosec * 1e-9


def rgb_image(rgb: NDArray[np.uint8], stamp_ns: int) -> Image:
    """`rgb` is (H, W, 3)."""
    return _image(rgb, "rgb8", RGB_OPTICAL, stamp_ns)


def depth_image(depth_m: NDArray[np.float32], stamp_ns: int) -> Image:
    """`depth_m` is (H, W) along the optical axis, 0 where nothing was measured; sent as whole millimetres."""
    millimetres = np.clip(np.rint(depth_m * 1000.0), 0, 65535).astype("<u2")
    return _image(millimetres, "16UC1", STEREO_OPTICAL, stamp_ns)


def _image(pixels: NDArray[np.generic], encoding: str, frame_id: str, stamp_ns: int) -> Image:
    height, width = pixels.shape[:2]
    data = array.array("B", pixels.tobytes())
    return Image(
        header=header(frame_id, stamp_ns),
        width=width,
        height=height,
        encoding=encoding,
        step=len(data) // height,
        data=data,
    )


def camera_info(camera: world.CameraModel, frame_id: str, stamp_ns: int) -> CameraInfo:
    fx, fy, cx, cy = camera.fx, camera.fy, camera.cx, camera.cy
    return CameraInfo(
        header=header(frame_id, stamp_ns),
        width=camera.width_px,
        height=camera.height_px,
        distortion_model="plumb_bob",
        d=[0.0] * 5,
        k=[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        r=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p=[fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    )


def laser_scan(scan: world.Scan, period_s: float, stamp_ns: int) -> LaserScan:
    rays = len(scan.ranges_m)
    return LaserScan(
        header=header(LASER, stamp_ns),
        angle_min=scan.angle_min,
        angle_max=scan.angle_min + scan.angle_increment * (rays - 1),
        angle_increment=scan.angle_increment,
        scan_time=period_s,
        time_increment=period_s / rays,
        range_min=scan.range_min_m,
        range_max=scan.range_max_m,
        ranges=array.array("f", scan.ranges_m.astype(np.float32).tobytes()),
    )


def odometry(measured: world.Odometry, stamp_ns: int) -> Odometry:
    message = Odometry(header=header(ODOM, stamp_ns), child_frame_id=BASE)
    message.pose.pose = pose(measured.pose)
    message.twist.twist.linear.x = measured.twist.linear_x
    message.twist.twist.angular.z = measured.twist.angular_z
    return message


def imu(measured: world.Imu, stamp_ns: int) -> Imu:
    message = Imu(header=header(BASE, stamp_ns))
    _, _, message.orientation.z, message.orientation.w = quaternion_xyzw(measured.yaw)
    rates, forces = message.angular_velocity, message.linear_acceleration
    rates.x, rates.y, rates.z = map(float, measured.angular_velocity)
    forces.x, forces.y, forces.z = map(float, measured.linear_acceleration)
    return message


def amcl_pose(estimate: world.PoseEstimate, stamp_ns: int) -> PoseWithCovarianceStamped:
    message = PoseWithCovarianceStamped(header=header(MAP, stamp_ns))
    message.pose.pose = pose(estimate.pose)
    message.pose.covariance = estimate.covariance
    return message


def occupancy_grid(recorded: world.OccupancyGrid, stamp_ns: int) -> OccupancyGrid:
    message = OccupancyGrid(header=header(MAP, stamp_ns))
    message.info.map_load_time = stamp(stamp_ns)
    message.info.resolution = recorded.resolution_m
    message.info.height, message.info.width = recorded.data.shape
    message.info.origin.position.x = recorded.origin_x_m
    message.info.origin.position.y = recorded.origin_y_m
    message.info.origin.orientation.w = 1.0
    message.data = array.array("b", recorded.data.astype(np.int8).tobytes())
    return message


def battery(measured: world.Battery, stamp_ns: int) -> BatteryState:
    """`percentage` is 0 to 1, as sensor_msgs says; the status is not filled in, as by create3_sim."""
    return BatteryState(
        header=header(BASE, stamp_ns),
        voltage=measured.voltage_v,
        percentage=measured.percentage / 100.0,
        present=True,
        current=CHARGE_A if measured.charging else -DRAIN_A,
        power_supply_status=BatteryState.POWER_SUPPLY_STATUS_UNKNOWN,
        power_supply_technology=BatteryState.POWER_SUPPLY_TECHNOLOGY_LION,
    )


def dock_status(measured: world.DockStatus, stamp_ns: int) -> DockStatus:
    return DockStatus(header=header(BASE, stamp_ns), dock_visible=measured.dock_visible, is_docked=measured.is_docked)


def hazards(found: Iterable[world.Hazard], stamp_ns: int) -> HazardDetectionVector:
    head = header(BASE, stamp_ns)
    return HazardDetectionVector(
        header=head, detections=[HazardDetection(header=head, type=int(hazard)) for hazard in found]
    )


def wheel_status(stamp_ns: int, *, enabled: bool) -> WheelStatus:
    return WheelStatus(header=header(BASE, stamp_ns), wheels_enabled=enabled)


def correction(map_to_odom: Pose2D, stamp_ns: int) -> TFMessage:
    """The localiser's part of tf."""
    return TFMessage(transforms=[_planar_transform(MAP, ODOM, map_to_odom, stamp_ns)])


def odometry_frame(odom_to_base: Pose2D, stamp_ns: int) -> TFMessage:
    """The base's part of tf."""
    return TFMessage(transforms=[_planar_transform(ODOM, BASE, odom_to_base, stamp_ns)])


def fixed_frames(
    rgb: world.CameraModel, depth: world.CameraModel, laser: Pose2D, laser_z_m: float, stamp_ns: int
) -> TFMessage:
    """Where the sensors sit on base_link; optical frames look along z, with x to the right and y down (REP-103)."""
    return TFMessage(
        transforms=[
            _transform(BASE, LASER, (laser.x, laser.y, laser_z_m), quaternion_xyzw(laser.yaw), stamp_ns),
            _transform(BASE, RGB_OPTICAL, (rgb.x_m, 0.0, rgb.z_m), _OPTICAL_QUATERNION, stamp_ns),
            _transform(BASE, STEREO_OPTICAL, (depth.x_m, 0.0, depth.z_m), _OPTICAL_QUATERNION, stamp_ns),
        ]
    )


def _planar_transform(parent: str, child: str, at: Pose2D, stamp_ns: int) -> TransformStamped:
    return _transform(parent, child, (at.x, at.y, 0.0), quaternion_xyzw(at.yaw), stamp_ns)


def _transform(
    parent: str,
    child: str,
    translation: tuple[float, float, float],
    quaternion: tuple[float, float, float, float],
    stamp_ns: int,
) -> TransformStamped:
    moved = Transform()
    moved.translation.x, moved.translation.y, moved.translation.z = translation
    turned = moved.rotation
    turned.x, turned.y, turned.z, turned.w = quaternion
    return TransformStamped(header=header(parent, stamp_ns), child_frame_id=child, transform=moved)


def pose(of: Pose2D) -> Pose:
    message = Pose()
    message.position.x, message.position.y = of.x, of.y
    _, _, message.orientation.z, message.orientation.w = quaternion_xyzw(of.yaw)
    return message


def pose_stamped(of: Pose2D, stamp_ns: int) -> PoseStamped:
    return PoseStamped(header=header(MAP, stamp_ns), pose=pose(of))


def path(poses: Iterable[Pose2D], stamp_ns: int) -> Path:
    return Path(header=header(MAP, stamp_ns), poses=[pose_stamped(p, stamp_ns) for p in poses])


def pose2d(message: Pose) -> Pose2D:
    """Position and yaw of a pose. Raises ValueError (a pydantic one) for coordinates that are no numbers."""
    q = message.orientation
    return Pose2D(x=message.position.x, y=message.position.y, yaw=yaw_of(q.x, q.y, q.z, q.w))


def twist2d(linear_x: float, angular_z: float) -> Twist2D | None:
    """None for what is not a velocity (NaN, or faster than anything here can go)."""
    if not (abs(linear_x) <= 2.0 and abs(angular_z) <= 4.0):
        return None
    return Twist2D(linear_x=linear_x, angular_z=angular_z)
