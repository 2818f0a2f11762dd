"""Where what is known ends: the borders of a growing map, how much lies behind each, and the way there.

A frontier is known free space next to unknown (Yamauchi, "A frontier-based approach for autonomous exploration", 1997).
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse  # pyright: ignore[reportMissingTypeStubs]
from scipy.sparse import csgraph  # pyright: ignore[reportMissingTypeStubs]

from contracts.geometry import Pose2D
from geometry import regions
from geometry.grids import Mask, OccupancyGrid

BORDER_M_MIN: Final = 0.3
"""Shorter borders are what a table's legs leave open."""
BEHIND_M: Final = 1.0
"""So far into the unknown what may be seen from there counts."""
NEAR_M: Final = 0.8
"""A robot must find room to stand this near to a border."""
START_M: Final = 0.6
"""A robot that stands too near to something (its dock) is taken to stand in the nearest room within this."""
PER_M: Final = 0.25
"""A border one metre farther away is worth so much less: exp(-0.25)."""


@dataclass(frozen=True, slots=True)
class Frontier:
    """One border; (x, y, yaw) is where the robot can stand to look beyond it, in the map."""

    number: int
    """In its chart, from 1; the most worthwhile first."""
    pose: Pose2D
    border_m: float
    behind_m2: float
    """Unknown space within `BEHIND_M` of it that no known obstacle parts from it."""
    path_m: float

    @property
    def worth(self) -> float:
        """Gain against cost: m2 behind it, less the farther it is."""
        return self.behind_m2 * math.exp(-PER_M * self.path_m)


@dataclass(frozen=True, eq=False)
class Chart:
    """What the newest map says to somebody who explores. `reachable` is (height, width): where its centre may stand."""

    grid: OccupancyGrid
    reachable: Mask
    frontiers: tuple[Frontier, ...]

    @cached_property
    def reachable_m2(self) -> float:
        return float(np.count_nonzero(self.reachable)) * self.grid.resolution_m**2

    def has_room_at(self, x_m: float, y_m: float) -> bool:
        """Known free space that the robot fits in and has a way to."""
        cell = self.grid.cell(x_m, y_m)
        return cell is not None and bool(self.reachable[cell])


def chart_of(grid: OccupancyGrid, pose: Pose2D, footprint_radius_m: float) -> Chart:
    """`pose` is base_link in the map. A robot outside the map, or with no room near, has neither room nor frontiers."""
    blocked = ~grid.free
    room = _distance_m(blocked, grid) >= footprint_radius_m
    costs_m = _costs_m(grid, room, pose)
    reachable = np.isfinite(costs_m)
    if not reachable.any():
        return Chart(grid, np.zeros_like(room), ())
    found = sorted(_frontiers(grid, reachable, costs_m), key=lambda one: -one.worth)
    numbered = tuple(
        Frontier(number, one.pose, one.border_m, one.behind_m2, one.path_m) for number, one in enumerate(found, 1)
    )
    return Chart(grid, reachable, numbered)


def _distance_m(blocked: Mask, grid: OccupancyGrid) -> NDArray[np.float64]:
    """(height, width): from each cell's middle to the nearest that is blocked."""
    if not blocked.any():
        return np.full(blocked.shape, np.inf)
    return np.asarray(cast(Any, ndimage).distance_transform_edt(~blocked)) * grid.resolution_m


def _costs_m(grid: OccupancyGrid, room: Mask, pose: Pose2D) -> NDArray[np.float64]:
    """(height, width): the shortest way there through `room`, m; inf where none leads."""
    nowhere = np.full(room.shape, np.inf)
    cell = grid.cell(pose.x, pose.y)
    if cell is None or not room.any():
        return nowhere
    if not room[cell]:
        rows, columns = np.nonzero(room)
        away_m = np.hypot(rows - cell[0], columns - cell[1]) * grid.resolution_m
        nearest = int(np.argmin(away_m))
        if away_m[nearest] > START_M:
            return nowhere
        cell = int(rows[nearest]), int(columns[nearest])
    return _walks(room, cell) * grid.resolution_m


