"""Floor plans of any size for the planners: rooms of four metres, doors of 0.9 m, furniture; drawn from a seed."""

import numpy as np

from contracts.geometry import Pose2D
from geometry.grids import OccupancyGrid

RESOLUTION_M = 0.05
ROOM_CELLS, DOOR_CELLS, WALL_CELLS = 80, 18, 2


def floor_plan(width_m: float, depth_m: float, *, seed: int = 0) -> OccupancyGrid:
    """Every room has a door to each neighbour; furniture keeps a metre away from every door."""
    rng = np.random.default_rng(seed)
    rows, columns = round(depth_m / RESOLUTION_M), round(width_m / RESOLUTION_M)
    free = np.ones((rows, columns), dtype=bool)
    doors = np.zeros_like(free)
    for row in range(ROOM_CELLS, rows - ROOM_CELLS // 2, ROOM_CELLS):
        free[row - WALL_CELLS : row + WALL_CELLS] = False
        for column in range(0, columns - ROOM_CELLS // 2, ROOM_CELLS):
            at = column + 16 + int(rng.integers(0, ROOM_CELLS - DOOR_CELLS - 32))
            doors[row - WALL_CELLS : row + WALL_CELLS, at : at + DOOR_CELLS] = True
    for column in range(ROOM_CELLS, columns - ROOM_CELLS // 2, ROOM_CELLS):
        free[:, column - WALL_CELLS : column + WALL_CELLS] = False
        for row in range(0, rows - ROOM_CELLS // 2, ROOM_CELLS):
            at = row + 16 + int(rng.integers(0, ROOM_CELLS - DOOR_CELLS - 32))
            doors[at : at + DOOR_CELLS, column - WALL_CELLS : column + WALL_CELLS] = True
    free |= doors
    kept = np.pad(doors, 20)
    for _ in range(round(width_m * depth_m / 5.0)):
        high, wide = rng.integers(6, 26, 2).tolist()
        row, column = int(rng.integers(0, rows - high)), int(rng.integers(0, columns - wide))
        if not kept[row : row + high + 40, column : column + wide + 40].any():
            free[row : row + high, column : column + wide] = False
    free[:WALL_CELLS] = free[-WALL_CELLS:] = free[:, :WALL_CELLS] = free[:, -WALL_CELLS:] = False
    cells = np.where(free, 0, 100).astype(np.int8)
    return OccupancyGrid(cells, RESOLUTION_M, Pose2D(x=0.0, y=0.0, yaw=0.0))
