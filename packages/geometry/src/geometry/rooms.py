"""A map cut into rooms at its doorways, which are told by their wall line.

A doorway is a gap of 0.6 to 1.3 m in a straight line of wall, between two pieces of wall that are thin: both ends of
the gap stand in walls no thicker than `WALL_MAX_M` somewhere within `JAMB_M` of it. Furniture leaves gaps as wide, but
is thick; what stands alone and is small (a chair in a doorway, a table's leg) is looked through. Of the cuts only those
count that part regions of `ROOM_MIN_M2` or more. Walls are taken to stand at right angles to one another, in any
direction. Measured by `make bench-rooms`; a watershed of the distance to the nearest wall, the usual way (Bormann et
al., "Room segmentation: survey, implementation, and analysis", ICRA 2016), does worse in furnished homes.

A map is cut on squares of `SQUARE_M`. One whose known part has more than `CELLS_MAX` of them, which is 1 ha, has no
rooms: on larger squares doorways and thin walls are lost (0.84 of the free cells right, on squares of 0.1 m).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from geometry import regions
from geometry.grids import OCCUPIED, UNKNOWN, Mask, OccupancyGrid, coarser
from geometry.poses import compose

SQUARE_M = 0.05
CELLS_MAX = 2048 * 2048
DOOR_M = (0.55, 1.30)
"""Clear width; a cell either way is the map's doing."""
WALL_MAX_M = 0.25
JAMB_M = 0.60
JAMB_MIN_M = 0.20
"""The least piece of wall that an end of a doorway stands in."""
ALONE_MAX_M = 0.65
"""What is no longer than this and touches nothing is furniture, a leg or a speck."""
SPECK_MAX_M = 0.18
"""Shorter than this is the map's noise: nothing near is joined to it."""
HOLLOW_MAX_M = 0.30
"""A wall seen from both its sides is two lines with unknown cells between them."""
GAP_KNOWN_MIN = 0.6
ROOM_MIN_M2 = 2.5
IN_FURNITURE_M = 1.2
"""A thing on a shelf lies off the free floor of its room by so much at most."""
TURN_STEP = math.radians(1.0)
STRAIGHT = math.radians(0.75)
"""Less than this off the grid's own axes a map is not turned."""
EDGES_MAX = 200_000
"""Cells that the direction of the walls is told by; of more of them every second, or every third, and so on."""
BLOCK_ROWS = 256
"""Coordinates are worked out for so many rows at once: they take ten times the memory of the cells."""


@dataclass(frozen=True, slots=True)
class Room:
    """One room of a map. `number` is its value in `Rooms.labels`; (x, y) is its roomiest place, in the map frame."""

    number: int
    x_m: float
    y_m: float
    area_m2: float
    """Of its free cells."""


@dataclass(frozen=True, eq=False)
class Rooms:
    """`labels` is (height, width) int32 on the cells of `grid`, the known part of the map: a room's number, 0 for no
    room. Largest room first."""

    grid: OccupancyGrid
    labels: regions.Labels
    rooms: tuple[Room, ...]

    def at(self, x_m: float, y_m: float, *, within_m: float = 0.0) -> Room | None:
        """The room at a point of the map frame, or the nearest that has a cell within `within_m` of it."""
        cell = self.grid.cell(x_m, y_m)
        if cell is not None and self.labels[cell]:
            return self._by_number[int(self.labels[cell])]
        columns, rows = self.grid.columns_and_rows(np.array(x_m), np.array(y_m))
        column, row, reach = float(columns), float(rows), math.ceil(within_m / self.grid.resolution_m)
        low, left = (max(0, math.floor(each) - reach) for each in (row, column))
        part = self.labels[low : max(0, math.floor(row) + reach + 1), left : max(0, math.floor(column) + reach + 1)]
        i, j = np.nonzero(part)
        away_m = np.hypot(i + low + 0.5 - row, j + left + 0.5 - column) * self.grid.resolution_m
        if not i.size or float(away_m.min()) > within_m:
            return None
        nearest = int(np.argmin(away_m))
        return self._by_number[int(part[i[nearest], j[nearest]])]

    def mask(self, number: int) -> Mask:
        """(height, width): the cells of a room."""
        return self.labels == number

    @cached_property
    def _by_number(self) -> dict[int, Room]:
        return {one.number: one for one in self.rooms}


def rooms_of(grid: OccupancyGrid, *, cells_max: int = CELLS_MAX) -> Rooms:
    """The rooms of a map: its free cells, and what they stand on. A map without doorways is one room, or none; one
    whose known part has more than `cells_max` squares has none."""
    known = _bounded(_known(grid), cells_max)
    if known is None:
        return _none(grid)
    straight = _straightened(known, _turn_of(known), cells_max)
    if straight is None:
        return _none(grid)
    return _numbered(known, np.where(known.free, _on(known, straight, _cut(straight)), 0).astype(np.int32))


