"""Draws the map: the grid as a small picture, and where that picture lies in the map. Pure."""

import hashlib
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from contracts.robot import Map
from geometry.grids import Mask, OccupancyGrid, decode

Points = NDArray[np.float64]
UNKNOWN, FREE, OCCUPIED = 0, 1, 2
MARGIN_CELLS = 4
# One picture for light and dark pages: colours that are part transparent, unknown wholly so.
PALETTE_RGB = ((0, 0, 0), (140, 155, 180), (86, 102, 126))
PALETTE_ALPHA = (0, 46, 255)


@dataclass(frozen=True, slots=True)
class MapFrame:
    """Where the picture lies in the map: pixels are cells, x right, y down."""

    grid: OccupancyGrid
    left_cell: int
    bottom_cell: int
    width_px: int
    height_px: int

    def to_px(self, x: float, y: float) -> tuple[float, float]:
        """A point of the map frame (m) in picture pixels."""
        column, row = self.pixels(np.array(x), np.array(y))
        return float(column), float(row)

    def pixels(self, x: Points, y: Points) -> tuple[Points, Points]:
        """Points of the map frame (m) in picture pixels, right and down."""
        columns, rows = self.grid.columns_and_rows(x, y)
        return columns - self.left_cell, self.height_px - (rows - self.bottom_cell)

    def to_map(self, x_px: float, y_px: float) -> tuple[float, float]:
        """A point of the picture in the map frame (m)."""
        columns, rows = np.array(x_px + self.left_cell), np.array(self.height_px - y_px + self.bottom_cell)
        x, y = self.grid.points(columns, rows)
        return float(x), float(y)

    def heading_deg(self, yaw: float) -> float:
        """Clockwise on the screen from pointing right, as CSS turns things."""
        return -math.degrees(yaw - self.grid.origin.yaw)

    def px(self, metres: float) -> float:
        return metres / self.grid.resolution_m


@dataclass(frozen=True, slots=True)
class MapPicture:
    png: bytes
    frame: MapFrame
    version: str


def picture(message: Map) -> MapPicture:
    """The known part of the map as an indexed PNG, one pixel a cell, y up. Raises `geometry.grids.MapError`."""
    grid = decode(message)
    rows, columns = _known(~grid.unknown)
    kinds = np.full(grid.cells.shape, UNKNOWN, np.uint8)
    kinds[grid.free], kinds[grid.occupied] = FREE, OCCUPIED
    kinds = kinds[rows, columns]
    frame = MapFrame(
        grid=grid,
        left_cell=columns.start,
        bottom_cell=rows.start,
        width_px=kinds.shape[1],
        height_px=kinds.shape[0],
    )
    return MapPicture(png=_png(np.flipud(kinds)), frame=frame, version=version(message))


def fit(frame: MapFrame, corners: Sequence[tuple[float, float]], width: int, height: int) -> list[float]:
    """(a, b, c, d, e, f) as a canvas takes it: from cells of a grid to pixels of the map picture. `corners`: (x, y) in
    map of its origin, of the end of its first row, and of the end of its first column.
    """
    (x, y), (along_x, along_y), (up_x, up_y) = (frame.to_px(*corner) for corner in corners)
    a, b = (along_x - x) / width, (along_y - y) / width
    c, d = (up_x - x) / height, (up_y - y) / height
    return [round(value, 6) for value in (a, b, c, d, x, y)]


def version(grid: Map) -> str:
    """Another word for another map, for caches."""
    return hashlib.sha256(grid.model_dump_json().encode()).hexdigest()[:12]


def _known(known: Mask) -> tuple[slice, slice]:
    """Rows and columns that hold something known, with a margin; all of them when nothing is known."""
    rows = np.flatnonzero(known.any(axis=1))
    columns = np.flatnonzero(known.any(axis=0))
    height, width = known.shape
    if rows.size == 0:
        return slice(0, height), slice(0, width)
    return (
        slice(max(0, int(rows[0]) - MARGIN_CELLS), min(height, int(rows[-1]) + 1 + MARGIN_CELLS)),
        slice(max(0, int(columns[0]) - MARGIN_CELLS), min(width, int(columns[-1]) + 1 + MARGIN_CELLS)),
    )


def _png(kinds: NDArray[np.uint8]) -> bytes:
    image = Image.fromarray(kinds)
    image.putpalette([value for colour in PALETTE_RGB for value in colour])
    out = io.BytesIO()
    image.save(out, "PNG", transparency=bytes(PALETTE_ALPHA), optimize=True)
    return out.getvalue()
