"""The map as the stand-in for Nav2 plans on it: occupied cells, clearance to them, and the price of each cell."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage  # pyright: ignore[reportMissingTypeStubs]

from sim.world.robot import ROBOT_RADIUS_M
from sim.world.types import OccupancyGrid

_PRICE_AT_CONTACT: Final = 8.0
_PRICE_DECAY_PER_M: Final = 5.0

Cell = tuple[int, int]
"""Row (along y) and column (along x), both from the map's origin."""


@dataclass(frozen=True)
class Grid:
    """Where the cells of a map lie: `rows` x `columns` of `resolution_m`, row 0 and column 0 at the origin."""

    rows: int
    columns: int
    resolution_m: float
    origin_x_m: float
    origin_y_m: float

    def cell(self, x_m: float, y_m: float) -> Cell | None:
        """The cell that holds a point of the map frame, or none outside the map."""
        row = int(np.floor((y_m - self.origin_y_m) / self.resolution_m))
        column = int(np.floor((x_m - self.origin_x_m) / self.resolution_m))
        return (row, column) if 0 <= row < self.rows and 0 <= column < self.columns else None

    def cells(self, points_m: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Rows and columns of (N, 2) points; points outside the map are clipped to its border."""
        scaled = np.floor((points_m - (self.origin_x_m, self.origin_y_m)) / self.resolution_m).astype(np.intp)
        return np.clip(scaled[:, 1], 0, self.rows - 1), np.clip(scaled[:, 0], 0, self.columns - 1)

    def centres(self, rows: NDArray[Any], columns: NDArray[Any]) -> NDArray[np.float64]:
        """(N, 2) centres in m of the given cells."""
        x = self.origin_x_m + (columns + 0.5) * self.resolution_m
        y = self.origin_y_m + (rows + 0.5) * self.resolution_m
        return np.stack([x, y], axis=-1).astype(np.float64)


@dataclass(frozen=True)
class Costmap:
    """An immutable costmap; `occupied` is (rows, columns) bool, unknown cells count as occupied."""

    grid: Grid
    occupied: NDArray[np.bool_]
    robot_radius_m: float = ROBOT_RADIUS_M

    @classmethod
    def from_map(cls, recorded: OccupancyGrid) -> "Costmap":
        """From the recorded map; a cell of 50 and more counts as occupied."""
        rows, columns = recorded.data.shape
        grid = Grid(rows, columns, recorded.resolution_m, recorded.origin_x_m, recorded.origin_y_m)
        return cls(grid, (recorded.data < 0) | (recorded.data >= 50))

    def with_obstacles(self, marked: NDArray[np.bool_]) -> "Costmap":
        """This map with more cells occupied; (rows, columns) bool."""
        return Costmap(self.grid, self.occupied | marked, self.robot_radius_m) if marked.any() else self

    @cached_property
    def clearance_m(self) -> NDArray[np.float64]:
        """(rows, columns) distance in m from each cell's centre to the nearest occupied cell's centre."""
        if not self.occupied.any():
            return np.full(self.occupied.shape, 1e3)
        distance: NDArray[np.float64] = cast(Any, ndimage).distance_transform_edt(~self.occupied)
        return distance * self.grid.resolution_m

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """(rows, columns): the robot's centre may be here."""
        return self.clearance_m >= self.robot_radius_m

    @cached_property
    def price(self) -> NDArray[np.float64]:
        """(rows, columns): 1 far from everything, rising towards obstacles, -1 where the robot cannot be."""
        beyond = np.maximum(self.clearance_m - self.robot_radius_m, 0.0)
        return np.where(self.free, 1.0 + _PRICE_AT_CONTACT * np.exp(-_PRICE_DECAY_PER_M * beyond), -1.0)
