"""When it drives to the dock by itself."""

import pytest

from contracts.robot import Battery, EmergencyStop, RobotState
from coordinator.execution.battery_policy import DockingTimer, PowerRules, reason_to_dock, why_too_low

RULES = PowerRules(low_percent=20.0, period_s=30.0, again_s=300.0)


def state(percentage: float | None, *, docked: bool | None = False, charging: bool = False) -> RobotState:
    battery = Battery(percentage=percentage, charging=charging) if percentage is not None else None
    return RobotState(stamp_s=1.0, battery=battery, docked=docked, emergency_stop=EmergencyStop(latched=False, epoch=0))


@pytest.mark.parametrize(
    ("robot", "low"),
    [
        (state(19.9), True),
        (state(20.0), False),
        (state(5.0, charging=True), False),
        (state(None), False),
        (None, False),
    ],
)
def test_a_battery_is_low_below_its_limit_unless_it_charges_or_is_unknown(robot: RobotState | None, low: bool) -> None:
    assert bool(why_too_low(robot, RULES)) is low


def test_it_looks_every_30_s_and_tries_again_only_later() -> None:
    watch, why = reason_to_dock(DockingTimer(), state(10.0), 100.0, RULES)
    assert why
    watch, why = reason_to_dock(watch, state(10.0), 110.0, RULES)
    assert not why
    watch, why = reason_to_dock(watch, state(10.0), 140.0, RULES)
    assert not why
    watch, why = reason_to_dock(watch, state(10.0), 430.0, RULES)
    assert why


@pytest.mark.parametrize("docked", [True, None])
def test_on_its_dock_or_not_knowing_it_does_not_drive_there(docked: bool | None) -> None:
    assert reason_to_dock(DockingTimer(), state(10.0, docked=docked), 100.0, RULES)[1] == ""
