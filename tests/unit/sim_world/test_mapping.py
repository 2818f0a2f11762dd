"""The recorded map and the tour that recorded it."""

import math

import numpy as np
import pytest

from contracts.geometry import Pose2D
from geometry.poses import compose
from sim.world import OccupancyGrid, Scene, World
from sim.world.occupancy import OpenHomeError, draw, reachable
from sim.world.robot import LIDAR
from sim.world.tour import tour_frames, tour_poses, tour_stops
from support.simulated_room import DOCK, PERFECT, ROOM, SCENE, world_at


@pytest.fixture(scope="module")
def world() -> World:
    return world_at()


def test_walls_and_things_are_occupied_the_floor_is_free_and_outside_is_unknown(world: World) -> None:
    grid = world.grid
    assert grid.at(3.0, 4.03) == 100
    assert grid.at(4.5, 3.0) == 100
    assert grid.at(3.0, 2.0) == 0  # a rug is no obstacle
    assert grid.at(3.0, 4.25) == -1
    assert grid.at(99.0, 99.0) == -1
    assert grid.data.dtype == np.int8


def test_what_the_robot_fits_under_is_free_and_the_legs_are_not(world: World) -> None:
    assert world.grid.at(1.5, 3.4) == 0
    assert world.grid.at(1.0, 3.4) == 100


def test_the_robot_itself_is_not_on_the_map() -> None:
    assert world_at(Pose2D(x=3.0, y=1.0, yaw=0.0)).grid.at(3.0, 1.0) == 0


def test_every_lidar_return_ends_at_an_occupied_cell(world: World) -> None:
    grid = world.grid
    for pose in (Pose2D(x=2.0, y=2.0, yaw=0.3), Pose2D(x=5.0, y=2.0, yaw=2.0), Pose2D(x=3.4, y=0.6, yaw=-1.0)):
        world.teleport(pose)
        scan = world.scan()
        laser = compose(pose, LIDAR)
        angles = scan.angle_min + scan.angle_increment * np.arange(720) + laser.yaw
        x = laser.x + np.cos(angles) * (scan.ranges_m + 0.01)
        y = laser.y + np.sin(angles) * (scan.ranges_m + 0.01)
        around = [
            max(grid.at(a + i * 0.03, b + j * 0.03) for i in (-1, 0, 1) for j in (-1, 0, 1))
            for a, b in zip(x.tolist(), y.tolist(), strict=True)
        ]
        assert set(around) == {100}


def test_lidar_rays_run_through_free_cells_but_where_they_graze_a_corner(world: World) -> None:
    grid = world.grid
    world.teleport(Pose2D(x=2.0, y=2.0, yaw=0.0))
    scan = world.scan()
    angles = scan.angle_min + scan.angle_increment * np.arange(720) + LIDAR.yaw
    crossed: list[bool] = []
    for share in np.linspace(0.1, 0.95, 18):
        reach = np.maximum(scan.ranges_m - 0.08, 0.0) * share
        x, y = 2.0 + LIDAR.x + np.cos(angles) * reach, 2.0 + np.sin(angles) * reach
        crossed += [grid.at(a, b) != 0 for a, b in zip(x.tolist(), y.tolist(), strict=True)]
    assert np.mean(crossed) < 0.005


def test_a_home_with_a_way_out_is_refused() -> None:
    gap = ROOM.replace('pos="6.05 2 1.2"', 'pos="6.05 9 1.2"')
    with pytest.raises(OpenHomeError, match="way out"):
        _ = World(Scene(gap, {}, DOCK), options=PERFECT).grid


def test_a_thin_slanted_outline_marks_exactly_the_cells_it_crosses() -> None:
    cells = np.zeros((6, 6), bool)
    draw(cells, np.array([[0.5, 0.45], [5.5, 5.45], [5.5, 5.55], [0.5, 0.55]]))
    assert cells.diagonal().all()
    assert cells.sum() == 6


def test_cells_and_their_middles_agree() -> None:
    grid = OccupancyGrid(np.zeros((4, 8), np.int8), 0.05, -1.0, 2.0)
    assert grid.cell(*grid.centre(3, 5)) == (3, 5)
    assert grid.centres(np.array([3]), np.array([5]))[0].tolist() == pytest.approx(list(grid.centre(3, 5)))


def test_the_robot_can_stand_wherever_the_map_says_it_can_reach(world: World) -> None:
    rows, columns = np.nonzero(reachable(world.grid, DOCK, 0.189))
    for x, y in world.grid.centres(rows, columns)[::97].tolist():
        world.teleport(Pose2D(x=x, y=y, yaw=0.7))
        assert world.truth.touching == ()


def test_every_reachable_place_is_within_the_spacing_of_a_tour_stop(world: World) -> None:
    stops = np.array(tour_stops(world.grid, DOCK, spacing_m=1.2))
    rows, columns = np.nonzero(reachable(world.grid, DOCK, 0.24))
    places = world.grid.centres(rows, columns)
    nearest = np.hypot(*(places[:, None] - stops[None]).transpose(2, 0, 1)).min(1)
    assert nearest.max() <= 1.2
    assert len(stops) < 25


def test_a_tour_looks_all_round_at_every_stop(world: World) -> None:
    poses = tour_poses(world.grid, DOCK, headings=8)
    assert len(poses) == 8 * len(tour_stops(world.grid, DOCK))
    assert len({round(pose.yaw, 6) for pose in poses}) == 8


def test_tour_frames_come_with_the_pose_the_robot_believed() -> None:
    with World(SCENE, seed=1) as world:
        frames = list(tour_frames(world, headings=2))
        poses = tour_poses(world.grid, DOCK, headings=2)
    assert len(frames) == len(poses)
    for frame, pose in zip(frames, poses, strict=True):
        assert math.hypot(frame.estimate.pose.x - pose.x, frame.estimate.pose.y - pose.y) < 0.1
        assert frame.rgb.shape == (250, 250, 3)
        assert frame.depth_m.shape == (400, 640)
        assert frame.depth_m.max() > 0.0
