"""A stand-in for slam_toolbox's map, not slam_toolbox: it lays laser scans together at the poses it is told.

The map holds what was seen and grows with it. Cells count how often a beam passed and how often it ended there, and
are judged as slam_toolbox's Karto does. What is missing: nothing is matched, no loop is closed. The poses come from
the simulated localiser, which errs by a few centimetres and never loses itself.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from geometry.poses import apart_m, wrap
from sim.nav.obstacles import valid
from sim.world.types import OccupancyGrid, Scan

RESOLUTION_M: Final = 0.05
BEGINS_M: Final = 8.0
"""The counts begin with so much room to each side of where the robot stands, and grow by as much."""
PASSES_MIN: Final = 2
OCCUPIED_RATIO: Final = 0.1
"""Karto's: a cell is occupied from this share of ends among its beams on, and known from two beams on."""
MOVED_M: Final = 0.1
TURNED_RAD: Final = 0.1
FREE, OCCUPIED, UNKNOWN = 0, 100, -1

Counts = NDArray[np.int32]


class Mapper:
    """`observe` each scan; `grid` is the map of now."""

    def __init__(self) -> None:
        self._passes: Counts = np.zeros((0, 0), np.int32)
        self._ends: Counts = np.zeros((0, 0), np.int32)
        self._corner = (0, 0)
        """Row and column of the first cell, in cells of the map frame."""
        self._at: Pose2D | None = None
        self._seen_since_moved = 0

    def observe(self, scan: Scan, laser: Pose2D) -> bool:
        """`laser` is its pose in the map when the scan was taken. False = nothing new: it stands where it stood."""
        if self._at is not None and not self._moved(laser) and self._seen_since_moved >= PASSES_MIN:
            return False
        if self._at is None or self._moved(laser):
            self._at, self._seen_since_moved = laser, 0
        self._seen_since_moved += 1
        hit = valid(scan)
        ranges = np.where(hit, scan.ranges_m, scan.range_max_m).astype(np.float64)
        bearings = laser.yaw + scan.angle_min + scan.angle_increment * np.arange(len(ranges))
        ends_x, ends_y = laser.x + ranges * np.cos(bearings), laser.y + ranges * np.sin(bearings)
        self._make_room(np.append(ends_x, laser.x), np.append(ends_y, laser.y))
        steps = np.arange(0.0, float(ranges.max()), RESOLUTION_M / 2)
        along = steps[None, :] < (ranges - RESOLUTION_M)[:, None]
        rays, which = np.nonzero(along)
        x = laser.x + steps[which] * np.cos(bearings[rays])
        y = laser.y + steps[which] * np.sin(bearings[rays])
        passed = np.zeros(self._passes.shape, bool)
        passed[self._cells(x, y)] = True
        ended = np.zeros_like(passed)
        ended[self._cells(ends_x[hit], ends_y[hit])] = True
        self._passes += passed | ended
        self._ends += ended
        return True

    def grid(self) -> OccupancyGrid | None:
        """What is known, and a cell of unknown round it. None before the first scan."""
        known = self._passes >= PASSES_MIN
        if not known.any():
            return None
        rows, columns = (np.nonzero(known.any(axis=axis))[0] for axis in (1, 0))
        part = slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
        passes, ends = self._passes[part], self._ends[part]
        cells = np.where(ends >= OCCUPIED_RATIO * passes, OCCUPIED, FREE)
        cells = np.pad(np.where(known[part], cells, UNKNOWN).astype(np.int8), 1, constant_values=UNKNOWN)
        row, column = self._corner[0] + int(rows[0]) - 1, self._corner[1] + int(columns[0]) - 1
        return OccupancyGrid(cells, RESOLUTION_M, round(column * RESOLUTION_M, 6), round(row * RESOLUTION_M, 6))

    def _moved(self, laser: Pose2D) -> bool:
        assert self._at is not None
        return apart_m(self._at, laser) >= MOVED_M or abs(wrap(self._at.yaw - laser.yaw)) >= TURNED_RAD

    def _make_room(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> None:
        more = math.ceil(BEGINS_M / RESOLUTION_M)
        low = math.floor(float(y.min()) / RESOLUTION_M), math.floor(float(x.min()) / RESOLUTION_M)
        high = math.floor(float(y.max()) / RESOLUTION_M) + 1, math.floor(float(x.max()) / RESOLUTION_M) + 1
        if not self._passes.size:
            self._corner = low
        before = tuple(max(0, self._corner[k] - low[k] + more) if low[k] < self._corner[k] else 0 for k in (0, 1))
        shape = self._passes.shape
        behind = tuple(
            high[k] - (self._corner[k] + shape[k]) + more if high[k] > self._corner[k] + shape[k] else 0 for k in (0, 1)
        )
        if any((*before, *behind)):
            widths = tuple(zip(before, behind, strict=True))
            self._passes, self._ends = np.pad(self._passes, widths), np.pad(self._ends, widths)
            self._corner = self._corner[0] - before[0], self._corner[1] - before[1]

    def _cells(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        rows = np.floor(y / RESOLUTION_M).astype(np.intp) - self._corner[0]
        columns = np.floor(x / RESOLUTION_M).astype(np.intp) - self._corner[1]
        return rows, columns
