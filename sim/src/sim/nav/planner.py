"""The planner of the stand-in for Nav2: the cheapest way through a costmap, shortened where that costs nothing."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray
from skimage.graph import MCP_Geometric  # pyright: ignore[reportMissingTypeStubs, reportUnknownVariableType]

from contracts.geometry import Pose2D
from sim.nav.codes import Code, NavigationError
from sim.nav.costmap import Cell, Costmap

START_TOLERANCE_M: Final = 0.25
SPACING_M: Final = 0.1
_SHORTCUT_ALLOWANCE: Final = 1.02


@dataclass(frozen=True)
class Path:
    """Way points (N, 2) in m in the map frame, about `SPACING_M` apart, and the heading wanted at the last one."""

    points_m: NDArray[np.float64]
    goal_yaw: float

    @cached_property
    def along_m(self) -> NDArray[np.float64]:
        """(N,) length of the path from its start to each point."""
        steps = np.hypot(*np.diff(self.points_m, axis=0).T)
        return np.concatenate([[0.0], np.cumsum(steps)])

    @property
    def length_m(self) -> float:
        return float(self.along_m[-1])

    def poses(self) -> list[Pose2D]:
        """Each point heading for the next, the last one with the wanted heading."""
        steps = np.diff(self.points_m, axis=0)
        yaws = [*np.arctan2(steps[:, 1], steps[:, 0]).tolist(), self.goal_yaw]
        return [Pose2D(x=x, y=y, yaw=yaw) for (x, y), yaw in zip(self.points_m.tolist(), yaws, strict=True)]


def plan(costmap: Costmap, start: Pose2D, goal: Pose2D) -> Path:
    """The cheapest path from `start` to `goal`, both in the map frame.

    A start a little inside the inflation (where the robot came to stand, or was put) begins at the nearest free cell.
    Raises `NavigationError` with START_OUTSIDE_MAP, GOAL_OUTSIDE_MAP, START_OCCUPIED, GOAL_OCCUPIED or NO_VALID_PATH.
    """
    grid = costmap.grid
    start_cell, goal_cell = grid.cell(start.x, start.y), grid.cell(goal.x, goal.y)
    if start_cell is None:
        raise NavigationError(Code.START_OUTSIDE_MAP, f"start ({start.x:.2f}, {start.y:.2f}) is outside the map")
    if goal_cell is None:
        raise NavigationError(Code.GOAL_OUTSIDE_MAP, f"goal ({goal.x:.2f}, {goal.y:.2f}) is outside the map")
    if not costmap.free[goal_cell]:
        raise NavigationError(Code.GOAL_OCCUPIED, f"goal ({goal.x:.2f}, {goal.y:.2f}) is too near an obstacle")
    free_start = _nearest_free(costmap, start_cell)
    if free_start is None:
        raise NavigationError(Code.START_OCCUPIED, f"start ({start.x:.2f}, {start.y:.2f}) is inside an obstacle")
    cells = _cheapest(costmap, free_start, goal_cell)
    middle = grid.centres(cells[:, 0], cells[:, 1])[1:-1]
    first = grid.centres(cells[:1, 0], cells[:1, 1]) if free_start != start_cell else np.empty((0, 2))
    points = np.concatenate([[[start.x, start.y]], first, middle, [[goal.x, goal.y]]])
    return Path(_resample(_shorten(costmap, points)), goal.yaw)


def _nearest_free(costmap: Costmap, cell: Cell) -> Cell | None:
    """`cell` if the robot may be there, else the nearest cell within `START_TOLERANCE_M` where it may."""
    if costmap.free[cell]:
        return cell
    reach = math.ceil(START_TOLERANCE_M / costmap.grid.resolution_m)
    row_min, column_min = max(cell[0] - reach, 0), max(cell[1] - reach, 0)
    window = costmap.free[row_min : cell[0] + reach + 1, column_min : cell[1] + reach + 1]
    candidates = np.argwhere(window) + np.array([row_min, column_min])
    if not len(candidates):
        return None
    distances = np.hypot(*(candidates - cell).T) * costmap.grid.resolution_m
    nearest = int(distances.argmin())
    if distances[nearest] > START_TOLERANCE_M:
        return None
    return int(candidates[nearest, 0]), int(candidates[nearest, 1])


def _cheapest(costmap: Costmap, start: Cell, goal: Cell) -> NDArray[np.intp]:
    """(N, 2) rows and columns from start to goal."""
    search: Any = cast(Any, MCP_Geometric)(costmap.price, fully_connected=True)
    totals, _ = search.find_costs([start], [goal])
    if not np.isfinite(totals[goal]):
        raise NavigationError(Code.NO_VALID_PATH, "no way through the map leads from the start to the goal")
    return np.array(search.traceback(goal), dtype=np.intp).reshape(-1, 2)


def _shorten(costmap: Costmap, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Leaves out points where going straight costs no more than following the cells did."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    rows, columns = costmap.grid.cells((points[:-1] + points[1:]) / 2)
    prices = np.abs(costmap.price[rows, columns])
    spent = np.concatenate([[0.0], np.cumsum(steps * prices)])
    kept, last = [0], len(points) - 1
    while kept[-1] < last:
        here, reach = kept[-1], 1
        while here + 2 * reach <= last and _straight_is_as_good(costmap, points, spent, here, here + 2 * reach):
            reach *= 2
        candidates = range(min(here + 2 * reach, last), here, -max(1, reach // 8))
        good = (c for c in candidates if c <= here + 1 or _straight_is_as_good(costmap, points, spent, here, c))
        kept.append(next(good, here + 1))
    return points[kept]


def _straight_is_as_good(
    costmap: Costmap, points: NDArray[np.float64], spent: NDArray[np.float64], begin: int, end: int
) -> bool:
    a, b = points[begin], points[end]
    length = float(np.hypot(*(b - a)))
    count = max(2, math.ceil(length / (costmap.grid.resolution_m / 2)))
    rows, columns = costmap.grid.cells(a + (b - a) * ((np.arange(count) + 0.5) / count)[:, None])
    prices = costmap.price[rows, columns]
    if (prices < 0).any():
        return False
    return bool(prices.mean() * length <= (spent[end] - spent[begin]) * _SHORTCUT_ALLOWANCE)


def _resample(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points about `SPACING_M` apart on straight lines between the corners, both ends kept."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    if along[-1] < 1e-6:
        return corners[[0, -1]]
    count = max(2, math.ceil(float(along[-1]) / SPACING_M) + 1)
    at: NDArray[np.float64] = np.linspace(0.0, float(along[-1]), count)
    return np.stack([np.interp(at, along, corners[:, 0]), np.interp(at, along, corners[:, 1])], axis=-1)
