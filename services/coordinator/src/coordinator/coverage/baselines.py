"""Coverage to compare with: the nearest frontier of what was seen (Yamauchi, 1997), and viewpoints in random order."""

from dataclasses import replace

import numpy as np

from contracts.geometry import Pose2D
from coordinator.coverage.lawnmower import ROOM_M, Coverage, clearance_cells, pose_at, safe_cells, trouble_of
from coordinator.coverage.untyped import label_regions, maximum_filter
from geometry.grids import Mask, OccupancyGrid

FRONTIER_CELLS_MIN = 8
AVOID_M = 0.35


def nearest_frontiers(
    grid: OccupancyGrid,
    *,
    radius_m: float,
    start: Pose2D | None,
    seen: Mask,
    avoid: tuple[Pose2D, ...],
    within: Mask | None = None,
) -> Coverage:
    """For each border between seen and unseen free space the place to stand nearest to its middle; nearest first. Of
    `within` alone: where nothing of it was seen, all of it is one border.
    """
    standing = np.argwhere(safe_cells(grid.free, clearance_cells(grid.resolution_m, radius_m + ROOM_M)))
    for pose in avoid:
        x, y = grid.points(standing[:, 1] + 0.5, standing[:, 0] + 0.5)
        standing = standing[np.hypot(x - pose.x, y - pose.y) > AVOID_M]
    wanted = grid.free if within is None else grid.free & within
    begun = seen & wanted
    border = wanted & ~seen & maximum_filter(begun, 3) if begun.any() else wanted
    labels, count = label_regions(maximum_filter(border, 3))
    sizes = np.bincount(labels[border], minlength=count + 1)
    middles = [
        np.argwhere(border & (labels == k)).mean(axis=0) for k in range(1, count + 1) if sizes[k] >= FRONTIER_CELLS_MIN
    ]
    if not len(standing) or not middles:
        return Coverage((), count, grid.free_area_m2, trouble_of(grid, fits=bool(len(standing))))
    cells = dict.fromkeys(int(np.argmin(((standing - middle) ** 2).sum(axis=1))) for middle in middles)
    points = [pose_at(grid, int(standing[cell, 0]), int(standing[cell, 1])) for cell in cells]
    if start is not None:
        points.sort(key=lambda point: np.hypot(point.x - start.x, point.y - start.y))
    return Coverage(tuple(points), count, grid.free_area_m2)


def in_random_order(coverage: Coverage) -> Coverage:
    """The same for the same points: a mission can be decided again."""
    order = np.random.default_rng(len(coverage.points)).permutation(len(coverage.points))
    return replace(coverage, points=tuple(coverage.points[int(k)] for k in order.tolist()))
