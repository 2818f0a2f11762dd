"""The map that somebody recorded with SLAM: what stands at the robot's height, and what lies outside the walls."""

import math

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import ConvexHull, QhullError

from contracts.geometry import Pose2D
from sim.world.solids import Points, Solid, solid_of_geom
from sim.world.types import OccupancyGrid

RESOLUTION_M = 0.05
BAND_M = (0.012, 0.20)
"""Heights above the floor between which the robot would meet something: from its bumper to the top of its camera."""
MARGIN_M = 0.3
FREE, OCCUPIED, UNKNOWN = 0, 100, -1
_SHRINK = 0.9
"""A cell counts as touched when the outline reaches its inner 90 %: walls on the grid's lines do not grow by a cell."""


class OpenHomeError(ValueError):
    """The walls leave a way out, or the robot stands in something: there is no inside to map."""


def record_map(model: mujoco.MjModel, data: mujoco.MjData, inside: Pose2D, robot_root: int) -> OccupancyGrid:
    """The grid of everything but the robot (body tree `robot_root`), seen from `inside`, a free place of the home.

    Each geom is cut to the height band and its convex footprint drawn; cells that the free space around `inside` does
    not reach are unknown. Raises OpenHomeError.
    """
    solids = (
        solid_of_geom(model, data, geom)
        for geom in range(model.ngeom)
        if model.body_rootid[model.geom_bodyid[geom]] != robot_root
    )
    outlines = [outline for solid in solids if solid is not None and (outline := footprint(solid)) is not None]
    if not outlines:
        raise OpenHomeError("nothing stands in this home, not even a wall")
    corners = np.concatenate(outlines)
    origin = np.floor((corners.min(0) - MARGIN_M) / RESOLUTION_M) * RESOLUTION_M
    width, height = np.ceil((corners.max(0) + MARGIN_M - origin) / RESOLUTION_M).astype(int).tolist()
    taken = np.zeros((height, width), bool)
    for outline in outlines:
        draw(taken, (outline - origin) / RESOLUTION_M)
    cells = np.where(taken, OCCUPIED, UNKNOWN).astype(np.int8)
    cells[_reached(taken, (np.array([inside.x, inside.y]) - origin) / RESOLUTION_M)] = FREE
    return OccupancyGrid(cells, RESOLUTION_M, round(float(origin[0]), 6), round(float(origin[1]), 6))


def footprint(solid: Solid) -> Points | None:
    """Corners (n, 2) of what a solid covers within the height band, counter-clockwise; None where it covers nothing."""
    low, high = BAND_M
    z = solid.corners[:, 2]
    if z.max() <= low or z.min() >= high:
        return None
    inside = solid.corners[(z >= low) & (z <= high), :2]
    a, b = solid.corners[solid.edges[:, 0]], solid.corners[solid.edges[:, 1]]
    cuts = [_cut(a, b, level) for level in BAND_M]
    points = np.concatenate([inside, *cuts])
    try:
        return points[ConvexHull(points).vertices]
    except (QhullError, ValueError):  # thinner than a line: nothing to draw
        return None


def _cut(a: Points, b: Points, level_m: float) -> Points:
    """Where the edges a-b pass through a height."""
    rise = b[:, 2] - a[:, 2]
    through = (a[:, 2] - level_m) * (b[:, 2] - level_m) < 0
    share = ((level_m - a[through, 2]) / rise[through])[:, None]
    return a[through, :2] + share * (b[through, :2] - a[through, :2])


def draw(cells: NDArray[np.bool_], outline: Points) -> None:
    """Mark every cell that a convex outline (n, 2; in cells, counter-clockwise) overlaps, by separating axes."""
    half = _SHRINK / 2
    x0, y0 = np.maximum(np.floor(outline.min(0) + 0.5 - half), 0).astype(int).tolist()
    x1, y1 = np.floor(outline.max(0) + 0.5 + half).astype(int).tolist()
    x, y = np.meshgrid(np.arange(x0, min(x1, cells.shape[1])) + 0.5, np.arange(y0, min(y1, cells.shape[0])) + 0.5)
    along = np.roll(outline, -1, axis=0) - outline
    normal = np.stack([along[:, 1], -along[:, 0]], 1) / np.maximum(np.linalg.norm(along, axis=1), 1e-12)[:, None]
    offset = (normal * outline).sum(1)
    beyond = normal[:, 0, None, None] * x + normal[:, 1, None, None] * y - offset[:, None, None]
    reach = half * np.abs(normal).sum(1)
    cells[y0 : y0 + x.shape[0], x0 : x0 + x.shape[1]] |= (beyond < reach[:, None, None]).all(0)


def _reached(taken: NDArray[np.bool_], start_cells: Points) -> NDArray[np.bool_]:
    """The free cells connected to the start (or to the nearest free cell within 0.25 m of it)."""
    regions, _ = ndimage.label(~taken)
    column, row = (math.floor(v) for v in start_cells.tolist())
    near = [
        (abs(r - row) + abs(c - column), int(regions[r, c]))
        for r in range(max(0, row - 5), min(taken.shape[0], row + 6))
        for c in range(max(0, column - 5), min(taken.shape[1], column + 6))
        if regions[r, c]
    ]
    if not near:
        raise OpenHomeError("there is no free floor where the map should begin")
    region = regions == min(near)[1]
    if region[0].any() or region[-1].any() or region[:, 0].any() or region[:, -1].any():
        raise OpenHomeError("the home's outer walls leave a way out")
    return region


def clearance_m(grid: OccupancyGrid) -> NDArray[np.float64]:
    """(H, W) m from each cell's middle to the edge of the nearest cell that is not free; below 0 in such a cell."""
    steps: NDArray[np.float64] = np.asarray(ndimage.distance_transform_edt(grid.data == FREE))
    return (steps - 0.5) * grid.resolution_m


def reachable(grid: OccupancyGrid, start: Pose2D, radius_m: float) -> NDArray[np.bool_]:
    """Cells on whose middle a robot of this radius can stand, coming from `start`; bool (H, W).

    A start that stands too close to something (a dock) is taken to be in the nearest such region within 0.8 m.
    """
    regions, count = ndimage.label(clearance_m(grid) >= radius_m, structure=np.ones((3, 3)))
    if count == 0:
        return np.zeros(grid.data.shape, bool)
    row, column = grid.cell(start.x, start.y)
    rows, columns = np.nonzero(regions)
    away = np.hypot(rows - row, columns - column) * grid.resolution_m
    nearest = int(np.argmin(away))
    if away[nearest] > 0.8:
        return np.zeros(grid.data.shape, bool)
    return regions == regions[rows[nearest], columns[nearest]]
