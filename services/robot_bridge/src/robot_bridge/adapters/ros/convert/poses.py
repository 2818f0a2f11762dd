"""Stamps, poses and transforms."""

from typing import Any

from geometry_msgs.msg import Pose, PoseStamped, Transform

from contracts.geometry import Pose2D
from robot_bridge.transforms import Matrix, matrix, planar, quaternion_xyzw


def stamp_s(stamp: Any) -> float:
    """builtin_interfaces/Time in seconds."""
    return float(stamp.sec) + float(stamp.nanosec) * 1e-9


def pose(message: Pose) -> Pose2D:
    p, q = message.position, message.orientation
    return planar(matrix((p.x, p.y, p.z), (q.x, q.y, q.z, q.w)))


def transform(message: Transform) -> Matrix:
    t, q = message.translation, message.rotation
    return matrix((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))


def pose_stamped(value: Pose2D, frame_id: str) -> PoseStamped:
    """Unstamped: 'the newest transform', whatever the clocks say."""
    message = PoseStamped()
    message.header.frame_id = frame_id
    message.pose.position.x = value.x
    message.pose.position.y = value.y
    q = message.pose.orientation
    q.x, q.y, q.z, q.w = quaternion_xyzw(value.yaw)
    return message
