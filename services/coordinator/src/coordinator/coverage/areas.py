"""From the cells of a home's rooms, as memory tells them, to the area that a search keeps to; and onto a map. Pure."""

import math
from collections.abc import Sequence

import numpy as np

from contracts.geometry import Pose2D
from contracts.mission import SearchedRoom
from coordinator.core.area import SearchArea
from coordinator.coverage.untyped import nearest_of
from geometry.grids import Mask, OccupancyGrid
from geometry.poses import compose
from geometry.regions import runs
from geometry.room_grids import RoomCells
from geometry.rooms import IN_FURNITURE_M

RUNS_MAX = 5000
"""Of a room on a hectare; of more the cells are taken larger."""


def area_of(cells: RoomCells, rooms: Sequence[SearchedRoom]) -> SearchArea | None:
    """The rooms that have cells, and what lies off their floor and nearer to it than to any other room's: a thing on a
    shelf is in the room that memory says (`IN_FURNITURE_M`). None where no cell is of them.
    """
    shown = set(np.unique(cells.ids).tolist()) - {0}
    rooms = [one for one in rooms if one.id in shown]
    if not rooms:
        return None
    floor = cells.of([one.id for one in rooms])
    pad = math.ceil(IN_FURNITURE_M / cells.resolution_m)
    found_rows, found_columns = np.nonzero(floor.any(axis=1))[0], np.nonzero(floor.any(axis=0))[0]
    low, left = int(found_rows[0]) - pad, int(found_columns[0]) - pad
    top, right = int(found_rows[-1]) + pad + 1, int(found_columns[-1]) + pad + 1
    ids = np.pad(cells.ids, pad)[low + pad : top + pad, left + pad : right + pad]
    away, nearest = nearest_of(ids > 0)
    held: Mask = np.asarray(np.isin(ids.ravel()[nearest], [one.id for one in rooms]) & (away <= pad))
    resolution_m = cells.resolution_m
    while len(runs(held)[0]) > RUNS_MAX:
        held, resolution_m = held[::2, ::2], resolution_m * 2
    at, firsts, behinds = (each.tolist() for each in runs(held))
    corner = Pose2D(x=left * cells.resolution_m, y=low * cells.resolution_m, yaw=0.0)
    origin = compose(cells.origin, corner)
    return SearchArea(tuple(rooms), origin, resolution_m, tuple(zip(at, firsts, behinds, strict=True)))


def mask_of(area: SearchArea, grid: OccupancyGrid) -> Mask:
    """(height, width) of the grid: the cells whose middle lies in the area."""
    if not area.runs:
        return np.zeros(grid.cells.shape, dtype=bool)
    height, width = max(row for row, _, _ in area.runs) + 1, max(behind for _, _, behind in area.runs)
    held = np.zeros((height, width), dtype=bool)
    for row, first, behind in area.runs:
        held[row, first:behind] = True
    frame = OccupancyGrid(np.zeros((height, width), np.int8), area.resolution_m, area.origin)
    rows, columns = np.indices(grid.cells.shape)
    return frame.at(*grid.points(columns + 0.5, rows + 0.5), held)
