"""The least that an episode can take: the shortest drive from the start to where the thing counts as found."""

import math
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from skimage.graph import MCP_Geometric  # pyright: ignore[reportMissingTypeStubs, reportUnknownVariableType]

from contracts.geometry import Pose2D
from sim.nav.costmap import Costmap
from sim.nav.planner import plan
from sim.scoring import (
    AS_NEAR_AS_POSSIBLE_SLACK_M,
    camera_position,
    nearest_possible_m,
    nearest_surface_m,
    unobstructed,
)
from sim.world import ThingTruth, World
from sim.world.base import SPEED_MAX_M_S

TRIED_MAX = 400


def counts_within_m(world: World, thing: ThingTruth, wanted_m: float) -> float:
    """How near the camera must be: `wanted_m`, or as near as the map allows."""
    possible_m = nearest_possible_m(world, thing)
    return max(wanted_m, possible_m + AS_NEAR_AS_POSSIBLE_SLACK_M) if math.isfinite(possible_m) else wanted_m


class Ways:
    """Shortest ways from one place over the true floor of the World as it is."""

    def __init__(self, world: World, start: Pose2D) -> None:
        self._world = world
        self._start = start
        self._costmap = Costmap.from_map(world.grid)
        grid, free = self._costmap.grid, self._costmap.free
        price = np.where(free, 1.0, -1.0)
        cell = grid.cell(start.x, start.y)
        assert cell is not None, "a robot starts in its map"
        price[cell] = 1.0
        self._costmap.__dict__["price"] = price  # every way costs its length, whatever stands beside it
        search: Any = cast(Any, MCP_Geometric)(price, fully_connected=True)
        self.costs_m: NDArray[np.float64] = search.find_costs([cell])[0] * grid.resolution_m
        """(rows, columns) of the map; inf where no way leads."""

    def to_find_m(self, thing: ThingTruth, wanted_m: float) -> float:
        """The length of the shortest way to a place from which the thing counts as found; inf where there is none."""
        world, grid = self._world, self._costmap.grid
        within_m, volumes = counts_within_m(world, thing, wanted_m), world.volumes(thing.id)
        rows, columns = np.nonzero(np.isfinite(self.costs_m))
        centres = grid.centres(rows, columns)
        reach = within_m + 1.0
        near = np.hypot(centres[:, 0] - thing.x_m, centres[:, 1] - thing.y_m) <= reach
        order = np.argsort(self.costs_m[rows[near], columns[near]], kind="stable")
        tried = 0
        for x, y in centres[near][order].tolist():
            pose = Pose2D(x=x, y=y, yaw=math.atan2(thing.y_m - y, thing.x_m - x))
            camera = camera_position(pose)
            if nearest_surface_m(volumes, camera) > within_m:
                continue
            tried += 1
            if unobstructed(world, camera, thing):
                return self._length_m(pose)
            if tried >= TRIED_MAX:
                break
        return math.inf

    def _length_m(self, goal: Pose2D) -> float:
        return plan(self._costmap, self._start, goal).length_m


def floor_s(way_m: float) -> float:
    return way_m / SPEED_MAX_M_S
