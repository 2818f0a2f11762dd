"""ROS messages to the bridge's own values. Every function raises `ValueError` for a message that makes no sense."""

from robot_bridge.adapters.ros.convert.base import BatteryReading, charges, dock, hazards, odometry
from robot_bridge.adapters.ros.convert.camera_info import intrinsics
from robot_bridge.adapters.ros.convert.grid import grid
from robot_bridge.adapters.ros.convert.laser import scan
from robot_bridge.adapters.ros.convert.outgoing import lights, notes, set_duration
from robot_bridge.adapters.ros.convert.pictures import colour_image, depth_image
from robot_bridge.adapters.ros.convert.poses import initial_pose, localisation, pose, pose_stamped, stamp_s, transform

__all__ = [
    "BatteryReading",
    "charges",
    "colour_image",
    "depth_image",
    "dock",
    "grid",
    "hazards",
    "initial_pose",
    "intrinsics",
    "lights",
    "localisation",
    "notes",
    "odometry",
    "pose",
    "pose_stamped",
    "scan",
    "set_duration",
    "stamp_s",
    "transform",
]
