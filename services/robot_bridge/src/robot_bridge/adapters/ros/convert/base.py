"""The base: odometry, battery, dock, hazards."""

import math

from irobot_create_msgs.msg import DockStatus, HazardDetectionVector
from nav_msgs.msg import Odometry as OdometryMessage
from sensor_msgs.msg import BatteryState

from contracts.geometry import Twist2D
from contracts.motion import Hazard
from contracts.robot import Battery
from robot_bridge.adapters.ros.convert.poses import pose, stamp_s
from robot_bridge.senses import DockView, Odometry

HAZARDS = (
    Hazard.BACKUP_LIMIT,
    Hazard.BUMP,
    Hazard.CLIFF,
    Hazard.STALL,
    Hazard.WHEEL_DROP,
    Hazard.OBJECT_PROXIMITY,
)
"""By irobot_create_msgs/HazardDetection's type."""


def odometry(message: OdometryMessage) -> Odometry:
    twist = message.twist.twist
    measured = Twist2D(linear_x=min(max(twist.linear.x, -2.0), 2.0), angular_z=min(max(twist.angular.z, -4.0), 4.0))
    return Odometry(stamp_s(message.header.stamp), pose(message.pose.pose), measured)


def battery(message: BatteryState) -> Battery:
    if not math.isfinite(message.percentage):
        raise ValueError("the battery does not tell its charge")
    charging = message.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_CHARGING
    return Battery(percentage=min(max(message.percentage * 100.0, 0.0), 100.0), charging=charging)


def dock(message: DockStatus) -> DockView:
    return DockView(is_docked=bool(message.is_docked), dock_visible=bool(message.dock_visible))


def hazards(message: HazardDetectionVector) -> frozenset[Hazard]:
    return frozenset(HAZARDS[each.type] for each in message.detections if each.type < len(HAZARDS))
