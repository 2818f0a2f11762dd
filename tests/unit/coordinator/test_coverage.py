"""Requirement A6 exactly, and what the better rule promises."""

from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from contracts.geometry import Pose2D
from coordinator.coverage.baselines import in_random_order, nearest_frontiers
from coordinator.coverage.coverage_tracker import CoverageTracker
from coordinator.coverage.lawnmower import clearance_cells, lawnmower, safe_cells
from coordinator.coverage.untyped import label_regions
from coordinator.coverage.viewpoints import two_opt, viewpoints
from geometry.grids import OccupancyGrid

REACH_M = 1.8


def grid_of(free: np.ndarray) -> OccupancyGrid:
    return OccupancyGrid(np.where(free, 0, 100).astype(np.int8), 0.05, Pose2D(x=-1.0, y=-2.0, yaw=0.0))


def rooms(rows: int, columns: int, side: int, door: int) -> OccupancyGrid:
    """Square rooms in a lattice, each wall with a door."""
    free = np.ones((rows * side, columns * side), dtype=bool)
    free[:2], free[-2:], free[:, :2], free[:, -2:] = False, False, False, False
    for k in range(1, rows):
        free[k * side - 1 : k * side + 1] = False
    for k in range(1, columns):
        free[:, k * side - 1 : k * side + 1] = False
    for r in range(rows):
        for c in range(columns):
            middle_r, middle_c = r * side + side // 2, c * side + side // 2
            if r:
                free[r * side - 1 : r * side + 1, middle_c : middle_c + door] = True
            if c:
                free[middle_r : middle_r + door, c * side - 1 : c * side + 1] = True
    return grid_of(free)


blocky = st.tuples(st.integers(4, 12), st.integers(4, 12)).flatmap(
    lambda shape: hnp.arrays(bool, shape, elements=st.sampled_from([True, True, True, False]))
)


def cell_of(grid: OccupancyGrid, pose: Pose2D) -> tuple[int, int]:
    cell = grid.cell(pose.x, pose.y)
    assert cell is not None
    return cell


def test_the_clearance_is_eight_cells_of_five_centimetres() -> None:
    assert clearance_cells(0.05, 0.389) == 8


@settings(max_examples=60)
@given(blocky)
def test_every_lawnmower_point_has_its_clearance(blocks: np.ndarray) -> None:
    grid = grid_of(np.kron(blocks, np.ones((12, 12), dtype=bool)))
    for pose in lawnmower(grid, radius_m=0.189).points:
        row, column = cell_of(grid, pose)
        assert row >= 8
        assert column >= 8
        assert grid.free[row - 8 : row + 9, column - 8 : column + 9].sum() == 17 * 17


@settings(max_examples=60)
@given(blocky)
def test_every_region_of_more_than_256_safe_cells_has_a_point(blocks: np.ndarray) -> None:
    grid = grid_of(np.kron(blocks, np.ones((12, 12), dtype=bool)))
    labels, count = label_regions(safe_cells(grid.free, 8))
    reached = {int(labels[cell_of(grid, pose)]) for pose in lawnmower(grid, radius_m=0.189).points}
    large = {region for region in range(1, count + 1) if int((labels == region).sum()) > 256}
    assert large <= reached


def test_rows_lie_a_metre_apart_and_alternate() -> None:
    points = lawnmower(grid_of(np.pad(np.ones((100, 120), dtype=bool), 2)), radius_m=0.189).points
    rows = sorted({round(p.y, 3) for p in points})
    assert {round(b - a, 3) for a, b in pairwise(rows)} == {1.0}
    first, second = ([p.x for p in points if round(p.y, 3) == rows[k]] for k in (0, 1))
    assert first == sorted(first)
    assert second == sorted(second, reverse=True)


def test_a_room_behind_a_narrow_door_gets_a_point_of_its_own() -> None:
    free = np.zeros((60, 60), dtype=bool)
    free[2:38, 21:58] = True
    assert len(lawnmower(grid_of(free), radius_m=0.189).points) >= 1


def test_a_full_map_has_no_points() -> None:
    grid = grid_of(np.zeros((50, 50), dtype=bool))
    assert lawnmower(grid, radius_m=0.189).points == ()
    assert viewpoints(grid, radius_m=0.189, start=None, reach_m=REACH_M).points == ()


def test_viewpoints_see_nearly_everything_from_fewer_places() -> None:
    grid = rooms(2, 2, 80, 18)
    plan = viewpoints(grid, radius_m=0.189, start=Pose2D(x=0.0, y=-1.0, yaw=0.0), reach_m=REACH_M)
    space = CoverageTracker(grid)
    for pose in plan.points:
        space.mark(pose, hfov_rad=6.2832, reach_m=REACH_M)
    assert space.share >= 0.95
    assert len(plan.points) < len(lawnmower(grid, radius_m=0.189).points)


def test_no_room_of_a_large_floor_is_lost() -> None:
    side = 60
    grid = rooms(14, 14, side, 16)
    plan = viewpoints(grid, radius_m=0.189, start=Pose2D(x=0.0, y=-1.0, yaw=0.0), reach_m=REACH_M, points_max=5000)
    space = CoverageTracker(grid)
    for pose in plan.points:
        space.mark(pose, hfov_rad=6.2832, reach_m=REACH_M)
    seen = space.seen.reshape(14, side, 14, side).sum(axis=(1, 3))
    free = grid.free.reshape(14, side, 14, side).sum(axis=(1, 3))
    assert (seen / free).min() > 0.9


