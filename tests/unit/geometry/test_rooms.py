"""A map cut into rooms at its doorways."""

import tracemalloc

import numpy as np
import pytest

from bench.map_likeness import home_grid, rewritten
from bench.rooms import as_mapped, share_right, true_rooms
from contracts.geometry import Pose2D
from geometry import regions
from geometry.grids import OCCUPIED, UNKNOWN, OccupancyGrid
from geometry.rooms import rooms_of
from sim.home import Home

ORIGIN = Pose2D(x=-1.0, y=2.0, yaw=0.0)


def two_rooms(*, door_m: float = 0.9, wall_cells: int = 2) -> OccupancyGrid:
    """8 x 4 m, a wall across its middle with a doorway 1 m from the lower wall."""
    cells = np.zeros((80, 160), np.int8)
    cells[:2] = cells[-2:] = cells[:, :2] = cells[:, -2:] = OCCUPIED
    cells[:, 80 : 80 + wall_cells] = OCCUPIED
    cells[22 : 22 + round(door_m / 0.05), 80 : 80 + wall_cells] = 0
    return OccupancyGrid(cells, 0.05, ORIGIN)


def with_block(grid: OccupancyGrid, rows: slice, columns: slice) -> OccupancyGrid:
    cells = grid.cells.copy()
    cells[rows, columns] = OCCUPIED
    return OccupancyGrid(cells, grid.resolution_m, grid.origin)


def test_a_doorway_parts_two_rooms_and_every_free_cell_is_in_one() -> None:
    grid = two_rooms()
    found = rooms_of(grid)
    assert [one.area_m2 for one in found.rooms] == pytest.approx([14.9, 14.3], abs=0.2)
    assert bool((found.labels[grid.free] > 0).all())
    assert not found.labels[grid.occupied].any()


def test_a_room_is_found_by_a_point_and_its_roomiest_place_lies_in_it() -> None:
    found = rooms_of(two_rooms())
    left, right = found.at(1.0, 4.0), found.at(5.0, 4.0)
    assert {left, right} == set(found.rooms)
    assert {found.at(one.x_m, one.y_m) for one in found.rooms} == set(found.rooms)
    assert found.at(0.0, 40.0) is None


def test_a_thing_against_a_wall_is_in_the_room_it_is_nearest_to() -> None:
    found = rooms_of(two_rooms())
    in_wall = (-0.98, 4.0)
    assert found.at(*in_wall) is None
    assert found.at(*in_wall, within_m=0.3) == found.at(-0.5, 4.0)


def test_an_opening_wider_than_a_doorway_leaves_one_room() -> None:
    assert len(rooms_of(two_rooms(door_m=1.8)).rooms) == 1


def test_furniture_across_a_room_leaves_a_gap_and_no_doorway() -> None:
    assert len(rooms_of(two_rooms(wall_cells=16)).rooms) == 1


def test_a_chair_in_the_doorway_is_looked_through() -> None:
    assert len(rooms_of(with_block(two_rooms(), slice(26, 34), slice(77, 85))).rooms) == 2


@pytest.mark.parametrize(("yaw", "resolution_m"), [(0.7, 0.05), (-0.3, 0.05), (0.0, 0.03)])
def test_the_way_a_map_is_written_down_makes_no_difference(yaw: float, resolution_m: float) -> None:
    plain, other = rooms_of(two_rooms()), rooms_of(rewritten(two_rooms(), yaw, resolution_m))
    assert len(other.rooms) == 2
    for one in plain.rooms:
        found = other.at(one.x_m, one.y_m)
        assert found is not None
        assert found.area_m2 == pytest.approx(one.area_m2, rel=0.03)


@pytest.mark.parametrize("value", [UNKNOWN, OCCUPIED])
def test_a_map_without_free_floor_has_no_rooms(value: int) -> None:
    found = rooms_of(OccupancyGrid(np.full((9, 7), value, np.int8), 0.05, ORIGIN))
    assert found.rooms == ()
    assert found.at(0.0, 2.1) is None


def test_open_floor_is_one_room() -> None:
    assert len(rooms_of(OccupancyGrid(np.zeros((60, 60), np.int8), 0.05, ORIGIN)).rooms) == 1


@pytest.mark.parametrize("seed", [7003, 7014])
def test_the_rooms_of_a_simulated_home_are_found_however_its_map_was_made(seed: int) -> None:
    """7014: furniture stands against the side of a doorway. 7003: a piece of wall between two doorways. All the figures
    are those of `make bench-rooms`."""
    home = Home.generate(seed)
    kinds = {kind: grid for kind, grid in as_mapped(home, home_grid(seed)) if kind != "all three"}
    cut = {kind: rooms_of(grid) for kind, grid in kinds.items()}
    shares = {kind: share_right(found, true_rooms(home, found.grid)) for kind, found in cut.items()}
    assert {kind: share for kind, share in shares.items() if share < 0.95} == {}


