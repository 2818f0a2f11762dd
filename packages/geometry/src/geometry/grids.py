"""The occupancy grid: the one reading of a map's cells and of its origin, for every service.

Cells are what ROS says they are (nav_msgs/OccupancyGrid), read with map_server's thresholds: 0 to 25 is free, 65 to
100 is occupied, and a value between (its mode `scale`) is neither: nobody is sent there, and nothing is hidden by it.
Every other value (-1, 255, and what its mode `raw` may hold) is unknown. The origin is the pose of the corner of cell
(0, 0) in the map frame, and may be turned.
"""

import base64
import math
import zlib
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contracts.geometry import Pose2D
from contracts.robot import Map

Mask = NDArray[np.bool_]
"""(height, width) of a grid."""

UNKNOWN, OCCUPIED = -1, 100
FREE_MAX = 25
OCCUPIED_MIN = 65


class MapError(ValueError):
    """A map whose data is not what its fields say."""


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """`cells` is (height, width) int8, row 0 at the origin. Make one of raw values with `of_values`."""

    cells: NDArray[np.int8]
    resolution_m: float
    origin: Pose2D

    @cached_property
    def free(self) -> Mask:
        return (self.cells >= 0) & (self.cells <= FREE_MAX)

    @cached_property
    def occupied(self) -> Mask:
        return self.cells >= OCCUPIED_MIN

    @cached_property
    def unknown(self) -> Mask:
        return self.cells < 0

    @property
    def free_area_m2(self) -> float:
        return float(np.count_nonzero(self.free)) * self.resolution_m**2

    def columns_and_rows(self, x_m: NDArray[Any], y_m: NDArray[Any]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Points of the map frame in cells from the origin, along the grid's own axes; not rounded."""
        c, s = math.cos(self.origin.yaw), math.sin(self.origin.yaw)
        dx, dy = np.asarray(x_m, float) - self.origin.x, np.asarray(y_m, float) - self.origin.y
        return (c * dx + s * dy) / self.resolution_m, (c * dy - s * dx) / self.resolution_m

    def points(self, columns: ArrayLike, rows: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """x and y in the map frame, m: the other way. (0, 0) is the origin, (0.5, 0.5) the middle of the first cell."""
        c, s = math.cos(self.origin.yaw), math.sin(self.origin.yaw)
        dx, dy = np.asarray(columns, float) * self.resolution_m, np.asarray(rows, float) * self.resolution_m
        return self.origin.x + c * dx - s * dy, self.origin.y + s * dx + c * dy

    def cell(self, x_m: float, y_m: float) -> tuple[int, int] | None:
        """(row, column); none outside the map."""
        columns, rows = self.columns_and_rows(np.array(x_m), np.array(y_m))
        row, column = math.floor(float(rows)), math.floor(float(columns))
        height, width = self.cells.shape
        return (row, column) if 0 <= row < height and 0 <= column < width else None

    def centre(self, row: int, column: int) -> tuple[float, float]:
        """(x, y) of a cell's middle in the map frame, m."""
        x, y = self.points(column + 0.5, row + 0.5)
        return float(x), float(y)

    def at(self, x_m: NDArray[Any], y_m: NDArray[Any], mask: Mask) -> Mask:
        """What `mask` says of each point; false outside the map."""
        columns, rows = (np.floor(each).astype(np.intp) for each in self.columns_and_rows(x_m, y_m))
        height, width = self.cells.shape
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        return np.asarray(inside & mask[np.where(inside, rows, 0), np.where(inside, columns, 0)])


def of_values(values: NDArray[Any], width: int, height: int, resolution_m: float, origin: Pose2D) -> OccupancyGrid:
    """A grid of width x height raw cell values, row by row. Raises `MapError` where their number is another."""
    if values.size != width * height:
        raise MapError(f"the map holds {values.size} cells, not {width} x {height}")
    cells = np.asarray(values).reshape(height, width)
    odd = (cells < UNKNOWN) | (cells > OCCUPIED)
    known = np.where(odd, UNKNOWN, cells) if odd.any() else cells
    return OccupancyGrid(np.ascontiguousarray(known, np.int8), resolution_m, origin)


def decode(message: Map) -> OccupancyGrid:
    """Raises `MapError`. Unpacks no more than the cells that the message's size allows."""
    size = message.width * message.height
    try:
        raw = zlib.decompressobj().decompress(base64.b64decode(message.data_base64, validate=True), size + 1)
    except (ValueError, zlib.error) as error:  # binascii's error is a ValueError
        raise MapError(f"the map's cells cannot be unpacked: {error}") from error
    return of_values(np.frombuffer(raw, np.int8), message.width, message.height, message.resolution_m, message.origin)


def encode(grid: OccupancyGrid) -> Map:
    """The grid as a message. Raises pydantic's `ValidationError` where it is larger than a message may be."""
    height, width = grid.cells.shape
    return Map(
        width=width,
        height=height,
        resolution_m=grid.resolution_m,
        origin=grid.origin,
        data_base64=base64.b64encode(zlib.compress(grid.cells.tobytes(), level=6)).decode("ascii"),
    )


def coarser(grid: OccupancyGrid, factor: int) -> OccupancyGrid:
    """`factor` x `factor` cells become one: the most occupied of them, else unknown if any is, else free."""
    height, width = (-(-side // factor) for side in grid.cells.shape)
    padded = np.full((height * factor, width * factor), UNKNOWN, np.int8)
    padded[: grid.cells.shape[0], : grid.cells.shape[1]] = grid.cells
    blocks = padded.reshape(height, factor, width, factor)
    most, least = blocks.max(axis=(1, 3)), blocks.min(axis=(1, 3))
    cells = np.where((least < 0) & (most < OCCUPIED_MIN), np.int8(UNKNOWN), most)
    return OccupancyGrid(np.ascontiguousarray(cells, np.int8), grid.resolution_m * factor, grid.origin)
