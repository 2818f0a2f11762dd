"""What has been looked at: line of sight on the grid, and the share of the free space seen so far."""

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from geometry.grids import Mask, OccupancyGrid

RAYS_PER_RAD = 40.0


def sight_lines(
    blocked: Mask, rows: NDArray[np.float64], columns: NDArray[np.float64], angles_rad: NDArray[np.float64], reach: int
) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Rays from each origin (in cells), one cell a step, until something blocks them.

    Returns flat cell indices (origins, rays, reach) and whether each is in sight: (origins, rays, reach).
    """
    steps = np.arange(reach + 1)
    r = rows[:, None, None] + np.sin(angles_rad)[None, :, None] * steps
    c = columns[:, None, None] + np.cos(angles_rad)[None, :, None] * steps
    ri, ci = np.rint(r).astype(np.intp), np.rint(c).astype(np.intp)
    inside = (ri >= 0) & (ri < blocked.shape[0]) & (ci >= 0) & (ci < blocked.shape[1])
    flat = np.where(inside, ri * blocked.shape[1] + ci, 0)
    clear = inside & ~blocked.ravel()[flat]
    return flat, np.logical_and.accumulate(clear, axis=2)


class CoverageTracker:
    """Marks what the camera saw; one per map and mission."""

    def __init__(self, grid: OccupancyGrid, within: Mask | None = None) -> None:
        self.grid = grid
        self.within: Mask | None = within
        """The cells that are to be looked at; none: all."""
        self.seen: Mask = np.zeros_like(grid.free)
        self._wanted: Mask = grid.free if within is None else grid.free & within
        self._wanted_cells = int(self._wanted.sum())

    @property
    def share(self) -> float | None:
        """Of the free space that is to be looked at, 0 to 1; none where there is none."""
        return float((self.seen & self._wanted).sum()) / self._wanted_cells if self._wanted_cells else None

    def mark(self, pose: Pose2D, *, hfov_rad: float, reach_m: float) -> None:
        """The wedge before the camera, as far as nothing hides it."""
        cell = self.grid.cell(pose.x, pose.y)
        if cell is None:
            return
        count = max(3, int(hfov_rad * RAYS_PER_RAD))
        angles = pose.yaw - self.grid.origin.yaw + np.linspace(-hfov_rad / 2, hfov_rad / 2, count)
        reach = int(reach_m / self.grid.resolution_m)
        origin = np.array([float(cell[0])]), np.array([float(cell[1])])
        flat, clear = sight_lines(~self.grid.free, *origin, angles, reach)
        self.seen.ravel()[flat[clear]] = True
