"""Regions of a mask: connected cells, their sizes, what closes and what grows. Arrays in, arrays out; pure."""

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]
Labels = NDArray[np.int32]
"""(height, width): 0 for no region, else its number from 1."""
Indices = NDArray[np.intp]


def label(mask: Mask, *, corners: bool = False) -> tuple[Labels, int]:
    """Connected regions of `mask`, numbered in the order of their first cell, and how many they are.

    Cells are neighbours by their sides, with `corners` by their corners too. Runs of cells are joined, not cells
    (the two passes of Rosenfeld and Pfaltz, 1966).
    """
    height, width = mask.shape
    rows, starts, ends = runs(mask)
    roots, numbers = np.unique(_roots(len(rows), *_touching(rows, starts, ends, width, corners)), return_inverse=True)
    out = np.zeros(height * width + 1, np.int32)  # each run's number, put down at its start and taken away behind it
    np.add.at(out, rows * width + starts, numbers + 1)
    np.subtract.at(out, rows * width + ends, numbers + 1)
    return np.cumsum(out[:-1], dtype=np.int32).reshape(height, width), len(roots)


def _touching(rows: Indices, starts: Indices, ends: Indices, width: int, corners: bool) -> tuple[Indices, Indices]:
    """Pairs of runs that touch, one in the row above the other's."""
    stride, reach = width + 2, 1 if corners else 0
    above = (rows - 1) * stride
    first = np.searchsorted(rows * stride + ends, above + starts - reach, "right")
    behind = np.searchsorted(rows * stride + starts, above + ends + reach, "left")
    counts = np.maximum(behind - first, 0)
    of = np.repeat(np.arange(len(rows)), counts)
    before: Indices = np.cumsum(counts) - counts
    return np.arange(int(counts.sum())) - np.repeat(before - first, counts), of


def _roots(count: int, one: Indices, other: Indices) -> Indices:
    """(count,): the least number that each is joined to by the pairs; joined to the least neighbour, round by round."""
    root = np.arange(count)
    while one.size:
        np.minimum.at(root, np.maximum(one, other), np.minimum(one, other))
        while (root[root] != root).any():
            root = root[root]
        one, other = root[one], root[other]
        apart = one != other
        one, other = one[apart], other[apart]
    return root


def runs(cells: Mask | Labels) -> tuple[Indices, Indices, Indices]:
    """Row, first column and column behind the last of each run of equal cells that are not 0 along the rows, in reading
    order."""
    padded = np.pad(cells, ((0, 0), (1, 1)))
    steps, some = padded[:, 1:] != padded[:, :-1], cells != 0
    rows, starts = np.nonzero(steps[:, :-1] & some)
    return rows, starts, np.nonzero(steps[:, 1:] & some)[1] + 1


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
    low, high = extents(labels, count)
    return np.sort(np.maximum(high - low, 0), axis=1)


def extents(labels: Labels, count: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Twice (count + 1, 2): the first row and column of each region, and those behind its last; for 0 and for a number
    that no cell bears, the second lies before the first."""
    height, width = labels.shape
    low = np.full((count + 1, 2), max(height, width), np.intp)
    high = np.full((count + 1, 2), -1, np.intp)
    rows, starts, ends = runs(labels)
    of = labels[rows, starts]
    for k, first, behind in ((0, rows, rows + 1), (1, starts, ends)):
        np.minimum.at(low[:, k], of, first)
        np.maximum.at(high[:, k], of, behind)
    return low, high


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
    stride = labels.shape[1] + 2
    padded = np.pad((labels == 0) & space, 2)
    beside_left = padded[1:-1, :-2] | padded[1:-1, 2:] | padded[:-2, 1:-1] | padded[2:, 1:-1]
    out, left = np.pad(labels, 1).ravel(), padded[1:-1, 1:-1].flatten()
    reached = np.nonzero((out > 0) & beside_left.ravel())[0]
    while reached.size:
        beside = (reached[:, None] + np.array([-stride, -1, 1, stride])).ravel()
        by = np.repeat(out[reached], 4)
        new = left[beside]
        reached = beside[new]
        np.maximum.at(out, reached, by[new])
        left[reached] = False
        reached = np.unique(reached)
    return out.reshape(-1, stride)[1:-1, 1:-1].copy()


def depth(mask: Mask) -> NDArray[np.int32]:
    """How many cells deep inside a cell lies: 1 at the edge, 0 outside, diagonals counted.

    The chessboard distance, in one pass down and one up (Rosenfeld and Pfaltz, 1966).
    """
    out = np.pad(np.where(mask, np.int32(max(mask.shape)), np.int32(0)), 1)
    columns = np.arange(out.shape[1], dtype=np.int32)
    for row, before in (*((k, k - 1) for k in range(1, len(out))), *((k, k + 1) for k in range(len(out) - 2, -1, -1))):
        near = out[before].copy()
        near[1:] = np.minimum(near[1:], out[before, :-1])
        near[:-1] = np.minimum(near[:-1], out[before, 1:])
        at = np.minimum(out[row], near + 1)
        at = np.minimum.accumulate(at - columns) + columns
        out[row] = np.minimum.accumulate((at + columns)[::-1])[::-1] - columns
    return out[1:-1, 1:-1].copy()


def _grown(mask: Mask, cells: int) -> Mask:
    out = mask.copy()
    for k in range(1, min(cells, mask.shape[1] - 1) + 1):
        out[:, k:] |= mask[:, :-k]
        out[:, :-k] |= mask[:, k:]
    return out


def depths(labels: Labels) -> NDArray[np.int32]:
    """How many cells deep inside its own region a cell lies; see `depth`."""
    padded = np.pad(labels, 1)
    flat = (padded[:, 1:-1] == padded[:, :-2]) & (padded[:, 1:-1] == padded[:, 2:])
    same = (labels == padded[:-2, 1:-1]) & (labels == padded[2:, 1:-1])
    inner = (labels > 0) & same & flat[:-2] & flat[1:-1] & flat[2:]
    return depth(inner) + (labels > 0)


def bounds_of(mask: Mask) -> tuple[slice, slice]:
    """The slices of rows and columns that hold all of it; all of the array where it is empty."""
    rows, columns = (np.nonzero(mask.any(axis=axis))[0] for axis in (1, 0))
    if not rows.size:
        return (slice(0, mask.shape[0]), slice(0, mask.shape[1]))
    return (slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1))
