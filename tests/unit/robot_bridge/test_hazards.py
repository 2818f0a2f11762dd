"""A hazard that was there for a moment counts for a while."""

from robot_bridge.senses import Hazard, HazardMailbox


def test_a_bump_shorter_than_a_tick_is_not_missed() -> None:
    hazards = HazardMailbox()
    hazards.put(frozenset({Hazard.BUMP}), 10.0)
    hazards.put(frozenset(), 10.01)
    assert hazards.value == frozenset()
    assert hazards.active(10.5, 1.0) == {Hazard.BUMP}
    assert hazards.active(11.0, 1.0) == {Hazard.BUMP}
    assert hazards.active(11.01, 1.0) == frozenset()


def test_each_hazard_has_its_own_time() -> None:
    hazards = HazardMailbox()
    hazards.put(frozenset({Hazard.BUMP}), 10.0)
    hazards.put(frozenset({Hazard.CLIFF}), 10.6)
    assert hazards.active(10.8, 1.0) == {Hazard.BUMP, Hazard.CLIFF}
    assert hazards.active(11.5, 1.0) == {Hazard.CLIFF}