def amid(grid: OccupancyGrid, side: int) -> OccupancyGrid:
    """The same place in the middle of a map of which nothing else is known."""
    cells = np.full((side, side), UNKNOWN, np.int8)
    height, width = grid.cells.shape
    low, left = (side - height) // 2, (side - width) // 2
    cells[low : low + height, left : left + width] = grid.cells
    x, y = grid.points(-left, -low)
    return OccupancyGrid(cells, grid.resolution_m, Pose2D(x=float(x), y=float(y), yaw=grid.origin.yaw))


@pytest.mark.parametrize("yaw", [0.0, 0.7])
def test_what_is_unknown_round_a_home_costs_nothing_and_changes_nothing(yaw: float) -> None:
    grid = rewritten(two_rooms(), yaw, 0.05)
    large = amid(grid, 4096)
    tracemalloc.start()
    found = rooms_of(large)
    _, most_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert found.rooms == rooms_of(grid).rooms
    assert len(found.rooms) == 2
    assert most_bytes < 3 * large.cells.size


def test_a_map_of_too_many_squares_has_no_rooms() -> None:
    grid = amid(two_rooms(), 300)
    known = two_rooms().cells.size
    assert len(rooms_of(grid, cells_max=known).rooms) == 2
    found = rooms_of(grid, cells_max=known - 1)
    assert found.rooms == ()
    assert found.at(1.0, 4.0, within_m=5.0) is None


def test_a_map_that_straightening_makes_too_many_squares_of_has_no_rooms() -> None:
    coarse = OccupancyGrid(two_rooms().cells, 0.2, ORIGIN)
    assert len(rooms_of(coarse, cells_max=17 * coarse.cells.size).rooms) == 1
    assert rooms_of(coarse, cells_max=15 * coarse.cells.size).rooms == ()


def test_a_map_of_small_cells_is_cut_on_larger_ones_where_they_are_too_many() -> None:
    fine = rewritten(two_rooms(), 0.0, 0.025)
    found = rooms_of(fine, cells_max=20_000)
    assert found.grid.resolution_m == pytest.approx(0.05)
    assert [one.area_m2 for one in found.rooms] == pytest.approx([14.9, 14.3], abs=0.4)
    assert found.at(1.0, 4.0) != found.at(5.0, 4.0)


@pytest.mark.parametrize("seed", range(5))
def test_how_deep_a_cell_lies_is_what_scipy_measures(seed: int) -> None:
    from scipy import ndimage

    rng = np.random.default_rng(seed)
    mask = np.pad(rng.random((60, 41)) < 0.97, 1)
    assert (regions.depth(mask) == ndimage.distance_transform_cdt(mask, "chessboard")).all()
    labels = np.where(mask, np.kron(rng.integers(0, 4, (8, 6)), np.ones((8, 8), int))[:62, :43], 0).astype(np.int32)
    deep = regions.depths(labels)
    for number in (1, 2, 3):
        assert (np.where(labels == number, deep, 0) == regions.depth(labels == number)).all()
    low, behind = regions.extents(labels, 3)
    assert [(*low[k], *behind[k]) for k in (1, 2, 3)] == [
        (one[0].start, one[1].start, one[0].stop, one[1].stop) for one in ndimage.find_objects(labels)
    ]


def test_numbers_spread_cell_by_cell_and_the_greater_wins() -> None:
    labels = np.array([[1, 0, 0, 2], [0, 0, 0, 0], [3, 0, 0, 0]], np.int32)
    space = np.array([[1, 1, 1, 1], [1, 0, 0, 0], [1, 0, 1, 1]], bool)
    assert regions.spread(labels, space).tolist() == [[1, 1, 2, 2], [3, 0, 0, 0], [3, 0, 0, 0]]


def test_regions_are_told_apart_by_their_sides_or_by_their_corners() -> None:
    mask = np.array([[1, 0, 1, 1], [1, 1, 0, 0], [0, 0, 1, 0], [1, 0, 1, 1]], bool)
    by_sides, count = regions.label(mask)
    assert count == 4
    assert by_sides.tolist() == [[1, 0, 2, 2], [1, 1, 0, 0], [0, 0, 3, 0], [4, 0, 3, 3]]
    assert regions.label(mask, corners=True)[1] == 2


@pytest.mark.parametrize("corners", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_regions_are_those_that_scipy_finds(seed: int, corners: bool) -> None:
    from scipy import ndimage

    mask = np.random.default_rng(seed).random((37, 53)) < 0.55
    own, count = regions.label(mask, corners=corners)
    theirs, expected = ndimage.label(mask, structure=np.ones((3, 3)) if corners else None)
    assert count == expected
    assert len(set(zip(own.ravel().tolist(), theirs.ravel().tolist(), strict=True))) == count + 1
