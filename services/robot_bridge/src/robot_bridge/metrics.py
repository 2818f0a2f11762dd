"""What the bridge tells Prometheus of the robot as it is at a scrape. What is counted stands where it happens."""

import math

from prometheus_client import Gauge

from robot_bridge.bridge import Bridge

SENSOR_AGE = Gauge("robot_bridge_sensor_age_seconds", "since the newest value; NaN = never received", ["sensor"])
STOPPED = Gauge("robot_bridge_emergency_stop_latched", "1 while the emergency stop holds the robot")
BATTERY = Gauge("robot_bridge_battery_ratio", "charge, 0 to 1; NaN = the base does not tell")
DOCKED = Gauge("robot_bridge_docked", "1 while the base says that it is on its dock")


def measure(bridge: Bridge) -> None:
    now = bridge.snapshot()
    for name, status in now.sensors.items():
        SENSOR_AGE.labels(name).set(math.nan if status.age_s is None else status.age_s)
    charge = now.battery.percentage if now.battery is not None else None
    BATTERY.set(math.nan if charge is None else charge / 100.0)
    DOCKED.set(now.dock is not None and now.dock.is_docked)
    STOPPED.set(bridge.wheels.stop_state.latched)
