"""The occupancy grid as an array, and the way between metres and cells."""

import base64
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from contracts.robot import Map

Mask = NDArray[np.bool_]
Cells = NDArray[np.intp]


class MalformedMapError(ValueError):
    """The map's data is not width * height cells."""


@dataclass(frozen=True, eq=False, slots=True)
class Grid:
    """`free` and `occupied` are (height, width), row 0 at the origin; neither means unknown. No rotated origins."""

    free: Mask
    occupied: Mask
    resolution_m: float
    origin_x_m: float
    origin_y_m: float

    @property
    def cell_area_m2(self) -> float:
        return self.resolution_m**2

    def cell(self, x_m: float, y_m: float) -> tuple[int, int] | None:
        """(row, column), or none outside the map."""
        row = int(np.floor((y_m - self.origin_y_m) / self.resolution_m))
        column = int(np.floor((x_m - self.origin_x_m) / self.resolution_m))
        height, width = self.free.shape
        return (row, column) if 0 <= row < height and 0 <= column < width else None

    def centre(self, row: int, column: int) -> tuple[float, float]:
        """(x, y) of a cell's middle, m."""
        return (
            self.origin_x_m + (column + 0.5) * self.resolution_m,
            self.origin_y_m + (row + 0.5) * self.resolution_m,
        )


FREE_MAX = 25
OCCUPIED_MIN = 65


def grid_from_map(message: Map) -> Grid:
    """Raises `MalformedMapError` when the data does not fit its size. Thresholds as in ROS map_server."""
    size = message.width * message.height
    try:
        raw = zlib.decompressobj().decompress(base64.b64decode(message.data_base64, validate=True), size + 1)
    except (ValueError, zlib.error) as error:
        raise MalformedMapError(str(error)) from error
    if len(raw) != size:
        raise MalformedMapError(f"{len(raw)} cells, {size} expected")
    cells = np.frombuffer(raw, dtype=np.int8).reshape(message.height, message.width)
    return Grid(
        free=(cells >= 0) & (cells <= FREE_MAX),
        occupied=cells >= OCCUPIED_MIN,
        resolution_m=message.resolution_m,
        origin_x_m=message.origin.x,
        origin_y_m=message.origin.y,
    )


def pose_at(grid: Grid, row: int, column: int, yaw: float = 0.0) -> Pose2D:
    x, y = grid.centre(row, column)
    return Pose2D(x=x, y=y, yaw=yaw)
