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

TOLERANCE_M: Final = 0.5
"""turtlebot4's own for NavFn."""
SPACING_M: Final = 0.025
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


def plan(costmap: Costmap, start: Pose2D, goal: Pose2D, *, tolerance_m: float = TOLERANCE_M) -> Path:
    """The cheapest path from `start` to `goal`, both in the map frame, as NavFn gives it.

    A goal that cannot be reached becomes the nearest point that can, in a square of `tolerance_m` to each side: the
    path ends elsewhere, with the goal's own heading. The one cell under the robot counts as free, whatever it holds.
    Raises `NavigationError` with START_OUTSIDE_MAP, GOAL_OUTSIDE_MAP, NO_VALID_PATH, and, where `tolerance_m` is 0,
    GOAL_OCCUPIED.
    """
    grid = costmap.grid
    start_cell, goal_cell = grid.cell(start.x, start.y), grid.cell(goal.x, goal.y)
    if start_cell is None:
        raise NavigationError(Code.START_OUTSIDE_MAP, f"start ({start.x:.2f}, {start.y:.2f}) is outside the map")
    if goal_cell is None:
        raise NavigationError(Code.GOAL_OUTSIDE_MAP, f"goal ({goal.x:.2f}, {goal.y:.2f}) is outside the map")
    if tolerance_m == 0.0 and not costmap.free[goal_cell]:
        raise NavigationError(Code.GOAL_OCCUPIED, f"goal ({goal.x:.2f}, {goal.y:.2f}) is too near an obstacle")
    cells = _cheapest(costmap, start_cell, goal_cell, tolerance_m)
    last = cells[-1]
    end = [goal.x, goal.y] if tuple(last) == goal_cell else grid.centres(last[0], last[1]).tolist()
    middle = grid.centres(cells[:, 0], cells[:, 1])[1:-1]
    points = np.concatenate([[[start.x, start.y]], middle, [end]])
    return Path(_resample(_shorten(costmap, points)), goal.yaw)


def _cheapest(costmap: Costmap, start: Cell, goal: Cell, tolerance_m: float) -> NDArray[np.intp]:
    """(N, 2) rows and columns from the start to the goal, or to the nearest cell in its square that can be reached."""
    price = costmap.price
    if price[start] < 0.0:
        price = price.copy()
        price[start] = 1.0
    search: Any = cast(Any, MCP_Geometric)(price, fully_connected=True)
    end: Cell | None = goal
    if not _reached(search, start, goal):
        totals, _ = search.find_costs([start])
        end = nearest_cell(np.isfinite(totals), goal, round(tolerance_m / costmap.grid.resolution_m))
    if end is None:
        raise NavigationError(Code.NO_VALID_PATH, "no way through the map leads from the start to the goal")
    return np.array(search.traceback(end), dtype=np.intp).reshape(-1, 2)


def _reached(search: Any, start: Cell, goal: Cell) -> bool:
    totals, _ = search.find_costs([start], [goal])
    return bool(np.isfinite(totals[goal]))


def nearest_cell(reachable: NDArray[np.bool_], cell: Cell, reach: int) -> Cell | None:
    """The reachable cell nearest to `cell`, at most `reach` rows and columns away."""
    row_min, column_min = max(cell[0] - reach, 0), max(cell[1] - reach, 0)
    window = reachable[row_min : cell[0] + reach + 1, column_min : cell[1] + reach + 1]
    candidates = np.argwhere(window) + np.array([row_min, column_min])
    if not len(candidates):
        return None
    nearest = candidates[int(np.hypot(*(candidates - cell).T).argmin())]
    return int(nearest[0]), int(nearest[1])


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