def test_a_closet_beside_the_lattice_is_looked_into() -> None:
    free = np.zeros((90, 140), dtype=bool)
    free[2:88, 2:100] = True
    free[40:54, 100:104] = True
    free[36:58, 104:126] = True
    grid = grid_of(free)
    plan = viewpoints(grid, radius_m=0.189, start=Pose2D(x=0.0, y=0.0, yaw=0.0), reach_m=REACH_M)
    space = CoverageTracker(grid)
    for pose in plan.points:
        space.mark(pose, hfov_rad=6.2832, reach_m=REACH_M)
    closet = np.s_[36:58, 104:126]
    assert space.seen[closet].mean() > 0.9


def test_viewpoints_leave_out_what_was_seen() -> None:
    grid = rooms(1, 2, 80, 18)
    space = CoverageTracker(grid)
    space.seen[:, :80] = True
    plan = viewpoints(grid, radius_m=0.189, start=None, reach_m=REACH_M, seen=space.seen)
    everything = viewpoints(grid, radius_m=0.189, start=None, reach_m=REACH_M)
    assert 0 < len(plan.points) < len(everything.points)


def test_viewpoints_avoid_places_already_tried() -> None:
    grid = rooms(1, 1, 80, 18)
    first = viewpoints(grid, radius_m=0.189, start=None, reach_m=REACH_M).points[0]
    again = viewpoints(grid, radius_m=0.189, start=None, reach_m=REACH_M, avoid=(first,)).points
    assert all(np.hypot(p.x - first.x, p.y - first.y) > 0.35 for p in again)


def test_viewpoints_are_only_where_the_robot_can_walk_to() -> None:
    free = np.zeros((80, 160), dtype=bool)
    free[2:78, 2:78] = True
    free[2:78, 84:158] = True
    grid = grid_of(free)
    plan = viewpoints(grid, radius_m=0.189, start=Pose2D(x=1.0, y=0.0, yaw=0.0), reach_m=REACH_M)
    assert plan.points
    assert all(cell_of(grid, pose)[1] < 80 for pose in plan.points)


def test_the_first_viewpoint_is_near_the_robot() -> None:
    grid = rooms(1, 4, 80, 18)
    start = Pose2D(x=13.0, y=0.0, yaw=0.0)
    points = viewpoints(grid, radius_m=0.189, start=start, reach_m=REACH_M).points
    assert np.hypot(points[0].x - start.x, points[0].y - start.y) < 4.0


def test_walls_hide_what_is_behind_them() -> None:
    grid = rooms(1, 2, 80, 0)
    space = CoverageTracker(grid)
    space.mark(Pose2D(x=2.7, y=0.0, yaw=0.0), hfov_rad=6.2832, reach_m=REACH_M)
    assert space.seen[:, :78].any()
    assert not space.seen[:, 82:].any()


def test_the_camera_sees_a_wedge_not_a_disc() -> None:
    grid = rooms(1, 1, 100, 0)
    space = CoverageTracker(grid)
    space.mark(Pose2D(x=1.5, y=0.5, yaw=0.0), hfov_rad=0.94, reach_m=1.0)
    row, column = grid.cell(1.5, 0.5) or (0, 0)
    assert space.seen[row, column + 15]
    assert not space.seen[row, column - 5]
    assert not space.seen[row + 10, column]


def test_two_opt_uncrosses_a_tour() -> None:
    spots = np.array([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]])
    between = np.hypot(*(spots[:, None] - spots[None]).transpose(2, 0, 1))
    order = two_opt([0, 1, 2, 3], between)
    assert sum(between[a, b] for a, b in pairwise(order)) == 3.0


def test_the_nearest_frontier_comes_first_and_none_is_left_when_all_was_seen() -> None:
    grid, start = rooms(1, 4, 60, 16), Pose2D(x=3.5, y=-0.5, yaw=0.0)
    seen = np.zeros_like(grid.free)
    seen[:, 80:150] = grid.free[:, 80:150]
    coverage = nearest_frontiers(grid, radius_m=0.17, start=start, seen=seen, avoid=())
    rows, columns = zip(*(cell_of(grid, point) for point in coverage.points), strict=True)
    assert sorted(columns) == [79, 150]
    assert columns[0] == 79
    assert all(grid.free[cell] for cell in zip(rows, columns, strict=True))
    right = nearest_frontiers(grid, radius_m=0.17, start=Pose2D(x=9.0, y=-0.5, yaw=0.0), seen=seen, avoid=())
    assert right.points == coverage.points[::-1]
    again = nearest_frontiers(grid, radius_m=0.17, start=start, seen=seen, avoid=(coverage.points[0],))
    assert coverage.points[0] not in again.points
    assert nearest_frontiers(grid, radius_m=0.17, start=start, seen=grid.free, avoid=()).points == ()


def test_a_random_order_holds_the_same_points_and_is_the_same_each_time() -> None:
    plain = viewpoints(rooms(2, 2, 60, 16), radius_m=0.17, start=None, reach_m=REACH_M)
    mixed = in_random_order(plain)
    assert set(mixed.points) == set(plain.points)
    assert mixed.points != plain.points
    assert in_random_order(plain) == mixed
