"""Floor plans of any size for the planners: rooms of four metres, doors of 0.9 m, furniture; drawn from a seed."""

import numpy as np

from coordinator.grid import Grid

RESOLUTION_M = 0.05
ROOM_CELLS, DOOR_CELLS, WALL_CELLS = 80, 18, 2


def floor_plan(width_m: float, depth_m: float, *, seed: int = 0) -> Grid:
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
    return Grid(free=free, occupied=~free, resolution_m=RESOLUTION_M, origin_x_m=0.0, origin_y_m=0.0)
