"""Draws the map: the grid as a small picture, and where that picture lies in the map. Pure."""

import base64
import binascii
import hashlib
import io
import math
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from contracts.geometry import Pose2D
from contracts.robot import Map

UNKNOWN, FREE, OCCUPIED = 0, 1, 2
OCCUPIED_FROM = 65
MARGIN_CELLS = 4
# One picture for light and dark pages: colours that are part transparent, unknown wholly so.
PALETTE_RGB = ((0, 0, 0), (140, 155, 180), (86, 102, 126))
PALETTE_ALPHA = (0, 46, 255)


class MapError(ValueError):
    """A map whose data is not what its fields say."""


@dataclass(frozen=True, slots=True)
class MapFrame:
    """Where the picture lies in the map: pixels are cells, x right, y down."""

    resolution_m: float
    origin: Pose2D
    left_cell: int
    bottom_cell: int
    width_px: int
    height_px: int

    def to_px(self, x: float, y: float) -> tuple[float, float]:
        """A point of the map frame (m) in picture pixels."""
        dx, dy = x - self.origin.x, y - self.origin.y
        cos, sin = math.cos(-self.origin.yaw), math.sin(-self.origin.yaw)
        column = (cos * dx - sin * dy) / self.resolution_m
        row = (sin * dx + cos * dy) / self.resolution_m
        return column - self.left_cell, self.height_px - (row - self.bottom_cell)

    def to_map(self, x_px: float, y_px: float) -> tuple[float, float]:
        """A point of the picture in the map frame (m)."""
        column = (x_px + self.left_cell) * self.resolution_m
        row = (self.height_px - y_px + self.bottom_cell) * self.resolution_m
        cos, sin = math.cos(self.origin.yaw), math.sin(self.origin.yaw)
        return self.origin.x + cos * column - sin * row, self.origin.y + sin * column + cos * row

    def heading_deg(self, yaw: float) -> float:
        """Clockwise on the screen from pointing right, as CSS turns things."""
        return -math.degrees(yaw - self.origin.yaw)

    def px(self, metres: float) -> float:
        return metres / self.resolution_m


@dataclass(frozen=True, slots=True)
class MapPicture:
    png: bytes
    frame: MapFrame
    version: str


def picture(grid: Map) -> MapPicture:
    """The known part of the map as an indexed PNG, one pixel a cell, y up. Raises `MapError`."""
    cells = decode(grid)
    rows, columns = _known(cells)
    cropped = cells[rows, columns]
    kinds = np.where(cropped < 0, UNKNOWN, np.where(cropped >= OCCUPIED_FROM, OCCUPIED, FREE)).astype(np.uint8)
    frame = MapFrame(
        resolution_m=grid.resolution_m,
        origin=grid.origin,
        left_cell=columns.start,
        bottom_cell=rows.start,
        width_px=kinds.shape[1],
        height_px=kinds.shape[0],
    )
    return MapPicture(png=_png(np.flipud(kinds)), frame=frame, version=version(grid))


def version(grid: Map) -> str:
    """Another word for another map, for caches."""
    return hashlib.sha256(grid.model_dump_json().encode()).hexdigest()[:12]


def decode(grid: Map) -> NDArray[np.int8]:
    """int8 (height, width), row 0 at the origin."""
    size = grid.width * grid.height
    unpacking = zlib.decompressobj()
    try:
        raw = unpacking.decompress(base64.b64decode(grid.data_base64, validate=True), size)
    except (binascii.Error, zlib.error) as error:
        raise MapError(f"the map's cells cannot be unpacked: {error}") from error
    if len(raw) != size:
        raise MapError(f"the map holds {len(raw)} cells, not {grid.width} x {grid.height}")
    return np.frombuffer(raw, np.int8).reshape(grid.height, grid.width)


def _known(cells: NDArray[np.int8]) -> tuple[slice, slice]:
    """Rows and columns that hold something known, with a margin; all of them when nothing is known."""
    rows = np.flatnonzero((cells >= 0).any(axis=1))
    columns = np.flatnonzero((cells >= 0).any(axis=0))
    height, width = cells.shape
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
