"""What `/ready` says of the base: a warning where it works and a person should know something."""

import pytest

from contracts.problem import DependencyState
from contracts.robot import BaseStopState
from robot_bridge.sensing import health
from robot_bridge.sensing.sensor_readings import Hazard, SensorReadings
from robot_bridge.settings import Settings

KNOWN = Settings().ros.cmd_vel_known


def test_the_table_names_every_state_of_the_bases_stop() -> None:
    assert set(health.BASE_STOP) == set(BaseStopState)


@pytest.mark.parametrize(
    ("state", "told"),
    [
        (None, DependencyState.READY),
        (BaseStopState.ENGAGED, DependencyState.READY),
        (BaseStopState.UNCONFIRMED, DependencyState.WARNING),
        (BaseStopState.MISSING, DependencyState.WARNING),
        (BaseStopState.HELD, DependencyState.NOT_READY),
    ],
)
def test_a_stop_that_is_not_as_wanted_is_told(state: BaseStopState | None, told: DependencyState) -> None:
    senses = SensorReadings()
    if state is not None:
        senses.base_stop.put(state, 1.0)
    assert health.base_stop(senses).state is told


def test_hazards_that_nobody_publishes_are_a_warning_that_names_the_line_to_uncomment() -> None:
    senses = SensorReadings()
    senses.hazards_offered.put(False, 1.0)
    told = health.hazards(senses)
    assert told.state is DependencyState.WARNING
    assert "hazard_detection" in told.detail


def test_hazards_that_are_offered_and_never_came_are_none() -> None:
    senses = SensorReadings()
    senses.hazards_offered.put(True, 1.0)
    assert health.hazards(senses).state is DependencyState.READY


def test_hazards_that_came_once_are_received_whoever_publishes_now() -> None:
    senses = SensorReadings()
    senses.hazards.put(frozenset({Hazard.BUMP}), 1.0)
    senses.hazards_offered.put(False, 2.0)
    assert health.hazards(senses).state is DependencyState.READY


def driven(*others: str, heard_s: float | None = None) -> SensorReadings:
    senses = SensorReadings()
    senses.other_drivers.put(others, 10.0)
    if heard_s is not None:
        senses.foreign_velocity.put((0.2, 0.0), heard_s)
    return senses


@pytest.mark.parametrize(
    ("senses", "state", "words"),
    [
        (SensorReadings(), DependencyState.READY, "this bridge drives the base"),
        (driven(), DependencyState.READY, "this bridge drives the base"),
        (driven("docking_server", "teleop_twist_joy_node"), DependencyState.READY, "docking_server"),
        (driven("docking_server", "teleop_keyboard"), DependencyState.WARNING, "teleop_keyboard can drive"),
        (driven("robot_bridge"), DependencyState.WARNING, "robot_bridge can drive"),
        (driven("docking_server", heard_s=9.0), DependencyState.NOT_READY, "0.20 m/s"),
        (driven(heard_s=9.0), DependencyState.NOT_READY, "nobody who is there now"),
        (driven("docking_server", heard_s=1.0), DependencyState.READY, "docking_server"),
    ],
)
def test_whoever_can_drive_the_base_past_the_bridge_is_named(
    senses: SensorReadings, state: DependencyState, words: str
) -> None:
    told = health.drivers(senses, KNOWN, 10.0)
    assert told.state is state
    assert words in told.detail
