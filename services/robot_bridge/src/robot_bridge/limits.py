"""The limits of each part, out of the settings."""

from contracts.motion import MotionGains
from robot_bridge.motion.arbiter import Limits
from robot_bridge.safety.collision_monitor import SafetyLimits
from robot_bridge.safety.gaps import GapLimits
from robot_bridge.safety.obstacles import ObstacleLimits
from robot_bridge.sensing.laser_rules import LaserRules, ZeroRange
from robot_bridge.settings import Settings


def safety_limits(settings: Settings) -> SafetyLimits:
    return SafetyLimits(
        footprint_radius_m=settings.footprint_radius_m,
        side_margin_m=settings.side_margin_m,
        stop_distance_m=settings.stop_distance_m,
        slow_distance_m=settings.slow_distance_m,
        slow_factor_min=settings.slow_factor_min,
        scan_age_s_max=settings.scan_age_s_max,
        scan_age_to_turn_s_max=settings.scan_age_to_turn_s_max,
        odometry_age_s_max=settings.odometry_age_s_max,
    )


def laser_rules(settings: Settings) -> LaserRules:
    return LaserRules(
        zero_means_nothing=settings.laser_zero_means is ZeroRange.NOTHING_THERE,
        masks=settings.laser_masks,
        footprint_radius_m=settings.footprint_radius_m,
    )


def obstacle_limits(settings: Settings) -> ObstacleLimits:
    return ObstacleLimits(
        wall_m=settings.sector_wall_m,
        obstacle_m=settings.sector_obstacle_m,
        near_m=settings.sector_near_m,
        gaps=GapLimits(width_m_min=settings.gap_width_m_min, width_m_max=settings.gap_width_m_max),
    )


def arbiter_limits(settings: Settings) -> Limits:
    return Limits(
        speed_m_s_max=settings.speed_m_s_max,
        turn_rad_s_max=settings.turn_rad_s_max,
        acceleration_m_s2_max=settings.acceleration_m_s2_max,
        turn_acceleration_rad_s2_max=settings.turn_acceleration_rad_s2_max,
        request_age_s_max=settings.request_age_s_max,
        request_ahead_s_max=settings.request_ahead_s_max,
    )


def motion_gains(settings: Settings) -> MotionGains:
    """What closed-loop motions start with; `PUT /motion/gains` changes them until the process ends."""
    return MotionGains(
        heading_kp=settings.heading_kp,
        heading_ki=settings.heading_ki,
        heading_kd=settings.heading_kd,
        drive_kp=settings.drive_kp,
        drive_ki=settings.drive_ki,
        drive_kd=settings.drive_kd,
        turn_tolerance_rad=settings.turn_tolerance_rad,
        drive_tolerance_m=settings.drive_tolerance_m,
        turn_rad_s_min=settings.turn_rad_s_min,
        drive_m_s_min=settings.drive_m_s_min,
        blocked_s_max=settings.blocked_s_max,
    )
