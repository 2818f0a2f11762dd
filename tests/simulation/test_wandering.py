"""A minute of wandering through a generated home: the world holds together, and says how fast it ran."""

import logging
import math
import time

import numpy as np
import pytest

from contracts.geometry import Pose2D
from sim.home import Home, Wanted
from sim.scoring import nearest_possible_m, score
from sim.world import Scan, World
from sim.world.occupancy import reachable
from sim.world.robot import LIDAR
from sim.world.tour import tour_stops

MINUTE_S = 60.0


@pytest.fixture(scope="module")
def home() -> Home:
    return Home.generate(11, wanted=Wanted("bottle", "red"))


def _wander(scan: Scan) -> tuple[float, float]:
    """Straight on, or turn left while something is near ahead."""
    ahead = np.abs(LIDAR.yaw + scan.angle_min + scan.angle_increment * np.arange(scan.ranges_m.size)) < 0.6
    return (0.26, 0.05) if scan.ranges_m[ahead].min() > 0.5 else (0.0, 0.9)


def test_a_minute_of_wandering_with_every_sensor(home: Home) -> None:
    with World(home, seed=5) as world:
        stops = tour_stops(world.grid, world.scene.dock)
        world.teleport(Pose2D(x=stops[0][0], y=stops[0][1], yaw=0.0))
        world.rgb(), world.depth()
        began = time.perf_counter()
        command = (0.0, 0.0)
        for tick in range(round(MINUTE_S * 20)):
            if tick % 2 == 0:
                command = _wander(world.scan())
            if tick % 10 == 0:
                assert world.rgb().shape == (250, 250, 3)
                assert world.depth().shape == (400, 640)
            world.command(*command)
            world.advance(0.05)
        logging.getLogger(__name__).info("%.1f times real time", MINUTE_S / (time.perf_counter() - began))
        truth, told = world.truth, world.localization().pose
        assert truth.path_length_m > 4.0
        assert world.time_s == pytest.approx(MINUTE_S)
        assert world.grid.at(truth.pose.x, truth.pose.y) == 0
        assert math.hypot(truth.pose.x - told.x, truth.pose.y - told.y) < 0.1
        assert world.battery().percentage < world.options.battery_percentage


def test_the_robot_begins_docked_and_touches_nothing(home: Home) -> None:
    world = World(home)
    world.advance(1.0)
    assert world.dock_status().is_docked
    assert world.hazards() == ()
    assert world.truth.touching == ()
    assert world.truth.path_length_m < 0.01


def test_every_findable_thing_can_be_arrived_at(home: Home) -> None:
    world = World(home)
    wanted = next(thing for thing in world.truth.things if (thing.kind, thing.colour) == ("bottle", "red"))
    assert nearest_possible_m(world, wanted) < 0.6
    assert not score(world, "bottle", "red").correct


def test_the_map_is_one_connected_home(home: Home) -> None:
    world = World(home)
    open_m2 = reachable(world.grid, world.scene.dock, 0.189).sum() * world.grid.resolution_m**2
    assert open_m2 > 0.35 * sum(room.area_m2 for room in home.rooms)
