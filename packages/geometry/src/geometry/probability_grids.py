"""A grid of probabilities as a message: levels of the logarithm, one byte a cell.

Probabilities of a search span many powers of ten, and which of two cells is likelier matters more than by how much:
even steps of the logarithm keep each cell to within 2 % of itself down to 1/10 000 of the most probable one.
"""

import base64
import math
import zlib

import numpy as np
from numpy.typing import NDArray

from contracts.belief import PROBABILITY_CELLS_MAX, PROBABILITY_DECADES, ProbabilityGrid
from contracts.geometry import Pose2D
from contracts.rooms import RoomGrid

LEVEL_MAX = 255
DECADES_A_LEVEL = PROBABILITY_DECADES / (LEVEL_MAX - 1)

Probabilities = NDArray[np.float64]
"""(height, width), row 0 at the origin."""


Point = tuple[float, float]
"""x and y in the map frame, m."""


class ProbabilityGridError(ValueError):
    """A grid whose data is not what its fields say."""


def encode(cells: Probabilities, *, resolution_m: float, origin: Pose2D) -> ProbabilityGrid:
    """The message; where the cells are more than it may hold, blocks of them are summed to larger ones."""
    cells, factor = _that_fit(cells)
    peak = float(cells.max())
    levels = np.zeros(cells.shape, np.uint8)
    told = cells > peak * 10.0**-PROBABILITY_DECADES
    levels[told] = np.rint(LEVEL_MAX + np.log10(cells[told] / peak) / DECADES_A_LEVEL).astype(np.uint8)
    height, width = cells.shape
    return ProbabilityGrid(
        width=width,
        height=height,
        resolution_m=resolution_m * factor,
        origin=origin,
        peak=min(1.0, peak),
        levels_base64=base64.b64encode(zlib.compress(levels.tobytes(), level=6)).decode("ascii"),
    )


def decode(message: ProbabilityGrid) -> Probabilities:
    """Raises `ProbabilityGridError`. Unpacks no more than the cells that the message's size allows."""
    size = message.width * message.height
    try:
        raw = zlib.decompressobj().decompress(base64.b64decode(message.levels_base64, validate=True), size + 1)
    except (ValueError, zlib.error) as error:  # binascii's error is a ValueError
        raise ProbabilityGridError(f"the levels cannot be unpacked: {error}") from error
    if len(raw) != size:
        raise ProbabilityGridError(f"it holds {len(raw)} cells, not {message.width} x {message.height}")
    levels = np.frombuffer(raw, np.uint8).reshape(message.height, message.width).astype(float)
    return np.where(levels > 0, message.peak * 10.0 ** ((levels - LEVEL_MAX) * DECADES_A_LEVEL), 0.0)


def corners(message: ProbabilityGrid | RoomGrid) -> tuple[Point, Point, Point]:
    """(x, y) in map of its origin, of the end of its first row, and of the end of its first column."""
    c, s = math.cos(message.origin.yaw), math.sin(message.origin.yaw)
    x, y = message.origin.x, message.origin.y
    along, up = message.width * message.resolution_m, message.height * message.resolution_m
    return (x, y), (x + c * along, y + s * along), (x - s * up, y + c * up)


def _that_fit(cells: Probabilities) -> tuple[Probabilities, int]:
    """The cells, and how many of those given one of them is wide."""
    factor = 1
    while math.prod(-(-side // factor) for side in cells.shape) > PROBABILITY_CELLS_MAX:
        factor += 1
    if factor == 1:
        return cells, 1
    rows, columns = (-(-side // factor) for side in cells.shape)
    padded = np.zeros((rows * factor, columns * factor))
    padded[: cells.shape[0], : cells.shape[1]] = cells
    return padded.reshape(rows, factor, columns, factor).sum(axis=(1, 3)), factor
