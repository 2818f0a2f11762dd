"""Borders of a growing map: which are found, in which order, and which are none."""

import math

import numpy as np
import pytest

from contracts.geometry import Pose2D
from coordinator.exploration.frontiers import BORDER_M_MIN, chart_of
from geometry.grids import OccupancyGrid

RADIUS_M = 0.18
HERE = Pose2D(x=1.0, y=1.0, yaw=0.0)


def room_of(*openings: tuple[float, float], width_m: float = 3.0, yaw: float = 0.0) -> OccupancyGrid:
    """A room of known free space 3 m x 3 m with walls, in the middle of 9 m x 9 m of unknown; each opening is a gap in
    its right wall, from y to y, m."""
    cells = np.full((180, 180), -1, np.int8)
    side = round(width_m / 0.05)
    cells[60 : 60 + side, 60 : 60 + side] = 0
    cells[59, 59 : 61 + side] = cells[60 + side, 59 : 61 + side] = 100
    cells[59 : 61 + side, 59] = cells[59 : 61 + side, 60 + side] = 100
    for low, high in openings:
        cells[60 + round(low / 0.05) : 60 + round(high / 0.05), 60 + side] = 0
    return OccupancyGrid(cells, 0.05, Pose2D(x=-3.0, y=-3.0, yaw=yaw))


def test_a_closed_room_has_no_frontier() -> None:
    chart = chart_of(room_of(), HERE, RADIUS_M)
    assert chart.frontiers == ()
    assert chart.reachable_m2 == pytest.approx((3.0 - 2 * RADIUS_M) ** 2, rel=0.1)


def test_an_open_door_is_one_frontier_that_is_looked_through_from_inside() -> None:
    (frontier,) = chart_of(room_of((1.0, 1.8)), HERE, RADIUS_M).frontiers
    assert frontier.border_m == pytest.approx(0.8, abs=0.11)
    assert math.hypot(frontier.pose.x - 3.0, frontier.pose.y - 1.4) < 0.5
    assert frontier.pose.x < 3.0
    assert abs(frontier.pose.yaw) < 0.3
    assert frontier.path_m == pytest.approx(math.hypot(frontier.pose.x - 1.0, frontier.pose.y - 1.0), rel=0.15)


def test_the_wider_of_two_equally_near_is_worth_more() -> None:
    here = Pose2D(x=1.0, y=1.5, yaw=0.0)
    first, second = chart_of(room_of((0.2, 0.8), (1.6, 2.8)), here, RADIUS_M).frontiers
    assert (first.number, second.number) == (1, 2)
    assert first.border_m > second.border_m
    assert first.worth > second.worth


def test_the_nearer_of_two_alike_is_worth_more() -> None:
    first, second = chart_of(room_of((0.2, 1.0), (2.0, 2.8)), Pose2D(x=2.0, y=2.6, yaw=0.0), RADIUS_M).frontiers
    assert first.pose.y > second.pose.y
    assert first.path_m < second.path_m


def test_a_slit_is_no_frontier() -> None:
    assert chart_of(room_of((1.0, 1.0 + BORDER_M_MIN - 0.1)), HERE, RADIUS_M).frontiers == ()


def test_a_border_that_the_robot_cannot_get_near_is_none() -> None:
    grid = room_of((1.0, 1.8))
    grid.cells[60:120, 96:98] = 100  # a wall right across the room, the door behind it
    assert chart_of(grid, HERE, RADIUS_M).frontiers == ()


def test_space_behind_a_wall_is_not_behind_the_frontier() -> None:
    open_, walled = room_of((1.0, 1.8)), room_of((1.0, 1.8))
    walled.cells[60:120, 124] = 100  # a wall 0.2 m behind the opening
    behind = [chart_of(grid, HERE, RADIUS_M).frontiers[0].behind_m2 for grid in (open_, walled)]
    assert behind[1] < behind[0] / 3


@pytest.mark.parametrize("pose", [Pose2D(x=50.0, y=0.0, yaw=0.0), Pose2D(x=-2.5, y=-2.5, yaw=0.0)])
def test_a_robot_outside_of_what_is_known_has_neither_room_nor_frontiers(pose: Pose2D) -> None:
    chart = chart_of(room_of((1.0, 1.8)), pose, RADIUS_M)
    assert (chart.frontiers, chart.reachable_m2) == ((), 0.0)


def test_a_robot_at_a_wall_is_taken_to_stand_in_the_room() -> None:
    chart = chart_of(room_of((1.0, 1.8)), Pose2D(x=0.02, y=1.0, yaw=0.0), RADIUS_M)
    assert len(chart.frontiers) == 1
    assert chart.has_room_at(1.0, 1.0)
    assert not chart.has_room_at(0.05, 1.0)
    assert not chart.has_room_at(5.0, 1.0)


def test_a_turned_map_has_the_same_frontiers_elsewhere() -> None:
    turned = room_of((1.0, 1.8), yaw=math.pi / 2)
    x, y = turned.points(80.0, 80.0)
    (frontier,) = chart_of(turned, Pose2D(x=float(x), y=float(y), yaw=0.0), RADIUS_M).frontiers
    assert frontier.pose.yaw == pytest.approx(math.pi / 2, abs=0.3)
