"""One reading of a map: its cells, its origin, and what is no map."""

import base64
import math
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from contracts.geometry import Pose2D
from contracts.robot import Map
from geometry.grids import OCCUPIED, UNKNOWN, MapError, OccupancyGrid, coarser, decode, encode, of_values
from geometry.poses import compose, inverse

yaws = st.one_of(st.sampled_from([0.0, 0.1, 1.56, math.pi, -math.pi / 2]), st.floats(-math.pi, math.pi))
poses = st.builds(Pose2D, x=st.floats(-50.0, 50.0), y=st.floats(-50.0, 50.0), yaw=yaws)
resolutions = st.sampled_from([0.01, 0.05, 0.1, 0.25])
shapes = st.tuples(st.integers(1, 12), st.integers(1, 12))
grids = st.builds(
    OccupancyGrid,
    shapes.flatmap(lambda shape: hnp.arrays(np.int8, shape, elements=st.sampled_from([-1, 0, 25, 26, 64, 65, 100]))),
    resolutions,
    poses,
)


@given(grids, st.data())
def test_the_middle_of_a_cell_lies_in_that_cell_however_the_map_is_turned(
    grid: OccupancyGrid, data: st.DataObject
) -> None:
    row = data.draw(st.integers(0, grid.cells.shape[0] - 1))
    column = data.draw(st.integers(0, grid.cells.shape[1] - 1))
    assert grid.cell(*grid.centre(row, column)) == (row, column)


@given(grids, st.floats(-40.0, 40.0), st.floats(-40.0, 40.0))
def test_cells_lead_back_to_the_point_they_came_from(grid: OccupancyGrid, x: float, y: float) -> None:
    back = grid.points(*grid.columns_and_rows(np.array(x), np.array(y)))
    assert [float(each) for each in back] == pytest.approx([x, y], abs=1e-9)


@given(grids)
def test_the_origin_is_the_corner_of_the_first_cell_and_rows_go_to_its_left(grid: OccupancyGrid) -> None:
    step = Pose2D(x=grid.resolution_m * 0.5, y=grid.resolution_m * 0.5, yaw=0.0)
    first = compose(grid.origin, step)
    assert grid.centre(0, 0) == pytest.approx((first.x, first.y))


@given(poses, poses)
def test_what_a_pose_does_its_inverse_undoes(a: Pose2D, b: Pose2D) -> None:
    back = compose(inverse(a), compose(a, b))
    assert (back.x, back.y) == pytest.approx((b.x, b.y), abs=1e-9)
    assert math.remainder(back.yaw - b.yaw, math.tau) == pytest.approx(0.0, abs=1e-9)


@given(grids)
def test_a_map_comes_out_of_its_message_as_it_went_in(grid: OccupancyGrid) -> None:
    read = decode(encode(grid))
    assert (read.cells == grid.cells).all()
    assert (read.resolution_m, read.origin) == (grid.resolution_m, grid.origin)


def test_outside_the_map_nothing_is_free_occupied_or_a_cell() -> None:
    grid = OccupancyGrid(np.zeros((4, 6), np.int8), 0.5, Pose2D(x=1.0, y=1.0, yaw=math.pi / 2))
    assert grid.cell(1.0 - 1e-6, 1.0 + 1e-6) == (0, 0)
    assert grid.cell(1.0 + 1e-6, 1.0 + 1e-6) is None
    x, y = np.array([0.9, 1.1, -5.0]), np.array([1.1, 1.1, 1.1])
    assert grid.at(x, y, grid.free).tolist() == [True, False, False]


@pytest.mark.parametrize(
    ("value", "kind"),
    [
        *[(value, "free") for value in (0, 1, 25)],
        *[(value, "neither") for value in (26, 50, 64)],
        *[(value, "occupied") for value in (65, 99, 100)],
        *[(value, "unknown") for value in (-1, -2, -128, 101, 127)],
    ],
)
def test_every_cell_value_has_one_meaning(value: int, kind: str) -> None:
    grid = of_values(np.array([value], np.int8), 1, 1, 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0))
    said = {"free": grid.free[0, 0], "occupied": grid.occupied[0, 0], "unknown": grid.unknown[0, 0]}
    assert [name for name, is_so in said.items() if is_so] == ([] if kind == "neither" else [kind])


def test_255_of_an_unsigned_map_is_unknown() -> None:
    grid = of_values(np.array([255, 0], np.uint8), 2, 1, 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0))
    assert grid.cells.tolist() == [[UNKNOWN, 0]]


def message(data: bytes, width: int = 3, height: int = 2) -> Map:
    origin = Pose2D(x=0.0, y=0.0, yaw=0.0)
    packed = base64.b64encode(data).decode()
    return Map(width=width, height=height, resolution_m=0.05, origin=origin, data_base64=packed)


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (zlib.compress(bytes(5)), "5 cells, not 3 x 2"),
        (zlib.compress(bytes(7)), "7 cells, not 3 x 2"),
        (zlib.compress(bytes(100_000_000)), "7 cells, not 3 x 2"),  # no more is unpacked than would fit
        (b"no zlib", "cannot be unpacked"),
        (zlib.compress(bytes(6))[:4], "1 cells"),
        (b"", "0 cells"),
    ],
)
def test_what_is_not_a_map_says_why(data: bytes, why: str) -> None:
    with pytest.raises(MapError, match=why):
        decode(message(data))


def test_what_is_no_base64_is_no_map() -> None:
    with pytest.raises(MapError, match="cannot be unpacked"):
        decode(message(b"").model_copy(update={"data_base64": "*"}))


@given(grids, st.integers(1, 5))
def test_a_coarser_map_loses_no_obstacle_and_invents_no_free_space(grid: OccupancyGrid, factor: int) -> None:
    coarse = coarser(grid, factor)
    rows, columns = np.indices(grid.cells.shape)
    x, y = grid.points(columns + 0.5, rows + 0.5)
    assert coarse.at(x, y, coarse.occupied)[grid.occupied].all()
    assert grid.free[coarse.at(x, y, coarse.free)].all()


def test_a_coarser_cell_is_what_is_worst_in_it() -> None:
    cells = np.array([[0, 0, 0, -1, 40, 0], [0, 0, -1, OCCUPIED, 0, 0]], np.int8)
    coarse = coarser(OccupancyGrid(cells, 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0)), 2)
    assert coarse.cells.tolist() == [[0, OCCUPIED, 40]]
    assert coarse.resolution_m == 0.1
