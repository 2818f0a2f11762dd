"""What the safety filter and the closed loops may act on now, out of the senses' newest values."""

from contracts.geometry import Twist2D
from contracts.robot import BaseStopState
from robot_bridge.safety.collision_monitor import SafetyInput, SafetyLimits
from robot_bridge.sensing.blindness import ALL_ROUND
from robot_bridge.sensing.sensor_readings import NO_POINTS, Odometry, SensorReadings


def safety_input(senses: SensorReadings, now_s: float, *, hazard_hold_s: float) -> SafetyInput:
    """Ages are told, never judged, here."""
    scan, odometry = senses.scan.value, senses.odometry.value
    trouble = senses.reception.refused("scan")
    return SafetyInput(
        points_m=scan.points_m if scan is not None else NO_POINTS,
        scan_age_s=senses.scan.age_s(now_s),
        odometry_age_s=senses.odometry.age_s(now_s),
        blind=scan.blind if scan is not None else ALL_ROUND,
        laser_m=scan.laser_m if scan is not None else (0.0, 0.0),
        scan_trouble=trouble.reason if trouble is not None else "",
        measured=odometry.twist if odometry is not None else Twist2D(),
        hazards=senses.hazards.active(now_s, hazard_hold_s),
        base_stopped=senses.base_stop.value is BaseStopState.HELD,
        foreign_velocity_age_s=senses.foreign_velocity.age_s(now_s),
    )


def fresh_odometry(senses: SensorReadings, now_s: float, limits: SafetyLimits) -> Odometry | None:
    """None when it is too old to act on."""
    age_s = senses.odometry.age_s(now_s)
    return senses.odometry.value if age_s is not None and age_s <= limits.odometry_age_s_max else None
