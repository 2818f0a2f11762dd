"""When to drive to the dock by itself, and when to refuse a mission for want of power (requirement A15)."""

from dataclasses import dataclass

from contracts.robot import RobotState


@dataclass(frozen=True, slots=True)
class PowerRules:
    low_percent: float
    period_s: float
    again_s: float


@dataclass(frozen=True, slots=True)
class DockingTimer:
    """When the battery was last looked at, and when the dock was last driven to."""

    looked_s: float = float("-inf")
    tried_s: float = float("-inf")


def why_too_low(state: RobotState | None, rules: PowerRules) -> str:
    """Empty when there is enough, when it charges, or when nothing is known of the battery."""
    battery = state.battery if state is not None else None
    if battery is None or battery.charging or battery.percentage is None or battery.percentage >= rules.low_percent:
        return ""
    return f"the battery is at {battery.percentage:.0f} %, below {rules.low_percent:.0f} %"


def reason_to_dock(
    watch: DockingTimer, state: RobotState | None, now_s: float, rules: PowerRules
) -> tuple[DockingTimer, str]:
    """Asked while no mission runs. The reason to drive to the dock now, or an empty one; at most every `period_s`."""
    if now_s - watch.looked_s < rules.period_s:
        return watch, ""
    looked = DockingTimer(now_s, watch.tried_s)
    why = why_too_low(state, rules)
    if not why or state is None or state.docked is not False or now_s - watch.tried_s < rules.again_s:
        return looked, ""
    return DockingTimer(now_s, now_s), why
