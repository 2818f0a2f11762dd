"""A better coverage: few points from which all free space is near and in line of sight, in a short order.

Greedy set cover on a coarse grid, then nearest neighbour and 2-opt over distances on foot (round the walls).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from coordinator.coverage.lawnmower import Coverage, clearance_cells, pose_at, safe_cells, trouble_of
from coordinator.coverage.untyped import label_regions, maximum_filter, roomiest_cells, shortest_walks
from coordinator.coverage.visibility import VisibilityIndex
from geometry.grids import Mask, OccupancyGrid

COARSE_M = 0.15
CANDIDATE_STRIDE_M = 0.45
ROOM_M = 0.09
"""Beside the footprint, where it stands and turns."""
GAIN_MIN_M2 = 0.4
WALKED_STOPS_MAX = 80
BESIDE_CELLS = 4


@dataclass(frozen=True, eq=False, slots=True)
class CoarseMap:
    """Every n-th cell stands for its block: free when most of it is, blocked when any of it is occupied; passable where
    the robot fits, walkable where it may also stand and turn with room to spare.
    """

    factor: int
    free: Mask
    blocked: Mask
    passable: Mask
    walkable: Mask
    resolution_m: float


def viewpoints(
    grid: OccupancyGrid,
    *,
    radius_m: float,
    start: Pose2D | None,
    reach_m: float,
    seen: Mask | None = None,
    avoid: tuple[Pose2D, ...] = (),
    avoid_m: float = 0.35,
    points_max: int = 400,
    within: Mask | None = None,
) -> Coverage:
    """Points that together see all free space not in `seen` from within `reach_m`; where `start` is given, only what
    can be reached from there, in an order that begins near it. Of `within` alone, and from there where one can stand
    in it.
    """
    coarse = coarsen(grid, radius_m, start)
    todo = coarse.free.copy()
    if seen is not None:
        todo &= _blocks(~seen & grid.free, coarse.factor).mean(axis=(1, 3)) > 0.5
    candidates = candidate_cells(grid, coarse, avoid, avoid_m)
    if within is not None:
        inside: Mask = np.asarray(blocks_of(within, coarse.factor))
        todo &= inside
        there = inside[candidates[:, 0], candidates[:, 1]]
        candidates = candidates[there] if there.any() else candidates
    free_area_m2 = grid.free_area_m2
    _, regions = label_regions(coarse.passable)
    if candidates.size == 0 or not todo.any():
        return Coverage((), regions, free_area_m2, trouble_of(grid, fits=bool(coarse.passable.any())))
    chosen = _chosen(coarse, candidates, todo, int(reach_m / coarse.resolution_m), points_max)
    ordered = _in_order(coarse, chosen, _start_cell(grid, coarse, start))
    middle = coarse.factor // 2
    points = tuple(pose_at(grid, int(r) * coarse.factor + middle, int(c) * coarse.factor + middle) for r, c in ordered)
    return Coverage(points, regions, free_area_m2)


def _blocks(mask: Mask, factor: int) -> NDArray[np.bool_]:
    """(rows, factor, columns, factor): the mask cut into blocks, padded with False."""
    rows, columns = (-(-n // factor) for n in mask.shape)
    padded = np.zeros((rows * factor, columns * factor), dtype=bool)
    padded[: mask.shape[0], : mask.shape[1]] = mask
    return padded.reshape(rows, factor, columns, factor)


def blocks_of(mask: Mask, factor: int) -> Mask:
    """The coarse cells most of which is in the mask."""
    return np.asarray(_blocks(mask, factor).mean(axis=(1, 3)) > 0.5)


def coarsen(grid: OccupancyGrid, radius_m: float, start: Pose2D | None) -> CoarseMap:
    factor = max(1, round(COARSE_M / grid.resolution_m))
    free: Mask = np.asarray(_blocks(grid.free, factor).mean(axis=(1, 3)) >= 0.5)
    blocked: Mask = np.asarray(~free | _blocks(grid.occupied, factor).any(axis=(1, 3)))
    passable = _standing(grid, radius_m, factor)
    walkable = _standing(grid, radius_m + ROOM_M, factor)
    cell = grid.cell(start.x, start.y) if start is not None else None
    if cell is not None:
        labels, count = label_regions(passable)
        here = _nearest_label(labels, cell[0] // factor, cell[1] // factor) if count else 0
        if here:
            passable = np.asarray(labels == here)
        reachable_free, _ = label_regions(free)
        near = np.unique(reachable_free[passable])
        free &= np.isin(reachable_free, near[near > 0])
    walkable &= passable
    if not walkable.any():
        walkable = passable.copy()
    return CoarseMap(factor, free, blocked, passable, walkable, grid.resolution_m * factor)


def _standing(grid: OccupancyGrid, clearance_m: float, factor: int) -> Mask:
    """Blocks with a cell that has this much room all round, give or take one cell."""
    safe = safe_cells(grid.free, clearance_cells(grid.resolution_m, clearance_m) - 1)
    return np.asarray(_blocks(safe, factor).any(axis=(1, 3)))


def _nearest_label(labels: NDArray[np.int32], row: int, column: int) -> int:
    row, column = min(row, labels.shape[0] - 1), min(column, labels.shape[1] - 1)
    if labels[row, column]:
        return int(labels[row, column])
    rows, columns = np.nonzero(labels)
    nearest = int(np.argmin((rows - row) ** 2 + (columns - column) ** 2))
    return int(labels[rows[nearest], columns[nearest]])


def candidate_cells(
    grid: OccupancyGrid, coarse: CoarseMap, avoid: tuple[Pose2D, ...], avoid_m: float
) -> NDArray[np.intp]:
    """(n, 2) coarse cells: a lattice over what is walkable, and in each region at least its roomiest cell."""
    stride = max(1, round(CANDIDATE_STRIDE_M / coarse.resolution_m))
    lattice = np.zeros_like(coarse.walkable)
    lattice[::stride, ::stride] = True
    picked = coarse.walkable & lattice
    labels, count = label_regions(coarse.walkable)
    roomiest = roomiest_cells(coarse.walkable, labels, count)
    picked[roomiest[:, 0], roomiest[:, 1]] = True
    cells = np.argwhere(picked)
    for pose in avoid:
        x, y = grid.points((cells[:, 1] + 0.5) * coarse.factor, (cells[:, 0] + 0.5) * coarse.factor)
        cells = cells[np.hypot(x - pose.x, y - pose.y) > avoid_m]
    return cells


def _chosen(
    coarse: CoarseMap, candidates: NDArray[np.intp], todo: Mask, reach: int, points_max: int
) -> NDArray[np.intp]:
    """(n, 2) cells: of the lattice first; then, for what those leave unseen, of all walkable cells beside it."""
    gain_min = max(1, int(GAIN_MIN_M2 / coarse.resolution_m**2))
    lattice = VisibilityIndex(coarse.blocked, candidates, reach)
    first, left = lattice.cover(todo, gain_min=gain_min, places_max=points_max)
    labels, _ = label_regions(left)
    lost = np.bincount(labels.ravel()) >= gain_min
    lost[0] = False
    near = maximum_filter(lost[labels], 2 * BESIDE_CELLS + 1) & coarse.walkable if lost.any() else np.zeros_like(left)
    more = np.argwhere(near)
    if not len(more) or len(first) >= points_max:
        return candidates[first]
    second, _ = VisibilityIndex(coarse.blocked, more, reach).cover(
        left, gain_min=gain_min, places_max=points_max - len(first)
    )
    return np.concatenate([candidates[first], more[second]])


def _start_cell(grid: OccupancyGrid, coarse: CoarseMap, start: Pose2D | None) -> tuple[int, int] | None:
    cell = grid.cell(start.x, start.y) if start is not None else None
    return (cell[0] // coarse.factor, cell[1] // coarse.factor) if cell is not None else None


def _in_order(coarse: CoarseMap, cells: NDArray[np.intp], start: tuple[int, int] | None) -> NDArray[np.intp]:
    """Nearest neighbour from the start, then 2-opt with the start fixed and the end open; on foot for few stops, as the
    crow flies and without 2-opt for many.
    """
    if len(cells) < 2:
        return cells
    stops = cells if start is None else np.vstack([[start], cells])
    if len(stops) <= WALKED_STOPS_MAX:
        between = walks_m(coarse, stops)
        order = two_opt(_nearest_first(len(stops), lambda stop: between[stop]), between)
    else:
        places = stops.astype(float)
        order = _nearest_first(len(stops), lambda stop: np.hypot(*(places - places[stop]).T))
    return stops[order] if start is None else stops[order[1:]]


def _nearest_first(stops: int, from_stop: Callable[[int], NDArray[np.float64]]) -> list[int]:
    """From the first stop always to the nearest one left; `from_stop` gives the distances from one to all."""
    order, done = [0], np.zeros(stops)
    done[0] = np.inf
    for _ in range(stops - 1):
        order.append(int(np.argmin(from_stop(order[-1]) + done)))
        done[order[-1]] = np.inf
    return order


def two_opt(order: list[int], between: NDArray[np.float64], rounds_max: int = 10) -> list[int]:
    """Reverses stretches while that shortens the open tour; the first stop stays."""
    tour = np.array(order, dtype=np.intp)
    open_end = np.pad(between, ((0, 0), (0, 1)))  # beyond the last stop everything is near
    for _ in range(rounds_max):
        improved = False
        for i in range(1, len(tour) - 1):
            before, first, lasts = tour[i - 1], tour[i], tour[i + 1 :]
            after = np.append(tour[i + 2 :], len(between))
            change = between[before, lasts] + open_end[first, after] - between[before, first] - open_end[lasts, after]
            best = int(np.argmin(change))
            if change[best] < -1e-6:
                tour[i : i + best + 2] = tour[i : i + best + 2][::-1].copy()
                improved = True
        if not improved:
            break
    return tour.tolist()


def walks_m(coarse: CoarseMap, stops: NDArray[np.intp], starts: NDArray[np.intp] | None = None) -> NDArray[np.float64]:
    """(starts, stops) metres on foot over passable cells; as the crow flies, times three, where no way is known.

    Without `starts` from every stop.
    """
    every = stops if starts is None else np.vstack([starts, stops])
    froms = len(every) - len(stops) or len(every)
    apart = (every[:froms, None, :] - stops[None, :, :]).astype(float)
    crow = np.hypot(*apart.transpose(2, 0, 1)) * coarse.resolution_m
    walkable = coarse.passable.copy()
    walkable[tuple(np.clip(every, 0, np.array(walkable.shape) - 1).T)] = True
    ids = np.arange(walkable.size).reshape(walkable.shape)
    height, width = walkable.shape
    heads: list[NDArray[np.intp]] = []
    tails: list[NDArray[np.intp]] = []
    weights: list[NDArray[np.float64]] = []
    for dr, dc, cost in ((0, 1, 1.0), (1, 0, 1.0), (1, 1, 1.4142), (1, -1, 1.4142)):
        a = np.s_[0 : height - dr, max(0, -dc) : width - max(0, dc)]
        b = np.s_[dr:height, max(0, dc) : width + min(0, dc)]
        both = walkable[a] & walkable[b]
        heads.append(ids[a][both])
        tails.append(ids[b][both])
        weights.append(np.full(int(both.sum()), cost * coarse.resolution_m))
    nodes = ids[tuple(np.clip(every, 0, np.array(walkable.shape) - 1).T)]
    edges = np.concatenate(heads), np.concatenate(tails), np.concatenate(weights)
    walks = shortest_walks(ids.size, *edges, nodes[:froms], nodes[-len(stops) :])
    return np.where(np.isfinite(walks), walks, crow * 3.0)
