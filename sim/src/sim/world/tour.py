"""The tour somebody once drove to record the map: poses that see every room, and what the cameras saw at each."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from geometry.poses import wrap
from sim.world.occupancy import clearance_m as clearance
from sim.world.occupancy import reachable
from sim.world.types import OccupancyGrid, PoseEstimate
from sim.world.world import Floats, Pixels, World

SPACING_M = 1.6
HEADINGS = 8
CLEARANCE_M = 0.24
STOPS_MAX = 200


def tour_stops(
    grid: OccupancyGrid, start: Pose2D, *, spacing_m: float = SPACING_M, clearance_m: float = CLEARANCE_M
) -> tuple[tuple[float, float], ...]:
    """Places (x, y in m), so many that every place a robot can reach is within `spacing_m` of one, in driving order.

    Greedy: the roomiest reachable place not yet near a stop is the next one; then from the start always to the nearest
    one left.
    """
    open_cells = reachable(grid, start, clearance_m)
    rows, columns = np.nonzero(open_cells)
    if len(rows) == 0:
        return ()
    places = grid.centres(rows, columns)
    rank = np.minimum(clearance(grid)[rows, columns], 0.6)
    left = np.ones(len(rows), bool)
    stops: list[NDArray[np.float64]] = []
    while left.any() and len(stops) < STOPS_MAX:
        chosen = places[int(np.argmax(np.where(left, rank, -1.0)))]
        stops.append(chosen)
        left &= np.hypot(*(places - chosen).T) > spacing_m
    return _in_driving_order(stops, np.array([start.x, start.y]))


def _in_driving_order(stops: list[NDArray[np.float64]], here: NDArray[np.float64]) -> tuple[tuple[float, float], ...]:
    left, ordered = list(stops), list[tuple[float, float]]()
    while left:
        nearest = min(range(len(left)), key=lambda k: float(np.hypot(*(left[k] - here))))
        here = left.pop(nearest)
        ordered.append((float(here[0]), float(here[1])))
    return tuple(ordered)


def tour_poses(
    grid: OccupancyGrid,
    start: Pose2D,
    *,
    spacing_m: float = SPACING_M,
    clearance_m: float = CLEARANCE_M,
    headings: int = HEADINGS,
) -> tuple[Pose2D, ...]:
    """Every stop of `tour_stops` with a full turn of evenly spaced headings (rad)."""
    turn = [wrap(2 * math.pi * k / headings) for k in range(headings)]
    stops = tour_stops(grid, start, spacing_m=spacing_m, clearance_m=clearance_m)
    return tuple(Pose2D(x=x, y=y, yaw=yaw) for x, y in stops for yaw in turn)


@dataclass(frozen=True)
class TourFrame:
    """One picture of the tour. `rgb`: uint8 (250, 250, 3); `depth_m`: as `World.depth` of the same moment."""

    estimate: PoseEstimate
    rgb: Pixels
    depth_m: Floats


def tour_frames(
    world: World,
    *,
    spacing_m: float = SPACING_M,
    clearance_m: float = CLEARANCE_M,
    headings: int = HEADINGS,
    seconds_per_frame: float = 0.5,
) -> Iterator[TourFrame]:
    """Where the robot believed to be and what its two cameras saw at each pose of the tour.

    The robot does not drive: it is teleported from pose to pose, and left at the last one with its odometry unaware.
    It stands in for a drive by hand while mapping; give it a world of its own.
    """
    for pose in tour_poses(
        world.grid, world.scene.dock, spacing_m=spacing_m, clearance_m=clearance_m, headings=headings
    ):
        world.teleport(pose)
        world.advance(seconds_per_frame)
        yield TourFrame(world.localization(), world.rgb(), world.depth())