def _walks(room: Mask, start: tuple[int, int]) -> NDArray[np.float64]:
    """(height, width): the shortest way through `room` from one of its cells, in cells, over sides and corners."""
    numbers = np.full(room.shape, -1, np.intp)
    numbers[room] = np.arange(np.count_nonzero(room))
    height, width = room.shape
    heads: list[NDArray[np.intp]] = []
    tails: list[NDArray[np.intp]] = []
    lengths: list[NDArray[np.float64]] = []
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        one = numbers[: height - down, max(0, -right) : width - max(0, right)]
        other = numbers[down:, max(0, right) : width - max(0, -right)]
        both = (one >= 0) & (other >= 0)
        heads.append(one[both])
        tails.append(other[both])
        lengths.append(np.full(np.count_nonzero(both), math.hypot(down, right)))
    count = int(np.count_nonzero(room))
    edges = np.concatenate(lengths), (np.concatenate(heads), np.concatenate(tails))
    graph = cast(Any, sparse).csr_matrix(edges, shape=(count, count))
    out = np.full(room.shape, np.inf)
    out[room] = np.asarray(cast(Any, csgraph).dijkstra(graph, directed=False, indices=int(numbers[start])), np.float64)
    return out


def _frontiers(grid: OccupancyGrid, reachable: Mask, costs_m: NDArray[np.float64]) -> list[Frontier]:
    border = grid.free & regions.dilated(grid.unknown, 1)
    labels, count = regions.label(border, corners=True)
    distance, (to_row, to_column) = cast(Any, ndimage).distance_transform_edt(~reachable, return_indices=True)
    boxes = cast(Any, ndimage).find_objects(labels)
    found: list[Frontier] = []
    for number in range(1, count + 1):
        rows, columns = (each + one.start for each, one in zip(
            np.nonzero(labels[boxes[number - 1]] == number), boxes[number - 1], strict=True
        ))  # fmt: skip
        border_m = len(rows) * grid.resolution_m
        near = distance[rows, columns] * grid.resolution_m <= NEAR_M
        if border_m < BORDER_M_MIN or not near.any():
            continue
        middle = rows.mean(), columns.mean()
        off = np.where(near, np.hypot(rows - middle[0], columns - middle[1]), np.inf)
        at = int(np.argmin(off))
        row, column = int(rows[at]), int(columns[at])
        stand = int(to_row[row, column]), int(to_column[row, column])
        x, y = grid.centre(*stand)
        ahead_x, ahead_y = _beyond(grid, row, column)
        yaw = math.atan2(ahead_y - y, ahead_x - x)
        behind = _behind_m2(grid, rows, columns)
        found.append(Frontier(0, Pose2D(x=x, y=y, yaw=yaw), border_m, behind, float(costs_m[stand])))
    return found


def _window(grid: OccupancyGrid, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> tuple[slice, slice, int]:
    reach = max(1, round(BEHIND_M / grid.resolution_m))
    return (
        slice(max(0, int(rows.min()) - reach), int(rows.max()) + reach + 1),
        slice(max(0, int(columns.min()) - reach), int(columns.max()) + reach + 1),
        reach,
    )


def _behind_m2(grid: OccupancyGrid, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> float:
    """Unknown cells within reach of the border, grown through the unknown only: none beyond a wall."""
    high, wide, reach = _window(grid, rows, columns)
    seed = np.zeros(grid.unknown[high, wide].shape, bool)
    seed[rows - high.start, columns - wide.start] = True
    unknown = grid.unknown[high, wide]
    grown = cast(Any, ndimage).binary_dilation(seed, iterations=reach, mask=unknown | seed)
    return float(np.count_nonzero(grown & unknown)) * grid.resolution_m**2


def _beyond(grid: OccupancyGrid, row: int, column: int) -> tuple[float, float]:
    """The middle of the unknown near a cell of the border: what to look at from there."""
    high, wide, _ = _window(grid, np.array([row]), np.array([column]))
    rows, columns = np.nonzero(grid.unknown[high, wide])
    if not rows.size:
        return grid.centre(row, column)
    x, y = grid.points(columns.mean() + wide.start + 0.5, rows.mean() + high.start + 0.5)
    return float(x), float(y)
