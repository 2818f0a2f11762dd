"""The base: odometry, battery, dock, hazards."""

from irobot_create_msgs.msg import DockStatus, HazardDetectionVector
from nav_msgs.msg import Odometry as OdometryMessage
from sensor_msgs.msg import BatteryState

from contracts.geometry import Twist2D
from contracts.motion import Hazard
from contracts.robot import Battery
from robot_bridge.adapters.ros.convert.poses import pose
from robot_bridge.sensing.sensor_readings import DockView, Odometry

HAZARDS = (
    Hazard.BACKUP_LIMIT,
    Hazard.BUMP,
    Hazard.CLIFF,
    Hazard.STALL,
    Hazard.WHEEL_DROP,
    Hazard.OBJECT_PROXIMITY,
)
"""By irobot_create_msgs/HazardDetection's type."""
SPEED_M_S_MAX, TURN_RAD_S_MAX = 2.0, 4.0
SHARE_MAX = 1.02
"""A full battery by rounding."""
PERCENT_MIN, PERCENT_MAX = 2.0, 102.0
"""From here on it is no share that was rounded, and up to here it can be per cent."""


def odometry(message: OdometryMessage, at_s: float) -> Odometry:
    """What no base of this kind drives is a slip of units, not a speed: it is refused, not clamped."""
    linear, angular = message.twist.twist.linear.x, message.twist.twist.angular.z
    if not abs(linear) <= SPEED_M_S_MAX:
        raise ValueError(f"its speed is {linear:g} m/s")
    if not abs(angular) <= TURN_RAD_S_MAX:
        raise ValueError(f"its turn is {angular:g} rad/s")
    return Odometry(at_s, pose(message.pose.pose), Twist2D(linear_x=linear, angular_z=angular))


class BatteryReading:
    """Reads one battery's messages. sensor_msgs counts its charge 0 to 1; some drivers count 0 to 100.

    Once one has been seen to, that is remembered: its 1.0 is one per cent, not all of it.
    """

    def __init__(self) -> None:
        self._counts_to_100 = False

    def read(self, message: BatteryState) -> tuple[Battery, str]:
        """The charge, none where it is not told in a way that can be understood, and what to know of it."""
        charging = charges(message) is True
        sent = message.percentage
        self._counts_to_100 |= PERCENT_MIN <= sent <= PERCENT_MAX
        unfilled = sent == 0.0 and not message.voltage > 0.0
        if unfilled or not (0.0 <= sent <= (PERCENT_MAX if self._counts_to_100 else SHARE_MAX)):
            why = "neither charge nor voltage is filled in" if unfilled else f"it says {sent:g}, not 0 to 1"
            return Battery(percentage=None, charging=charging), f"its charge is not known: {why}"
        note = "it counts its charge 0 to 100, not 0 to 1: read as per cent" if self._counts_to_100 else ""
        percent = sent if self._counts_to_100 else sent * 100.0
        return Battery(percentage=min(percent + 0.0, 100.0), charging=charging), note


def charges(message: BatteryState) -> bool | None:
    """None where it does not tell: a Create 3's simulator leaves the status UNKNOWN, its firmware may."""
    if message.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_UNKNOWN:
        return True if message.current > 0.0 else None
    return bool(message.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_CHARGING)


def dock(message: DockStatus) -> DockView:
    return DockView(is_docked=bool(message.is_docked), dock_visible=bool(message.dock_visible))


def hazards(message: HazardDetectionVector) -> frozenset[Hazard]:
    return frozenset(HAZARDS[each.type] for each in message.detections if each.type < len(HAZARDS))
