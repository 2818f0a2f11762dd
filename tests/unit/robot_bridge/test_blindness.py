"""Where something could stand that the laser does not see."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from robot_bridge.sensing.blindness import THING_M, arcs_of, hiding_places

BODY_M, REACH_M = 0.21, 0.6
beams = st.lists(st.booleans(), min_size=8, max_size=200).map(np.array)


def width_rad(unknown: "np.ndarray[object, np.dtype[np.bool_]]", first_rad: float, step_rad: float) -> float:
    return float(arcs_of(unknown, first_rad, step_rad)[:, 1].sum())


@given(beams, st.floats(-4.0, 4.0), st.sampled_from([1.0, -1.0]))
def test_the_arcs_are_as_wide_as_the_unknown_beams_and_lie_where_they_look(
    unknown: "np.ndarray[object, np.dtype[np.bool_]]", first_rad: float, side: float
) -> None:
    step_rad = side * math.tau / unknown.size
    arcs = arcs_of(unknown, first_rad, step_rad)
    assert float(arcs[:, 1].sum()) == pytest.approx(unknown.sum() * abs(step_rad))
    for beam, is_unknown in enumerate(unknown):
        bearing = first_rad + beam * step_rad
        inside = any((bearing - begin) % math.tau < width for begin, width in arcs)
        assert inside == bool(is_unknown)


def test_what_a_laser_does_not_reach_is_unknown() -> None:
    half = np.zeros(180, np.bool_)
    assert width_rad(half, -math.pi / 2, math.pi / 180) == pytest.approx(math.pi)
    assert width_rad(half, math.pi / 2, -math.pi / 180) == pytest.approx(math.pi)
    both_ends = np.zeros(361, np.bool_)  # the last beam looks where the first does
    assert width_rad(both_ends, -math.pi, math.tau / 360) == 0.0


@given(
    st.floats(-math.pi, math.pi),
    st.floats(0.0, math.tau),
    st.floats(-0.15, 0.15),
    st.floats(-0.15, 0.15),
)
def test_hiding_places_lie_outside_of_the_body_in_the_arc_and_are_wide_enough_to_hide_a_leg(
    begin: float, width: float, x: float, y: float
) -> None:
    for place in hiding_places(np.array([[begin, width]]), (x, y), BODY_M, REACH_M):
        seen = place - (x, y)
        assert math.hypot(*place) >= BODY_M
        assert math.hypot(*place) <= REACH_M
        assert (math.atan2(seen[1], seen[0]) - begin) % math.tau <= width + 1e-6
        assert math.hypot(*seen) * width >= THING_M - 1e-6


@given(st.floats(-math.pi, math.pi), st.floats(0.0, 1.0), st.floats(0.22, 0.55))
def test_no_leg_stands_unseen_where_no_hiding_place_is_near(bearing: float, width: float, distance_m: float) -> None:
    """A laser in the middle: a leg whose whole width lies in the arc has a hiding place within two of its widths."""
    leg = THING_M * 1.2
    assume(width * distance_m >= leg)
    places = hiding_places(np.array([[bearing - width / 2, width]]), (0.0, 0.0), BODY_M, REACH_M)
    stands = distance_m * np.array([math.cos(bearing), math.sin(bearing)])
    assert np.hypot(*(places - stands).T).min() <= 2.0 * leg


@pytest.mark.parametrize("dropped", [1, 2, 3])
def test_beams_that_drop_out_singly_hide_nothing_nearby(dropped: int) -> None:
    degree = math.radians(1.0)
    assert not hiding_places(np.array([[0.0, dropped * degree]]), (0.0, 0.0), BODY_M, 0.4).size
