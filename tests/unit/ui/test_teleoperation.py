"""What a held stick means."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from ui.teleoperation import Delay, Stick, twist

UNIT = st.floats(min_value=-1.0, max_value=1.0)


def stick(forward: float, turn: float) -> Stick:
    return Stick(t_ms=0.0, forward=forward, turn=turn)


@given(UNIT, UNIT)
def test_no_stick_asks_for_more_than_its_limits(forward: float, turn: float) -> None:
    asked = twist(stick(forward, turn), speed_m_s=0.25, turn_rad_s=1.2)
    assert -0.125 <= asked.linear_x <= 0.25
    assert abs(asked.angular_z) <= 1.2
    assert asked.linear_x * forward >= 0.0
    assert asked.angular_z * turn >= 0.0


def test_near_the_middle_it_is_let_go() -> None:
    assert stick(0.05, -0.05).let_go
    assert twist(stick(0.05, 0.0), speed_m_s=0.25, turn_rad_s=1.2).linear_x == 0.0
    assert not stick(0.0, 0.5).let_go


@pytest.mark.parametrize("value", [math.nan, math.inf, 1.5, -2.0])
def test_a_stick_beyond_its_reach_is_refused(value: float) -> None:
    with pytest.raises(ValidationError):
        Stick(t_ms=0.0, forward=value, turn=0.0)


def test_a_word_that_waited_in_the_network_is_known_by_its_delay() -> None:
    delay = Delay()
    assert delay.of(1000.0, 50.00) == 0.0
    assert delay.of(1100.0, 50.12) == pytest.approx(0.02)
    assert delay.of(1200.0, 51.20) == pytest.approx(1.0)
    assert delay.of(1300.0, 50.31) == pytest.approx(0.01)
