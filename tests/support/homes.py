"""Maps of homes that differ by their seed: quick to make, walls and furniture as a laser leaves them."""

import numpy as np

from contracts.geometry import Pose2D
from geometry.grids import OccupancyGrid


def home(seed: int) -> OccupancyGrid:
    """11 x 8.5 m: four walls, others with doors across, things that stand about."""
    rng = np.random.default_rng(seed)
    cells = np.zeros((170, 220), np.int8)
    for across in (cells, cells.T):
        for _ in range(2):
            at, door = int(rng.integers(30, len(across) - 30)), int(rng.integers(5, across.shape[1] - 25))
            across[at : at + 3] = 100
            across[at : at + 3, door : door + 18] = 0
    for _ in range(14):
        high, wide = rng.integers(6, 26, 2).tolist()
        r, c = int(rng.integers(0, 170 - high)), int(rng.integers(0, 220 - wide))
        cells[r : r + high, c : c + wide] = 100
        cells[r + 2 : r + high - 2, c + 2 : c + wide - 2] = -1
    cells[:3] = cells[-3:] = cells[:, :3] = cells[:, -3:] = 100
    return OccupancyGrid(cells, 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0))
