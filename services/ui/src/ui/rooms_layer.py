"""The map's layer of rooms: a light tint in each, the doorways between them, and a name at the roomiest place."""

import base64
import io
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from contracts.rooms import NamedBy, NamedRoom, RoomGrid
from geometry.probability_grids import corners
from geometry.room_grids import RoomCells, RoomGridError, decode
from ui.i18n import N_, _
from ui.latest_facts import ShownRooms
from ui.map_view import MapFrame, fit

Drawn = dict[str, Any]

TINTS_RGB = ((29, 86, 207), (21, 128, 61), (180, 110, 10), (124, 58, 237), (200, 30, 142), (14, 132, 160))
TINT_ALPHA, DOORWAY_ALPHA = 36, 150
"""On a light page as on a dark one."""
NAMED_BY = {
    NamedBy.PERSON: N_("named by a person"),
    NamedBy.CONTENTS: N_("guessed from what stands there"),
    NamedBy.NOBODY: N_("nobody has named it"),
}


def rooms(frame: MapFrame, known: ShownRooms, *, map_id: str | None) -> Drawn:
    """Of the home that is shown; of another one, and of cells that make no sense, nothing."""
    nothing: Drawn = {"png": "", "fit": [], "names": []}
    if known.grid is None or known.picture is None or (map_id is not None and known.map_id != map_id):
        return nothing
    return {
        "png": known.picture,
        "fit": fit(frame, corners(known.grid), known.grid.width, known.grid.height),
        "names": [_name(frame, one) for one in known.rooms],
    }


def picture(grid: RoomGrid) -> str | None:
    """The rooms' tints as a data URL; None where the cells make no sense. A large home takes a second: for a thread."""
    try:
        cells = decode(grid)
    except RoomGridError:
        return None
    return f"data:image/png;base64,{base64.b64encode(_png(cells, grid.ids)).decode('ascii')}"


def _name(frame: MapFrame, one: NamedRoom) -> Drawn:
    return {
        "id": one.id,
        "at": [round(value, 1) for value in frame.to_px(one.x, one.y)],
        "name": one.name,
        "by": one.named_by.value,
        "why": _(NAMED_BY[one.named_by]),
    }


def _png(cells: RoomCells, ids: tuple[int, ...]) -> bytes:
    """One pixel a cell, row 0 first."""
    tinted = np.zeros((*cells.ids.shape, 4), np.uint8)
    for at, room in enumerate(ids):
        tinted[cells.ids == room] = (*TINTS_RGB[at % len(TINTS_RGB)], TINT_ALPHA)
    tinted[_doorways(cells.ids), 3] = DOORWAY_ALPHA
    out = io.BytesIO()
    Image.fromarray(tinted, "RGBA").save(out, "PNG", optimize=True)
    return out.getvalue()


def _doorways(ids: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Cells of a room beside which, to the right or above, another room begins."""
    out = np.zeros(ids.shape, dtype=bool)
    for here, beyond in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        out[here] |= (ids[here] != ids[beyond]) & (ids[here] > 0) & (ids[beyond] > 0)
    return out
