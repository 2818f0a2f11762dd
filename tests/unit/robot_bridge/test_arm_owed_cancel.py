"""A cancel is owed until the controller has answered that very one."""

import math

from robot_bridge.arm.owed_cancel import AGAIN_S, OwedCancel


def settled() -> OwedCancel:
    """Of a controller that is there and has answered what was owed at the start."""
    owed = OwedCancel()
    owed.there(True, 0.0)
    number = owed.due(0.0)
    assert number is not None
    owed.answered(number)
    assert not owed.owed
    return owed


def test_it_is_owed_from_the_start_and_asked_once_the_controller_is_there() -> None:
    owed = OwedCancel()
    assert owed.owed
    assert owed.owed_for_s(0.0) == math.inf
    owed.there(False, 0.0)
    assert owed.due(0.0) is None
    owed.there(True, 60.0)
    assert owed.due(60.0) is not None
    assert owed.owed


def test_a_controller_that_does_not_answer_is_asked_again() -> None:
    owed = OwedCancel()
    owed.there(True, 0.0)
    first = owed.due(0.0)
    assert owed.due(0.9 * AGAIN_S) is None
    assert owed.due(AGAIN_S) == first


def test_a_controller_that_has_answered_is_left_alone() -> None:
    assert settled().due(99.0) is None


def test_a_stop_while_the_controller_is_out_of_reach_is_owed_until_it_is_back() -> None:
    owed = settled()
    owed.there(False, 10.0)
    owed.owe(10.0)
    assert owed.due(11.0) is None
    owed.there(True, 300.0)
    assert owed.due(300.0) is not None


def test_a_controller_that_was_away_is_asked_though_nobody_stopped_anything() -> None:
    owed = settled()
    owed.there(False, 10.0)
    assert owed.owed
    assert owed.owed_for_s(12.0) == 2.0
    owed.there(False, 13.0)
    assert owed.owed_for_s(14.0) == 4.0


def test_an_answer_to_an_earlier_stop_does_not_settle_a_later_one() -> None:
    """A goal may have been accepted between the two."""
    owed = settled()
    owed.owe(10.0)
    first = owed.due(10.0)
    owed.owe(10.1)
    second = owed.due(10.1)
    assert first is not None
    assert second is not None
    owed.answered(first)
    assert owed.owed
    owed.answered(second)
    owed.answered(first)
    assert not owed.owed
