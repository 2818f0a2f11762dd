"""Every cell of docs/sensors.md is true, and the page holds every cell."""

import math

import pytest
from sensor_msgs.msg import LaserScan

from contracts.geometry import Twist2D
from robot_bridge.motion.words import restraint_in_words
from robot_bridge.safety.collision_monitor import SafetyLimits, apply_safety
from robot_bridge.safety.safety_input import safety_input
from support.ros_messages import BEAMS, battery, round_room, stamp, still_odometry, transform
from support.sensor_rules import PAGE, PERIOD_S, Bench, Cell, Table, page
from support.sensor_tables import TABLES

CELLS = [
    pytest.param(table, cell, id=f"{table.message}: {cell.field}: {cell.case}{' ' * bool(cell.settings)}")
    for table in TABLES
    for cell in table.cells
]


@pytest.mark.parametrize(("table", "cell"), CELLS)
def test_a_field_that_makes_no_sense_is_never_believed_and_its_reason_is_told(table: Table, cell: Cell) -> None:
    assert table.see(cell) == cell.told


@pytest.mark.parametrize("range_max", [0.0, 0.2, math.nan])
@pytest.mark.parametrize("before", [0, 1], ids=["from the first", "after a good one"])
def test_a_wall_seen_by_a_laser_whose_limits_make_no_sense_is_never_driven_at(range_max: float, before: int) -> None:
    """A wall 3 cm from the footprint; the driver leaves range_max at 0 (Slamtec/rplidar_ros, issue 71)."""
    bench = Bench()
    bench.body(but="scan")
    spoilt = wall_ahead()
    spoilt.range_max = range_max
    for message in [round_room()] * before + [spoilt] * 8:
        bench.clock.now += PERIOD_S
        message.header.stamp = stamp(bench.clock.now_s())
        bench.send("odom", still_odometry(bench.clock.now_s()))
        bench.send("scan", message)
    around = safety_input(bench.senses, bench.clock.now_s(), hazard_hold_s=1.0)
    left, restraint = apply_safety(Twist2D(linear_x=0.2), around, SafetyLimits())
    assert left.linear_x == 0.0
    assert restraint is not None
    assert restraint_in_words(restraint) == f"the laser scan is not understood: its range_max is {range_max:g} m"


def wall_ahead() -> LaserScan:
    message = round_room()
    message.ranges = [0.22 if 30 < beam < 42 else 3.0 for beam in range(BEAMS)]
    return message


def test_one_transform_that_makes_no_sense_does_not_cost_the_others_in_its_message() -> None:
    bench = Bench()
    message = transform("base_link", "laser")
    bad = transform("base_link", "arm").transforms[0]
    bad.transform.rotation.w = math.nan
    itself = transform("arm", "arm").transforms[0]
    message.transforms = [bad, itself, *message.transforms]
    bench.send("tf_static", message)
    assert bench.senses.frames.in_base("laser") is not None
    refused = bench.senses.reception.refused("tf")
    assert refused is not None
    assert refused.reason == "the frame arm is given in itself"


def test_a_battery_that_counts_to_100_has_one_per_cent_left_at_1() -> None:
    bench = Bench()
    for percentage, known in ((0.9, 90.0), (37.0, 37.0), (1.0, 1.0), (0.5, 0.5)):
        message = battery()
        message.percentage = percentage
        bench.send("battery", message)
        value = bench.senses.battery.value
        assert value is not None
        assert value.percentage == pytest.approx(known)


def test_the_page_tells_every_cell() -> None:
    """To write it anew: PYTHONPATH=tests .venv/bin/python -m support.sensor_tables"""
    text = PAGE.read_text(encoding="utf-8")
    assert text == page(text, TABLES)
