"""The robot's map: what of it can be understood, as a picture, and the question whether a pose lies in it. Pure."""

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts.causes import Refusal
from contracts.geometry import Pose2D
from contracts.robot import MAP_CELLS_MAX
from geometry.grids import MapError, coarser, of_values
from mesh.errors import UnavailableError, UnprocessableError
from robot_bridge.navigation.candidate_poses import ClearanceMap
from robot_bridge.sensing.sensor_readings import Grid, SensorReadings

BYTES_MAX = 256 * 1024 * 1024
"""A map of more cells than this, of a byte each, is refused."""
CELL_M_MIN, CELL_M_MAX = 0.001, 1.0


def understood(values: Sequence[int], width: int, height: int, resolution_m: float, origin: Pose2D) -> Grid:
    """The map of `values`, row by row. One of more than `MAP_CELLS_MAX` cells is made coarser until it fits: a cell is
    occupied where any part of it is. Raises `MapError`, which says why it is no map."""
    if width * height == 0:
        raise MapError(f"the map is empty: {width} x {height} cells")
    if not CELL_M_MIN <= resolution_m <= CELL_M_MAX:
        raise MapError(f"the map's cells are {resolution_m:g} m wide, not {CELL_M_MIN:g} to {CELL_M_MAX:g} m")
    if width * height > BYTES_MAX:
        raise MapError(f"the map is too large: {width} x {height} cells, {BYTES_MAX} bytes are the most")
    sent = of_values(np.asarray(values, np.int8), width, height, round(resolution_m, 7), origin)
    factor = math.ceil(math.sqrt(width * height / MAP_CELLS_MAX))
    if factor == 1:
        return Grid(sent.cells, sent.resolution_m, origin)
    read = coarser(sent, factor)
    if read.resolution_m > CELL_M_MAX:
        raise MapError(f"the map is too large: {width} x {height} cells of {resolution_m:g} m")
    note = f"{width} x {height} cells of {sent.resolution_m:g} m are many: read as cells of {read.resolution_m:g} m"
    return Grid(read.cells, read.resolution_m, origin, note)


def png(grid: Grid) -> bytes:
    """North up: free white, occupied black, unknown grey, as ROS map files look."""
    shades: NDArray[np.uint8] = np.where(grid.cells < 0, 205, 254 - np.clip(grid.cells, 0, 100) * 2.54).astype(np.uint8)
    encoded = cv2.imencode(".png", np.flipud(shades))[1]
    return encoded.tobytes()


def clearance_map(grid: Grid) -> ClearanceMap:
    """How far each free cell is from what is not free (occupied cells and unknown ones alike), in metres."""
    walled = np.pad(grid.free.astype(np.uint8), 1)  # beyond the map nothing is free
    distance = cv2.distanceTransform(walled, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    clearance_m = np.maximum(0.0, distance - 0.5).astype(np.float32) * np.float32(grid.resolution_m)
    return ClearanceMap(clearance_m, grid)


def why_not_in(grid: Grid, pose: Pose2D) -> str | None:
    """Why a goal at `pose` makes no sense; none when it may be tried."""
    cell = grid.cell(pose.x, pose.y)
    if cell is None:
        return f"({pose.x:.2f}, {pose.y:.2f}) is outside the map"
    return f"({pose.x:.2f}, {pose.y:.2f}) is in an unknown part of the map" if grid.unknown[cell] else None


def known(senses: SensorReadings) -> Grid:
    """The robot's map; raises `UnavailableError`, saying why, where there is none."""
    if (grid := senses.map.value) is None:
        why = senses.reception.why_none("map", "no map has been received")
        raise UnavailableError("map", why, code=Refusal.NO_MAP)
    return grid


def check_in_map(grid: Grid, *poses: Pose2D) -> None:
    """Raises `UnprocessableError` where none of the poses makes sense in it."""
    whys = [why_not_in(grid, pose) for pose in poses]
    if all(whys):
        raise UnprocessableError(whys[0] or "", code=Refusal.OUTSIDE_MAP)
