"""The map that grows as it is seen: what it holds, what it leaves unknown, how it grows."""

import math

import numpy as np
import pytest

from contracts.geometry import Pose2D
from geometry.poses import compose
from sim.home import Home
from sim.nav.mapper import Mapper
from sim.world import OccupancyGrid, Scan, World
from sim.world.occupancy import reachable
from sim.world.robot import LIDAR, ROBOT_RADIUS_M

RAYS = 720
ANGLES = -math.pi + np.arange(RAYS) * (2 * math.pi / RAYS)


def scan_of_box(at: Pose2D, half_m: float) -> Scan:
    """What a laser at `at` sees of a square room round the origin; nothing through its right wall, which is open."""
    directions = ANGLES + at.yaw
    with np.errstate(divide="ignore", invalid="ignore"):
        x = np.where(np.cos(directions) > 0, math.inf, (-half_m - at.x) / np.cos(directions))
        y = (np.sign(np.sin(directions)) * half_m - at.y) / np.sin(directions)
    ranges = np.minimum(np.where(x > 0, x, math.inf), np.where(y > 0, y, math.inf))
    ranges = np.where(ranges <= 12.0, ranges, math.inf).astype(np.float32)
    return Scan(0.0, ranges, -math.pi, 2 * math.pi / RAYS, 0.15, 12.0)


def value(grid: OccupancyGrid, x: float, y: float) -> int:
    row, column = grid.cell(x, y)
    return int(grid.data[row, column])


def seen_from(mapper: Mapper, at: Pose2D, half_m: float = 2.0) -> OccupancyGrid:
    for _ in range(3):
        mapper.observe(scan_of_box(at, half_m), at)
    grid = mapper.grid()
    assert grid is not None
    return grid


def test_it_holds_walls_free_space_and_leaves_the_rest_unknown() -> None:
    grid = seen_from(Mapper(), Pose2D(x=0.0, y=0.0, yaw=0.3))
    assert [value(grid, *at) for at in ((0.0, 0.0), (1.0, 1.5), (-1.9, 0.0))] == [0, 0, 0]
    assert [value(grid, *at) for at in ((-2.01, 0.3), (0.3, 2.01), (0.3, -2.01))] == [100, 100, 100]
    assert value(grid, 6.0, 0.02) == 0, "through the open side it sees as far as it reaches"
    assert grid.data[0].max() == grid.data[:, 0].max() == -1


def test_it_grows_as_the_robot_goes_on_and_keeps_what_it_saw() -> None:
    mapper = Mapper()
    before = seen_from(mapper, Pose2D(x=0.0, y=0.0, yaw=0.0))
    after = seen_from(mapper, Pose2D(x=20.0, y=1.0, yaw=2.0))
    assert after.data.shape[1] > before.data.shape[1]
    assert value(after, -2.01, 0.3) == 100
    assert value(after, 25.0, 0.0) == 0


def test_one_beam_is_not_believed() -> None:
    mapper = Mapper()
    mapper.observe(scan_of_box(Pose2D(x=0.0, y=0.0, yaw=0.0), 2.0), Pose2D(x=0.0, y=0.0, yaw=0.0))
    assert mapper.grid() is None


def test_a_robot_that_stands_adds_nothing() -> None:
    mapper, here = Mapper(), Pose2D(x=0.0, y=0.0, yaw=0.0)
    assert [mapper.observe(scan_of_box(here, 2.0), here) for _ in range(4)] == [True, True, False, False]


def test_what_went_away_is_seen_through() -> None:
    mapper = Mapper()
    seen_from(mapper, Pose2D(x=0.0, y=0.0, yaw=0.0), half_m=1.0)
    for k in range(30):
        seen_from(mapper, Pose2D(x=0.0, y=0.0, yaw=0.2 * k), half_m=2.0)
    grid = mapper.grid()
    assert grid is not None
    assert value(grid, -1.01, 0.3) == 0


@pytest.mark.parametrize("seed", [3])
def test_a_simulated_home_seen_from_where_the_robot_can_stand_is_the_map_somebody_recorded(seed: int) -> None:
    with World(Home.generate(seed), seed=1) as world:
        recorded, mapper = world.grid, Mapper()
        start = compose(world.scene.dock, Pose2D(x=-0.5, y=0.0, yaw=0.0))
        room = reachable(recorded, start, ROBOT_RADIUS_M)
        rows, columns = np.nonzero(room)
        for k in np.linspace(0, len(rows) - 1, 30).astype(int).tolist():
            x, y = recorded.origin_x_m + (columns[k] + 0.5) * 0.05, recorded.origin_y_m + (rows[k] + 0.5) * 0.05
            for yaw in (0.0, 0.2):
                pose = Pose2D(x=float(x), y=float(y), yaw=yaw)
                world.teleport(pose)
                for _ in range(2):
                    mapper.observe(world.scan(), compose(pose, LIDAR))
    grid = mapper.grid()
    assert grid is not None
    shift_x = round((recorded.origin_x_m - grid.origin_x_m) / grid.resolution_m)
    shift_y = round((recorded.origin_y_m - grid.origin_y_m) / grid.resolution_m)
    told = grid.data[rows + shift_y, columns + shift_x]
    assert np.mean(told == 0) > 0.98
    assert np.mean(told == 100) < 0.01
