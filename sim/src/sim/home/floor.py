"""A raster of the home's floor that answers where a robot could stand, and from where it could see a thing."""

import math

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from sim.home.layout import HEIGHT_M, Layout

Mask = NDArray[np.bool_]
CELL_M = 0.05
STANDING_RADIUS_M = 0.36
"""Free disk a standing place needs; twice this is also the narrowest passage."""
APPROACH_M = 0.80
"""A thing must be seen from a standing place no farther than this from its centre."""
_EDGE = 4


class Floor:
    """Which cells are occupied; every layout wall with its foot on the floor is drawn at the start."""

    def __init__(self, layout: Layout) -> None:
        columns = math.ceil(layout.width_m / CELL_M) + 2 * _EDGE
        rows = math.ceil(layout.depth_m / CELL_M) + 2 * _EDGE
        self.x_m = ((np.arange(columns) - _EDGE + 0.5) * CELL_M)[None, :]
        self.y_m = ((np.arange(rows) - _EDGE + 0.5) * CELL_M)[:, None]
        inside = (self.x_m > 0) & (self.x_m < layout.width_m) & (self.y_m > 0) & (self.y_m < layout.depth_m)
        self.occupied: Mask = ~inside
        for wall in (w for w in layout.walls if w.z_min_m == 0.0 and w.z_max_m == HEIGHT_M):
            self.occupied |= (
                (self.x_m >= wall.x_min_m)
                & (self.x_m <= wall.x_max_m)
                & (self.y_m >= wall.y_min_m)
                & (self.y_m <= wall.y_max_m)
            )
        self._must_reach = [(d.x_m, d.y_m) for d in layout.doors]
        dock = layout.dock
        self._start = (dock.x_m - 0.6 * math.cos(dock.yaw), dock.y_m - 0.6 * math.sin(dock.yaw))

    def footprint(
        self, x_m: float, y_m: float, yaw: float, width_m: float, depth_m: float, *, grow_m: float = 0.0
    ) -> Mask:
        """Cells under a turned rectangle grown by `grow_m`."""
        c, s = math.cos(yaw), math.sin(yaw)
        half = CELL_M / 2 + grow_m
        rows, columns = self._window(x_m, y_m, math.hypot(width_m / 2 + half, depth_m / 2 + half))
        dx, dy = self.x_m[:, columns] - x_m, self.y_m[rows] - y_m
        inside = (np.abs(c * dx + s * dy) <= width_m / 2 + half) & (np.abs(c * dy - s * dx) <= depth_m / 2 + half)
        mask = np.zeros_like(self.occupied)
        mask[rows, columns] = inside
        return mask

    def _window(self, x_m: float, y_m: float, radius_m: float) -> tuple[slice, slice]:
        """Rows and columns of the cells within a square around a point."""
        row, column = self.cell(x_m, y_m)
        reach = math.ceil(radius_m / CELL_M) + 1
        return slice(max(0, row - reach), row + reach + 1), slice(max(0, column - reach), column + reach + 1)

    def clearance_m(self, occupied: Mask | None = None) -> NDArray[np.float64]:
        """Distance of each cell to the nearest occupied one, in m."""
        free = ~(self.occupied if occupied is None else occupied)
        return np.asarray(ndimage.distance_transform_edt(free), float) * CELL_M  # pyright: ignore[reportUnknownMemberType, reportUnknownArgumentType]

    def standing(self, occupied: Mask | None = None) -> Mask | None:
        """Cells where a robot can stand and that it can reach from the dock; None if that misses a doorway."""
        regions: NDArray[np.int32] = np.zeros(self.occupied.shape, np.int32)
        ndimage.label(self.clearance_m(occupied) >= STANDING_RADIUS_M, np.ones((3, 3)), output=regions)  # pyright: ignore[reportUnknownMemberType]
        home = int(regions[self.cell(*self._start)])
        if home == 0 or any(int(regions[self.cell(*point)]) != home for point in self._must_reach):
            return None
        return regions == home

    def cell(self, x_m: float, y_m: float) -> tuple[int, int]:
        """Row and column of a point."""
        return int(y_m / CELL_M) + _EDGE, int(x_m / CELL_M) + _EDGE

    def viewpoint(
        self,
        standing: Mask,
        x_m: float,
        y_m: float,
        see_through: Mask,
        *,
        front_yaw: float | None = None,
        occupied: Mask | None = None,
    ) -> tuple[float, float] | None:
        """The nearest standing place that sees (x, y) within `APPROACH_M`, or None.

        `see_through` cells (the thing and what carries it) do not hide it; with `front_yaw` only places within
        40 degrees of that direction count.
        """
        window = self._window(x_m, y_m, APPROACH_M)
        dx, dy = self.x_m[:, window[1]] - x_m, self.y_m[window[0]] - y_m
        distance = np.hypot(dx, dy)
        good = standing[window] & (distance <= APPROACH_M)
        if front_yaw is not None:
            ahead = math.cos(front_yaw) * dx + math.sin(front_yaw) * dy
            good &= ahead >= distance * math.cos(math.radians(40))
        rows, columns = np.nonzero(good)
        if len(rows) == 0:
            return None
        near = distance[rows, columns]
        rows, columns = rows + window[0].start, columns + window[1].start
        hides = (self.occupied if occupied is None else occupied) & ~see_through
        part = np.linspace(0.0, 1.0, 20)[None, :]
        xs = x_m + (self.x_m[0, columns][:, None] - x_m) * part
        ys = y_m + (self.y_m[rows, 0][:, None] - y_m) * part
        blocked = hides[(ys / CELL_M).astype(int) + _EDGE, (xs / CELL_M).astype(int) + _EDGE].any(axis=1)
        if blocked.all():
            return None
        reach = np.where(blocked, np.inf, near)
        best = int(np.argmin(reach))
        return float(self.x_m[0, columns[best]]), float(self.y_m[rows[best], 0])
