"""How far apart are maps of one home and maps of different homes? `python -m bench.map_likeness [homes]`.

The maps of all simulated homes begin at one corner of one frame and have about one size: real ones are easier to tell.
"""

import itertools
import math
import sys
from collections.abc import Iterator

import numpy as np

from contracts.geometry import Pose2D
from geometry.grids import OccupancyGrid
from geometry.places import AGREEMENT_MIN, same_place, sketch_of
from geometry.poses import compose
from sim.home import Home
from sim.world import World


def home_grid(seed: int) -> OccupancyGrid:
    world = World(Home.generate(seed), seed=seed)
    try:
        grid = world.grid
    finally:
        world.close()
    return OccupancyGrid(grid.data, grid.resolution_m, Pose2D(x=grid.origin_x_m, y=grid.origin_y_m, yaw=0.0))


def changed(grid: OccupancyGrid, seed: int = 0) -> Iterator[tuple[str, OccupancyGrid]]:
    """The same home, mapped again, saved anew, only begun, or lived in."""
    rng, cells = np.random.default_rng(seed), grid.cells
    height, width = cells.shape
    for name, pose in {
        "shifted 0.1 m": Pose2D(x=0.1, y=0.0, yaw=0.0),
        "shifted 0.14 m": Pose2D(x=0.1, y=0.1, yaw=0.0),
        "turned 1 degree": Pose2D(x=0.03, y=0.02, yaw=0.017),
    }.items():
        yield name, OccupancyGrid(cells, grid.resolution_m, compose(pose, grid.origin))
    for name, yaw, resolution_m in (("rows turned", 0.7, 0.05), ("cells of 0.1 m", 0.0, 0.1), ("of 0.03 m", 0.3, 0.03)):
        yield name, rewritten(grid, yaw, resolution_m)
    noisy = cells.copy()
    wrong = (rng.random(cells.shape) < 0.05) & (cells >= 0)
    noisy[wrong] = rng.choice([0, 100, -1], int(wrong.sum()))
    yield "5 % of the cells wrong", OccupancyGrid(noisy, grid.resolution_m, grid.origin)
    half, quarter = cells.copy(), cells.copy()
    half[:, width // 2 :] = -1
    quarter[:, width // 2 :], quarter[height // 2 :] = -1, -1
    yield "half seen", OccupancyGrid(half, grid.resolution_m, grid.origin)
    yield "a quarter seen", OccupancyGrid(quarter, grid.resolution_m, grid.origin)
    moved = cells.copy()
    for old, new in ((0, 100), (100, 0)):
        for _ in range(8):
            r, c = int(rng.integers(10, height - 20)), int(rng.integers(10, width - 20))
            place = moved[r : r + 10, c : c + 10]
            place[place == old] = new
    yield "sixteen things moved", OccupancyGrid(moved, grid.resolution_m, grid.origin)


def rewritten(grid: OccupancyGrid, yaw: float, resolution_m: float) -> OccupancyGrid:
    """The same place written down with rows that run another way, in cells of another size."""
    height, width = grid.cells.shape
    x, y = grid.points(width / 2, height / 2)
    side = math.ceil(math.hypot(width, height) * grid.resolution_m / resolution_m) + 4
    corner = Pose2D(x=-side * resolution_m / 2, y=-side * resolution_m / 2, yaw=0.0)
    origin = compose(Pose2D(x=float(x), y=float(y), yaw=yaw), corner)
    blank = OccupancyGrid(np.zeros((side, side), np.int8), resolution_m, origin)
    rows, columns = np.indices(blank.cells.shape)
    at = blank.points(columns + 0.5, rows + 0.5)
    cells = np.where(grid.at(*at, grid.occupied), 100, np.where(grid.at(*at, grid.free), 0, -1))
    return OccupancyGrid(cells.astype(np.int8), resolution_m, origin)


def main(homes: int) -> None:
    grids = [home_grid(seed) for seed in range(homes)]
    sketches = [sketch_of(grid) for grid in grids]
    different = [same_place(a, b).agreement for a, b in itertools.combinations(sketches, 2)]
    print(f"{len(different)} pairs of different homes: median {np.median(different):.2f}, most {max(different):.2f}")  # noqa: T201
    print(f"one place from {AGREEMENT_MIN}")  # noqa: T201
    of: dict[str, list[float]] = {}
    for grid, sketch in zip(grids, sketches, strict=True):
        for name, other in changed(grid):
            of.setdefault(name, []).append(same_place(sketch, sketch_of(other)).agreement)
    for name, found in of.items():
        print(f"one home, {name}: median {np.median(found):.2f}, least {min(found):.2f}")  # noqa: T201


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 40)
