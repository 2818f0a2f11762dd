"""Probabilities as one byte a cell: what comes back, how large it may be, and what is refused."""

import base64
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydantic import ValidationError

from contracts.belief import PROBABILITY_CELLS_MAX, PROBABILITY_DECADES, ProbabilityGrid
from contracts.geometry import Pose2D
from geometry.probability_grids import ProbabilityGridError, corners, decode, encode

ORIGIN = Pose2D(x=-2.0, y=1.0, yaw=0.0)
WITHIN = 0.02

masses = arrays(float, st.tuples(st.integers(1, 12), st.integers(1, 12)), elements=st.floats(0.0, 1.0))


def packed(raw: bytes) -> str:
    return base64.b64encode(zlib.compress(raw)).decode()


@given(masses)
def test_each_cell_comes_back_within_2_percent_or_was_next_to_nothing(cells: np.ndarray) -> None:
    peak = float(cells.max())
    back = decode(encode(cells, resolution_m=0.15, origin=ORIGIN))
    told = back > 0.0
    assert np.allclose(back[told], cells[told], rtol=WITHIN, atol=0.0)
    assert (cells[~told] <= peak * 10.0**-PROBABILITY_DECADES * (1.0 + WITHIN)).all()


def test_the_least_that_is_told_is_told_and_what_is_less_is_not() -> None:
    cells = np.array([[1.0, 1.01e-4, 0.9e-4, 0.0]]) / 2.0
    back = decode(encode(cells, resolution_m=0.15, origin=ORIGIN))
    assert back[0] == pytest.approx([0.5, 0.505e-4, 0.0, 0.0], rel=WITHIN)


def test_a_belief_in_nothing_is_a_grid_of_nothing() -> None:
    grid = encode(np.zeros((3, 4)), resolution_m=0.15, origin=ORIGIN)
    assert (grid.peak, grid.width, grid.height) == (0.0, 4, 3)
    assert not decode(grid).any()


def test_more_cells_than_a_message_may_hold_are_summed_to_larger_ones() -> None:
    cells = np.full((1001, 1500), 1.0 / (1001 * 1500))
    grid = encode(cells, resolution_m=0.15, origin=ORIGIN)
    assert (grid.width, grid.height, grid.resolution_m) == (750, 501, pytest.approx(0.3))
    assert decode(grid).sum() == pytest.approx(1.0, rel=WITHIN)


def test_the_worst_grid_there_can_be_fits_into_a_message() -> None:
    noise = np.random.default_rng(1).random(PROBABILITY_CELLS_MAX).reshape(1000, -1)
    grid = encode(10.0 ** (-PROBABILITY_DECADES * noise), resolution_m=0.15, origin=ORIGIN)
    assert grid.width * grid.height == PROBABILITY_CELLS_MAX


def test_a_grid_with_too_many_cells_is_no_message() -> None:
    with pytest.raises(ValidationError, match="no more than"):
        ProbabilityGrid(width=1001, height=1000, resolution_m=0.1, origin=ORIGIN, peak=0.1, levels_base64="")


@pytest.mark.parametrize("levels", ["!", "AAAA", packed(bytes(11)), packed(bytes(13)), packed(bytes(100_000_000))])
def test_what_its_fields_do_not_say_is_refused(levels: str) -> None:
    grid = ProbabilityGrid(width=4, height=3, resolution_m=0.15, origin=ORIGIN, peak=0.1, levels_base64=levels)
    with pytest.raises(ProbabilityGridError):
        decode(grid)


def test_its_corners_are_in_map_however_it_is_turned() -> None:
    origin = Pose2D(x=1.0, y=2.0, yaw=np.pi / 2)
    first, across, up = corners(encode(np.ones((2, 4)) / 8.0, resolution_m=0.5, origin=origin))
    assert first == pytest.approx((1.0, 2.0))
    assert across == pytest.approx((1.0, 4.0))
    assert up == pytest.approx((0.0, 2.0))
