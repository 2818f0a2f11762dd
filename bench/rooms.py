"""Are the rooms cut from a map the rooms of the home? `python -m bench.rooms [--homes 50] [--first 7020]`.

Of the free cells that lie in a room of the simulated home, the share that bears the number of the found room which
stands for it: found and true rooms are paired one to one, so that a room too many and a room too few both count. The
floor of the doorways themselves belongs to no room, and is left out. Tuned on homes 7000 to 7019.
"""

import argparse
import logging
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from bench.map_likeness import home_grid, rewritten
from bench.results import pyplot, save
from geometry.grids import OCCUPIED, UNKNOWN, OccupancyGrid
from geometry.regions import dilated
from geometry.rooms import Rooms, rooms_of
from sim.home import Home

log = logging.getLogger("bench.rooms")

CHAIR_M = 0.40
RESAMPLES = 2000


def as_mapped(home: Home, grid: OccupancyGrid) -> Iterator[tuple[str, OccupancyGrid]]:
    """One home's map as the simulator records it, and as worse mappers would."""
    yield "recorded", grid
    yield "surfaces only", surfaces(grid)
    yield "5 % of the cells wrong", noisy(grid, home.seed)
    yield "a chair in each doorway", with_chairs(home, grid)
    yield "all three", noisy(surfaces(with_chairs(home, grid)), home.seed)
    yield "turned by 0.7 rad", rewritten(grid, 0.7, grid.resolution_m)


def surfaces(grid: OccupancyGrid) -> OccupancyGrid:
    """As a laser leaves it: what stands is known where free floor lies beside it, and unknown within."""
    cells = np.where(grid.occupied & ~dilated(grid.free, 1), UNKNOWN, grid.cells).astype(np.int8)
    return OccupancyGrid(cells, grid.resolution_m, grid.origin)


def noisy(grid: OccupancyGrid, seed: int) -> OccupancyGrid:
    rng, cells = np.random.default_rng(seed), grid.cells.copy()
    wrong = (rng.random(cells.shape) < 0.05) & (cells >= 0)
    cells[wrong] = rng.choice([0, OCCUPIED, UNKNOWN], int(wrong.sum()))
    return OccupancyGrid(cells, grid.resolution_m, grid.origin)


def with_chairs(home: Home, grid: OccupancyGrid) -> OccupancyGrid:
    """A chair stands somewhere in every doorway, a hand's breadth off its sides."""
    rng, cells = np.random.default_rng(home.seed), grid.cells.copy()
    rows, columns = np.indices(cells.shape)
    x, y = grid.points(columns + 0.5, rows + 0.5)
    for door in home.doors:
        off = rng.uniform(-1.0, 1.0) * max(0.0, door.width_m / 2 - CHAIR_M / 2 - 0.12)
        at_x, at_y = door.x_m + abs(door.normal_y) * off, door.y_m + abs(door.normal_x) * off
        cells[(np.abs(x - at_x) < CHAIR_M / 2) & (np.abs(y - at_y) < CHAIR_M / 2)] = OCCUPIED
    return OccupancyGrid(cells, grid.resolution_m, grid.origin)


def true_rooms(home: Home, grid: OccupancyGrid) -> NDArray[np.int32]:
    """(height, width): 1 and up for the free cells of each of the home's rooms, in their order; else 0."""
    rows, columns = np.indices(grid.cells.shape)
    x, y = grid.points(columns + 0.5, rows + 0.5)
    out = np.zeros(grid.cells.shape, np.int32)
    for number, room in enumerate(home.rooms, 1):
        inside = (x >= room.x_min_m) & (x <= room.x_max_m) & (y >= room.y_min_m) & (y <= room.y_max_m)
        out[inside & grid.free] = number
    return out


def share_right(found: Rooms, truth: NDArray[np.int32]) -> float:
    """Of the true rooms' cells."""
    inside = truth > 0
    table = np.zeros((int(truth.max()) + 1, int(found.labels.max()) + 1))
    np.add.at(table, (truth[inside], found.labels[inside]), 1)
    pairs = linear_sum_assignment(-table[1:, 1:])
    return float(table[1:, 1:][pairs].sum() / np.count_nonzero(inside))


def interval(shares: list[float]) -> tuple[float, float]:
    """Of the mean, 95 %: homes drawn again (bootstrap), since the cells of one home are right or wrong together."""
    drawn = np.random.default_rng(0).choice(shares, (RESAMPLES, len(shares))).mean(1)
    low, high = np.percentile(drawn, (2.5, 97.5))
    return round(float(low), 4), round(float(high), 4)


def draw(path: Path, home: Home, found: Rooms, title: str) -> None:
    """The cut rooms in colours, what stands in black, the home's own rooms outlined."""
    plt = pyplot()
    grid = found.grid
    figure, axes = plt.subplots(figsize=(9, 7))
    shown = np.where(found.labels > 0, found.labels, np.nan)
    extent = (0, grid.cells.shape[1], 0, grid.cells.shape[0])
    axes.imshow(np.where(grid.occupied, 0.0, np.where(grid.free, 1.0, 0.7)), origin="lower", cmap="gray", extent=extent)
    axes.imshow(shown, origin="lower", cmap="tab20", alpha=0.6, extent=extent, interpolation="nearest")
    for room in home.rooms:
        x = np.array([room.x_min_m, room.x_max_m, room.x_max_m, room.x_min_m, room.x_min_m])
        y = np.array([room.y_min_m, room.y_min_m, room.y_max_m, room.y_max_m, room.y_min_m])
        axes.plot(*grid.columns_and_rows(x, y), "r--", linewidth=1)
    axes.set_title(title)
    figure.savefig(path, dpi=80)
    plt.close(figure)


def main() -> None:
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--homes", type=int, default=50)
    parser.add_argument("--first", type=int, default=7020)
    parser.add_argument("--out", type=Path, default=Path("out/bench/rooms.json"))
    asked = parser.parse_args()
    of: dict[str, list[float]] = {}
    worst: tuple[float, Home, Rooms, str] | None = None
    for seed in range(asked.first, asked.first + asked.homes):
        home = Home.generate(seed)
        for kind, grid in as_mapped(home, home_grid(seed)):
            found = rooms_of(grid)
            right = share_right(found, true_rooms(home, found.grid))
            of.setdefault(kind, []).append(round(right, 4))
            title = f"home {seed}, {kind}: {right:.3f} right, {len(found.rooms)} rooms of {len(home.rooms)}"
            if kind == "recorded" and (worst is None or right < worst[0]):
                worst = (right, home, found, title)
    figures = {
        kind: {"mean": round(float(np.mean(some)), 4), "interval_95": interval(some), "least": min(some), "each": some}
        for kind, some in of.items()
    }
    save(asked.out, {"homes": [asked.first, asked.first + asked.homes - 1], "shares": figures})
    for kind, one in figures.items():
        log.info(
            "%-24s %.4f of free cells right (95 %%: %s), least %.3f",
            kind,
            one["mean"],
            one["interval_95"],
            one["least"],
        )
    if worst is not None:
        draw(asked.out.with_suffix(".png"), *worst[1:])
        log.info("the worst of the recorded: %s, drawn in %s", worst[3], asked.out.with_suffix(".png"))


if __name__ == "__main__":
    main()
