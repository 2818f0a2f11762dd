"""Is the battery being charged? By its status, else by its current, else by the dock."""

import math

import pytest
from sensor_msgs.msg import BatteryState

from contracts.robot import Battery
from robot_bridge.adapters.ros import convert
from robot_bridge.sensing.sensor_readings import DockView, SensorReadings
from robot_bridge.sensing.snapshot import charge

UNKNOWN = BatteryState.POWER_SUPPLY_STATUS_UNKNOWN
CHARGING = BatteryState.POWER_SUPPLY_STATUS_CHARGING
DISCHARGING = BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
NOT_CHARGING = BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING
FULL = BatteryState.POWER_SUPPLY_STATUS_FULL


@pytest.mark.parametrize(
    ("status", "current_a", "docked", "charging"),
    [
        (CHARGING, 0.0, False, True),
        (CHARGING, -1.0, False, True),
        (DISCHARGING, 1.0, True, False),
        (NOT_CHARGING, 0.0, True, False),
        (FULL, 0.0, True, False),
        (UNKNOWN, 0.8, False, True),
        (UNKNOWN, -0.8, False, False),
        (UNKNOWN, 0.0, False, False),
        (UNKNOWN, math.nan, False, False),
        (UNKNOWN, -0.8, True, True),
        (UNKNOWN, math.nan, True, True),
        (UNKNOWN, 0.0, None, False),
    ],
)
def test_the_battery_is_charged_by_its_status_its_current_or_on_the_dock(
    status: int, current_a: float, docked: bool | None, charging: bool
) -> None:
    message = BatteryState(power_supply_status=status, current=current_a, percentage=0.5, voltage=14.0)
    senses = SensorReadings()
    senses.charging_told.put(convert.charges(message) is not None, 1.0)
    if docked is not None:
        senses.dock.put(DockView(is_docked=docked), 1.0)
    battery, _ = convert.BatteryReading().read(message)
    assert charge(senses, battery) == Battery(percentage=50.0, charging=charging)