def _none(grid: OccupancyGrid) -> Rooms:
    nowhere = OccupancyGrid(np.full((1, 1), UNKNOWN, np.int8), grid.resolution_m, grid.origin)
    return Rooms(nowhere, np.zeros((1, 1), np.int32), ())


def _known(grid: OccupancyGrid) -> OccupancyGrid:
    """The smallest part of the rows and columns that holds all that is known."""
    rows, columns = regions.bounds_of(grid.cells != UNKNOWN)
    corner = Pose2D(x=columns.start * grid.resolution_m, y=rows.start * grid.resolution_m, yaw=0.0)
    return OccupancyGrid(grid.cells[rows, columns], grid.resolution_m, compose(grid.origin, corner))


def _bounded(grid: OccupancyGrid, cells_max: int) -> OccupancyGrid | None:
    """In larger cells where it has too many; none where those would be larger than the squares it is cut on."""
    times = math.ceil(math.sqrt(grid.cells.size / cells_max))
    while -(-grid.cells.shape[0] // times) * -(-grid.cells.shape[1] // times) > cells_max:
        times += 1
    if times == 1:
        return grid
    return coarser(grid, times) if grid.resolution_m * times <= SQUARE_M + 1e-6 else None


def _on(grid: OccupancyGrid, straight: OccupancyGrid, cut: regions.Labels) -> regions.Labels:
    """The numbers of the straightened map on the cells of the map."""
    if straight is grid:
        return cut
    (height, width), out = cut.shape, np.zeros(grid.cells.shape, np.int32)
    for part, x, y in _middles(grid):
        found, here = straight.columns_and_rows(x, y)
        i, j = np.floor(here).astype(np.intp).clip(0, height - 1), np.floor(found).astype(np.intp).clip(0, width - 1)
        out[part] = cut[i, j]
    return out


def _middles(grid: OccupancyGrid) -> Iterator[tuple[slice, NDArray[np.float64], NDArray[np.float64]]]:
    """Some rows of the grid, and x and y of the middles of their cells in the map frame, until all have been."""
    height, width = grid.cells.shape
    for low in range(0, height, BLOCK_ROWS):
        behind = min(height, low + BLOCK_ROWS)
        rows, columns = np.indices((behind - low, width))
        yield slice(low, behind), *grid.points(columns + 0.5, rows + (low + 0.5))


def _cut(grid: OccupancyGrid) -> regions.Labels:
    """Numbers of the regions between doorways, on a grid whose rows run along walls."""
    wall = _walls(grid)
    space = (grid.free | grid.occupied) & ~wall
    solid = wall | grid.unknown
    doors = _doorways(wall, solid, space, grid.resolution_m)
    doors |= _doorways(wall.T, solid.T, space.T, grid.resolution_m).T
    labels, count = regions.label(space & ~doors)
    small = regions.sizes(labels, count) * grid.resolution_m**2 < ROOM_MIN_M2
    return regions.spread(np.where(small[labels], 0, labels).astype(np.int32), space)


def _walls(grid: OccupancyGrid) -> Mask:
    """What stands and is neither noise nor a small thing by itself.

    A small block goes before gaps are closed: a chair close to the side of a doorway is none of the wall. A short thin
    line may be a piece of a broken wall, and goes after it, where it is still alone.
    """
    labels, count = regions.label(grid.occupied, corners=True)
    short, long = regions.boxes(labels, count).T * grid.resolution_m
    seen = grid.occupied & ~((long < SPECK_MAX_M) | ((long < ALONE_MAX_M) & (short > SPECK_MAX_M)))[labels]
    hollow = math.ceil(HOLLOW_MAX_M / grid.resolution_m / 2)
    standing = regions.closed(seen, 1) | (regions.closed(seen, hollow) & grid.unknown)
    labels, count = regions.label(standing, corners=True)
    alone = regions.boxes(labels, count)[:, 1] * grid.resolution_m < ALONE_MAX_M
    return standing & ~alone[labels]


def _doorways(wall: Mask, solid: Mask, space: Mask, resolution_m: float) -> Mask:
    """Gaps in walls that run along the rows. `solid`: what nobody sees into counts as thick, as a couch does."""
    thick = regions.run_lengths(solid.T).T
    thin = wall & (thick * resolution_m <= WALL_MAX_M + 1e-6)
    out = np.zeros_like(wall)
    jamb, jamb_min = (round(each / resolution_m) for each in (JAMB_M, JAMB_MIN_M))
    rows, starts, ends = regions.runs(~wall)
    between = (starts > 0) & (ends < wall.shape[1]) & _are_door(ends - starts, resolution_m)
    for row, start, end in zip(*(each[between].tolist() for each in (rows, starts, ends)), strict=True):
        before, behind = wall[row, max(0, start - jamb) : start][::-1], wall[row, end : end + jamb]
        if not all(_is_jamb(*each, jamb_min) for each in (
            (before, thin[row, max(0, start - jamb) : start][::-1]),
            (behind, thin[row, end : end + jamb]),
        )):  # fmt: skip
            continue
        if space[row, start:end].mean() >= GAP_KNOWN_MIN:
            out[row, start:end] = True
    return out


def _are_door(cells: NDArray[np.intp], resolution_m: float) -> Mask:
    return (cells * resolution_m >= DOOR_M[0] - 1e-6) & (cells * resolution_m <= DOOR_M[1] + 1e-6)


def _is_jamb(wall: Mask, thin: Mask, least: int) -> bool:
    """Whether the wall that begins at the gap is long enough, and somewhere thin. Cells count away from the gap."""
    length = len(wall) if wall.all() else int(np.argmin(wall))
    return length >= least and bool(thin[:length].any())


def _turn_of(grid: OccupancyGrid) -> float:
    """How far the walls are turned from the grid's rows, in rad within +-pi/4; 0 where they run along them.

    The direction in which the edges of what stands fall into the fewest lines (the sharpest projections).
    """
    free_beside = regions.dilated(grid.free, 1)
    rows, columns = np.nonzero(grid.occupied & free_beside)
    if len(rows) < 40:
        return 0.0
    points: NDArray[np.float64] = np.stack([columns, rows], 1).astype(np.float64)[:: -(-len(rows) // EDGES_MAX)]

    def sharpness(angle: float) -> float:
        c, s = math.cos(angle), math.sin(angle)
        total = 0.0
        for u, v in ((c, s), (-s, c)):
            along: NDArray[np.float64] = points[:, 0] * u + points[:, 1] * v
            counts = np.bincount(np.floor(along - along.min() + 0.5).astype(np.intp))
            total += float((counts.astype(float) ** 2).sum())
        return total

    coarse = [k * TURN_STEP for k in range(-45, 45)]
    best = max(coarse, key=sharpness)
    fine = max((best + k * TURN_STEP / 4 for k in range(-3, 4)), key=sharpness)
    return 0.0 if abs(fine) <= STRAIGHT else fine


def _straightened(grid: OccupancyGrid, turn: float, cells_max: int) -> OccupancyGrid | None:
    """The known part of the map on squares whose rows are turned by `turn` from the grid's; none where they are too
    many."""
    if turn == 0.0 and math.isclose(grid.resolution_m, SQUARE_M):
        return grid
    rows, starts, ends = regions.runs(grid.free | grid.occupied)
    if not rows.size:
        return OccupancyGrid(np.full((1, 1), UNKNOWN, np.int8), SQUARE_M, grid.origin)
    axes = Pose2D(x=grid.origin.x, y=grid.origin.y, yaw=grid.origin.yaw + turn)
    frame = OccupancyGrid(np.zeros((1, 1), np.int8), SQUARE_M, axes)
    outer = np.stack([starts + 0.5, ends - 0.5]), np.stack([rows + 0.5, rows + 0.5])
    i, j = frame.columns_and_rows(*grid.points(*outer))
    left, low = math.floor(i.min()) - 2, math.floor(j.min()) - 2
    shape = (math.ceil(j.max()) - low + 3, math.ceil(i.max()) - left + 3)
    if shape[0] * shape[1] > cells_max:
        return None
    origin = compose(axes, Pose2D(x=left * SQUARE_M, y=low * SQUARE_M, yaw=0.0))
    straight = OccupancyGrid(np.zeros(shape, np.int8), SQUARE_M, origin)
    for part, x, y in _middles(straight):
        straight.cells[part] = np.where(
            grid.at(x, y, grid.occupied), OCCUPIED, np.where(grid.at(x, y, grid.free), 0, UNKNOWN)
        )
    return straight


def _numbered(grid: OccupancyGrid, cut: regions.Labels) -> Rooms:
    """The regions numbered from 1, the largest first."""
    counts: NDArray[np.intp] = np.bincount(cut.ravel())
    counts[0] = 0
    order = [int(k) for k in np.argsort(-counts, kind="stable") if counts[k] > 0]
    numbers = np.zeros(len(counts), np.int32)
    numbers[order] = np.arange(1, len(order) + 1)
    labels = numbers[cut]
    deep, (low, behind) = regions.depths(labels), regions.extents(labels, len(order))
    rooms: list[Room] = []
    for number, of in enumerate(order, 1):
        part = tuple(slice(*each) for each in zip(low[number].tolist(), behind[number].tolist(), strict=True))
        own = np.where(labels[part] == number, deep[part], 0)
        rows, columns = np.nonzero(own == own.max())
        middle = int(np.argmin(np.hypot(rows - rows.mean(), columns - columns.mean())))
        x, y = grid.centre(int(rows[middle]) + part[0].start, int(columns[middle]) + part[1].start)
        area_m2 = float(counts[of]) * grid.resolution_m**2
        rooms.append(Room(number, round(x, 3), round(y, 3), round(area_m2, 2)))
    return Rooms(grid, labels, tuple(rooms))
