"""The occupancy grid as others want it: a message, a picture, and the question whether a pose lies in it. Pure."""

import base64
import math
import zlib

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from contracts.robot import Map
from mesh.errors import UnavailableError, UnprocessableError
from robot_bridge.ring import Room
from robot_bridge.senses import Grid
from robot_bridge.transforms import compose, inverse

OCCUPIED_FROM = 50
"""Cells from this value on are no place for a robot."""


def message(grid: Grid) -> Map:
    height, width = grid.cells.shape
    packed = zlib.compress(grid.cells.tobytes(), level=6)
    return Map(
        width=width,
        height=height,
        resolution_m=grid.resolution_m,
        origin=grid.origin,
        data_base64=base64.b64encode(packed).decode("ascii"),
    )


def png(grid: Grid) -> bytes:
    """North up: free white, occupied black, unknown grey, as ROS map files look."""
    shades: NDArray[np.uint8] = np.where(grid.cells < 0, 205, 254 - np.clip(grid.cells, 0, 100) * 2.54).astype(np.uint8)
    encoded = cv2.imencode(".png", np.flipud(shades))[1]
    return encoded.tobytes()


def room_of(grid: Grid) -> Room:
    """How far each free cell is from what is not free (100 cells and unknown ones alike), in metres."""
    free = ((grid.cells >= 0) & (grid.cells < OCCUPIED_FROM)).astype(np.uint8)
    walled = np.pad(free, 1)  # beyond the map nothing is free
    distance = cv2.distanceTransform(walled, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    clearance_m = np.maximum(0.0, distance - 0.5).astype(np.float32) * np.float32(grid.resolution_m)
    return Room(clearance_m, grid.resolution_m, grid.origin)


def cell_at(grid: Grid, pose: Pose2D) -> int | None:
    """The cell's value; none outside the map."""
    local = compose(inverse(grid.origin), pose)
    column = math.floor(local.x / grid.resolution_m)
    row = math.floor(local.y / grid.resolution_m)
    height, width = grid.cells.shape
    return int(grid.cells[row, column]) if 0 <= row < height and 0 <= column < width else None


def why_not_in(grid: Grid, pose: Pose2D) -> str | None:
    """Why a goal at `pose` makes no sense; none when it may be tried."""
    value = cell_at(grid, pose)
    if value is None:
        return f"({pose.x:.2f}, {pose.y:.2f}) is outside the map"
    return f"({pose.x:.2f}, {pose.y:.2f}) is in an unknown part of the map" if value < 0 else None


def check_in_map(grid: Grid | None, pose: Pose2D) -> None:
    """Raises `UnavailableError` where there is no map yet, `UnprocessableError` where the pose makes no sense in it."""
    if grid is None:
        raise UnavailableError("map", "no map has been received")
    if why := why_not_in(grid, pose):
        raise UnprocessableError(why)
