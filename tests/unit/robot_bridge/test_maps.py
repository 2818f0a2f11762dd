"""What the bridge understands of a map, and what it says of one it does not."""

import numpy as np
import pytest

from contracts.geometry import Pose2D
from contracts.robot import MAP_CELLS_MAX
from geometry.grids import MapError, encode
from robot_bridge.navigation import maps

ORIGIN = Pose2D(x=-1.0, y=2.0, yaw=1.56)


def test_a_map_is_taken_as_it_is() -> None:
    grid = maps.understood(np.array([0, 100, -1, 0, 0, 0], np.int8), 3, 2, np.float32(0.05), ORIGIN)
    assert grid.cells.tolist() == [[0, 100, -1], [0, 0, 0]]
    assert (grid.resolution_m, grid.origin, grid.note) == (0.05, ORIGIN, "")


def test_a_long_map_is_taken_as_it_is() -> None:
    """Of a corridor, or a warehouse: only the number of its cells is limited."""
    grid = maps.understood(np.zeros(4097 * 2, np.int8), 4097, 2, 0.05, ORIGIN)
    assert (grid.cells.shape, grid.note) == ((2, 4097), "")
    assert encode(grid).width == 4097


def test_a_map_of_a_hundred_metres_at_a_centimetre_is_read_coarser_and_says_so() -> None:
    cells = np.zeros((10_000, 10_000), np.int8)
    cells[5000, 5000] = 100
    grid = maps.understood(cells.ravel(), 10_000, 10_000, 0.01, ORIGIN)
    assert grid.cells.size <= MAP_CELLS_MAX
    assert grid.note == "10000 x 10000 cells of 0.01 m are many: read as cells of 0.03 m"
    assert np.argwhere(grid.occupied).tolist() == [[1666, 1666]]


@pytest.mark.parametrize(
    ("width", "height", "resolution_m", "count", "why"),
    [
        (0, 0, 0.05, 0, "the map is empty: 0 x 0 cells"),
        (0, 7, 0.05, 0, "the map is empty: 0 x 7 cells"),
        (3, 2, 0.05, 5, "5 cells, not 3 x 2"),
        (3, 2, 0.0, 6, "0 m wide"),
        (3, 2, -0.05, 6, "-0.05 m wide"),
        (3, 2, 1e-6, 6, "1e-06 m wide"),
        (3, 2, 1.5, 6, "1.5 m wide"),
        (3, 2, float("nan"), 6, "nan m wide"),
        (3, 2, float("inf"), 6, "inf m wide"),
        (20_000, 20_000, 0.05, 6, "too large: 20000 x 20000"),
    ],
)
def test_what_is_no_map_of_a_home_says_why(width: int, height: int, resolution_m: float, count: int, why: str) -> None:
    with pytest.raises(MapError, match=why):
        maps.understood(np.zeros(count, np.int8), width, height, resolution_m, ORIGIN)
