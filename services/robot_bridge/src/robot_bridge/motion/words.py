"""The English for what the bridge tells in types: the one place where it is written."""

import math
from collections.abc import Iterable

from contracts.causes import LimitCause, Refusal, SafetyCause
from contracts.robot import EmergencyStop
from robot_bridge.safety.collision_monitor import Restraint


def restraint_in_words(restraint: Restraint) -> str:
    where = "ahead" if restraint.forward else "behind"
    said: dict[SafetyCause, str] = {
        SafetyCause.BASE_STOPPED: "the base has disabled its wheels",
        SafetyCause.STRANGER: "another node drives the base",
        SafetyCause.WHEEL_DROP: "a wheel hangs in the air",
        SafetyCause.NO_SCAN: "no laser scan",
        SafetyCause.OLD_SCAN: f"the laser scan is {restraint.scan_age_s:.1f} s old",
        SafetyCause.NOT_UNDERSTOOD: f"the laser scan is not understood: {restraint.scan_trouble}",
        SafetyCause.BLIND: f"the laser is blind {where}",
        SafetyCause.NO_ODOMETRY: "no odometry",
        SafetyCause.HAZARD: f"hazard: {', '.join(sorted(restraint.hazards))}",
        SafetyCause.OBSTACLE: f"obstacle {where}{_inside(restraint.inside_rad)}",
        SafetyCause.SLOWED: f"slowed: {restraint.free_m:.2f} m free {where}",
    }
    return said[restraint.cause]


def _inside(bearing_rad: float | None) -> str:
    if bearing_rad is None:
        return ""
    return f": something inside the footprint is seen at {math.degrees(bearing_rad):.0f} degrees"


def causes_in_words(causes: Iterable[Restraint | LimitCause]) -> str:
    return "; ".join(cause.sentence if isinstance(cause, LimitCause) else restraint_in_words(cause) for cause in causes)


def refusal_in_words(refusal: Refusal, stop: EmergencyStop) -> str:
    """`stop` as it stands: it knows the epoch, and the reason it was latched for."""
    match refusal:
        case Refusal.STOPPED:
            return f"the emergency stop is latched ({stop.reason or 'just now'})"
        case Refusal.OLD_EPOCH:
            return f"the epoch is {stop.epoch} now"
        case Refusal.BASE_BUSY:
            return "the base is docking or undocking"
        case Refusal.SESSION_OVER:
            return "the session is unknown or has ended"
        case Refusal.NO_TICK:
            return "the motion loop has stopped"
        case _:
            return refusal.value
