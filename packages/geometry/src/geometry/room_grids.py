"""Where the rooms of a map lie, as a message: the number of a room in each cell, one byte a cell. Pure."""

import base64
import zlib
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from contracts.rooms import ROOMS_MAX, RoomGrid
from geometry.grids import Mask
from geometry.rooms import Rooms


class RoomGridError(ValueError):
    """A grid of rooms whose data is not what its fields say."""


@dataclass(frozen=True, eq=False, slots=True)
class RoomCells:
    """`ids` is (height, width) int64: the id of the room that each cell is of, 0 for none; row 0 at the origin."""

    ids: NDArray[np.int64]
    resolution_m: float
    origin: Pose2D

    def of(self, some: Collection[int]) -> Mask:
        """(height, width): the cells of these rooms."""
        return np.asarray(np.isin(self.ids, list(some)) & (self.ids > 0))


def encode(rooms: Rooms, ids: Mapping[int, int], *, map_id: str) -> RoomGrid:
    """The rooms of which `ids` names the id by its number, the first 200 of them; the others are no rooms."""
    told = sorted(ids)[:ROOMS_MAX]
    values = np.zeros(int(rooms.labels.max()) + 1, np.uint8)
    known = [number for number in told if number < len(values)]
    values[known] = np.arange(1, len(known) + 1, dtype=np.uint8)
    cells = values[rooms.labels]
    height, width = cells.shape
    return RoomGrid(
        map_id=map_id,
        width=width,
        height=height,
        resolution_m=rooms.grid.resolution_m,
        origin=rooms.grid.origin,
        ids=tuple(ids[number] for number in known),
        cells_base64=base64.b64encode(zlib.compress(cells.tobytes(), level=6)).decode("ascii"),
    )


def decode(message: RoomGrid) -> RoomCells:
    """Raises `RoomGridError`. Unpacks no more than the cells that the message's size allows."""
    size = message.width * message.height
    try:
        raw = zlib.decompressobj().decompress(base64.b64decode(message.cells_base64, validate=True), size + 1)
    except (ValueError, zlib.error) as error:  # binascii's error is a ValueError
        raise RoomGridError(f"the cells cannot be unpacked: {error}") from error
    if len(raw) != size:
        raise RoomGridError(f"it holds {len(raw)} cells, not {message.width} x {message.height}")
    cells = np.frombuffer(raw, np.uint8).reshape(message.height, message.width)
    if int(cells.max()) > len(message.ids):
        raise RoomGridError(f"a cell is of room {int(cells.max())}, and {len(message.ids)} rooms are named")
    ids = np.array((0, *message.ids), np.int64)
    return RoomCells(ids[cells], message.resolution_m, message.origin)
