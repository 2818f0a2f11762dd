"""A hazard that was there for a moment counts for a while."""

from contracts.motion import Hazard
from robot_bridge.sensing.sensor_readings import LatestHazards


def test_a_bump_shorter_than_a_tick_is_not_missed() -> None:
    hazards = LatestHazards()
    hazards.put(frozenset({Hazard.BUMP}), 10.0)
    hazards.put(frozenset(), 10.01)
    assert hazards.value == frozenset()
    assert hazards.active(10.5, 1.0) == {Hazard.BUMP}
    assert hazards.active(11.0, 1.0) == {Hazard.BUMP}
    assert hazards.active(11.02, 1.0) == frozenset()


def test_a_hazard_told_once_lasts_until_another_message_says_otherwise() -> None:
    """The base tells of a change only: a wheel that hangs in the air is told of once."""
    hazards = LatestHazards()
    hazards.put(frozenset({Hazard.WHEEL_DROP}), 10.0)
    assert hazards.active(3600.0, 1.0) == {Hazard.WHEEL_DROP}
    hazards.put(frozenset(), 3600.0)
    assert hazards.active(3600.5, 1.0) == {Hazard.WHEEL_DROP}
    assert hazards.active(3601.1, 1.0) == frozenset()


def test_each_hazard_has_its_own_time() -> None:
    hazards = LatestHazards()
    hazards.put(frozenset({Hazard.BUMP}), 10.0)
    hazards.put(frozenset({Hazard.CLIFF}), 10.6)
    assert hazards.active(10.8, 1.0) == {Hazard.BUMP, Hazard.CLIFF}
    assert hazards.active(11.7, 1.0) == {Hazard.CLIFF}
