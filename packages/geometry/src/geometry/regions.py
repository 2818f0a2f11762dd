"""Regions of a mask: connected cells, their sizes, what closes and what grows. Arrays in, arrays out; pure."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]
Labels = NDArray[np.int32]
"""(height, width): 0 for no region, else its number from 1."""


def label(mask: Mask, *, corners: bool = False) -> tuple[Labels, int]:
    """Connected regions of `mask`, numbered in the order of their first cell, and how many they are.

    Cells are neighbours by their sides, with `corners` by their corners too. Runs of cells are joined, not cells
    (the two passes of Rosenfeld and Pfaltz, 1966).
    """
    height, width = mask.shape
    rows, starts, ends = runs(mask)
    reach = 1 if corners else 0
    parent = list(range(len(rows)))

    def root(k: int) -> int:
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    begin: list[int] = [0, *np.cumsum(np.bincount(rows, minlength=height)).tolist()]
    low: list[int] = starts.tolist()
    high: list[int] = ends.tolist()
    for row in range(1, height):
        above, here = begin[row - 1], begin[row]
        while above < begin[row] and here < begin[row + 1]:
            if low[above] < high[here] + reach and low[here] < high[above] + reach:
                one, other = root(above), root(here)
                parent[max(one, other)] = min(one, other)
            above, here = (above + 1, here) if high[above] < high[here] else (above, here + 1)
    roots, numbers = np.unique([root(k) for k in range(len(rows))], return_inverse=True)
    out = np.zeros(height * width + 1, np.int32)  # each run's number, put down at its start and taken away behind it
    np.add.at(out, rows * width + starts, numbers + 1)
    np.subtract.at(out, rows * width + ends, numbers + 1)
    return np.cumsum(out[:-1], dtype=np.int32).reshape(height, width), len(roots)


def runs(mask: Mask) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Row, first column and column behind the last of each run of true cells along the rows, in reading order."""
    padded = np.pad(mask, ((0, 0), (1, 1))).astype(np.int8)
    steps = np.diff(padded, axis=1)
    rows, starts = np.nonzero(steps == 1)
    return rows, starts, np.nonzero(steps == -1)[1]


def run_lengths(mask: Mask) -> NDArray[np.int32]:
    """(height, width): how many cells the run along the row has that a cell is in; 0 where the mask is false."""
    rows, starts, ends = runs(mask)
    width = mask.shape[1]
    out = np.zeros(mask.size + 1, np.int32)
    np.add.at(out, rows * width + starts, ends - starts)
    np.subtract.at(out, rows * width + ends, ends - starts)
    return np.cumsum(out[:-1], dtype=np.int32).reshape(mask.shape)


def sizes(labels: Labels, count: int) -> NDArray[np.intp]:
    """(count + 1,): the cells of each number, 0 among them."""
    return np.bincount(labels.ravel(), minlength=count + 1)


def boxes(labels: Labels, count: int) -> NDArray[np.intp]:
    """(count + 1, 2): the shorter and the longer side of each region's upright box, in cells."""
    rows, columns = np.nonzero(labels)
    of = labels[rows, columns]
    sides = np.zeros((count + 1, 2), np.intp)
    for k, at in enumerate((rows, columns)):
        low, high = np.full(count + 1, np.iinfo(np.intp).max), np.full(count + 1, -1, np.intp)
        np.minimum.at(low, of, at)
        np.maximum.at(high, of, at)
        sides[:, k] = np.where(high >= 0, high - low + 1, 0)
    return np.sort(sides, axis=1)


def dilated(mask: Mask, cells: int) -> Mask:
    """What lies within so many cells of it, in rows and columns alike."""
    return _grown(_grown(mask, cells).T, cells).T


def closed(mask: Mask, cells: int) -> Mask:
    """Gaps of up to twice so many cells are filled; nothing else changes (dilation, then erosion)."""
    padded = np.pad(mask, cells)
    out = ~dilated(~dilated(padded, cells), cells)
    return out[cells:-cells, cells:-cells] if cells else out


def spread(labels: Labels, space: Mask) -> Labels:
    """The numbers grown through `space`, a cell at a time, until nothing of it that they reach is left without one."""
    out = labels.copy()
    while True:
        padded = np.pad(out, 1)
        near = np.maximum.reduce([padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]])
        new = (out == 0) & space & (near > 0)
        if not new.any():
            return out
        out[new] = near[new]


def depth(mask: Mask) -> NDArray[np.int32]:
    """How many cells deep inside a cell lies: 1 at the edge, 0 outside, diagonals counted."""
    left, out = mask.copy(), np.zeros(mask.shape, np.int32)
    while left.any():
        out += left
        padded = np.pad(left, 1)
        left = ~dilated(~padded, 1)[1:-1, 1:-1] & left
    return out


def _grown(mask: Mask, cells: int) -> Mask:
    out = mask.copy()
    for k in range(1, min(cells, mask.shape[1] - 1) + 1):
        out[:, k:] |= mask[:, :-k]
        out[:, :-k] |= mask[:, k:]
    return out


def bounds_of(mask: Mask) -> tuple[Any, ...]:
    """The slices of rows and columns that hold all of it; all of the array where it is empty."""
    rows, columns = np.nonzero(mask)
    if not rows.size:
        return (slice(0, mask.shape[0]), slice(0, mask.shape[1]))
    return (slice(int(rows.min()), int(rows.max()) + 1), slice(int(columns.min()), int(columns.max()) + 1))
