"""Where to stand so that everything free is looked at: the lawnmower of requirement A6, exactly."""

import math
from dataclasses import dataclass

import numpy as np

from contracts.geometry import Pose2D
from contracts.mission import MapTrouble
from coordinator.coverage.untyped import label_regions, minimum_filter, region_boxes
from geometry.grids import Mask, OccupancyGrid

ROW_SPACING_M = 1.0
ROOM_M = 0.20
"""Beside the footprint."""
REGION_CELLS_MIN = 256


@dataclass(frozen=True, slots=True)
class Coverage:
    """Points in the order they are to be visited."""

    points: tuple[Pose2D, ...]
    regions: int
    free_area_m2: float
    trouble: MapTrouble | None = None
    """Why there are no points. None, and no points: nothing is left to be looked at."""


def clearance_cells(resolution_m: float, clearance_m: float) -> int:
    return math.ceil(round(clearance_m / resolution_m, 6))


def safe_cells(free: Mask, cells: int) -> Mask:
    """Cells whose whole (2n+1) x (2n+1) neighbourhood is free; what lies outside the map is not."""
    return minimum_filter(free, 2 * cells + 1)


def lawnmower(
    grid: OccupancyGrid, *, radius_m: float, spacing_m: float = ROW_SPACING_M, within: Mask | None = None
) -> Coverage:
    """Rows 1.0 m apart over the safe cells, alternating direction; then a point in every safe region of more than
    256 cells that the rows missed: the cell of that region nearest its centroid. Of `within` alone.
    """
    safe = safe_cells(grid.free, clearance_cells(grid.resolution_m, radius_m + ROOM_M))
    fits = bool(safe.any())
    if within is not None:
        safe &= within
    stride = max(1, round(spacing_m / grid.resolution_m))
    cells: list[tuple[int, int]] = []
    for k, row in enumerate(range(stride // 2, safe.shape[0], stride)):
        columns = [c for c in range(stride // 2, safe.shape[1], stride) if safe[row, c]]
        cells += [(row, c) for c in (columns if k % 2 == 0 else reversed(columns))]
    labels, count = label_regions(safe)
    reached = {int(labels[cell]) for cell in cells}
    sizes = np.bincount(labels.ravel(), minlength=count + 1)
    missed = [r for r in range(1, count + 1) if r not in reached and sizes[r] > REGION_CELLS_MIN]
    boxes = region_boxes(labels)
    for region in missed:
        box = boxes[region - 1]
        rows, columns = np.nonzero(labels[box] == region)
        nearest = int(np.argmin((rows - rows.mean()) ** 2 + (columns - columns.mean()) ** 2))
        cells.append((int(rows[nearest]) + box[0].start, int(columns[nearest]) + box[1].start))
    points = tuple(pose_at(grid, row, column) for row, column in cells)
    trouble = None if points else trouble_of(grid, fits=fits)
    return Coverage(points, count, grid.free_area_m2, trouble)


def trouble_of(grid: OccupancyGrid, *, fits: bool) -> MapTrouble | None:
    """What is wrong with a map on which nobody can search; `fits`: the robot has room somewhere on it."""
    if not grid.free.any():
        return MapTrouble.NO_FREE_SPACE
    return None if fits else MapTrouble.NO_ROOM


def pose_at(grid: OccupancyGrid, row: int, column: int) -> Pose2D:
    """The middle of a cell, in map; which way one stands there does not matter."""
    x, y = grid.centre(row, column)
    return Pose2D(x=x, y=y, yaw=0.0)
