# pyright: basic
"""What is used of SciPy, which carries no types: each function with the types it has in truth."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse import csgraph

Mask = NDArray[np.bool_]
Labels = NDArray[np.int32]
Box = tuple[slice, slice]


def minimum_filter(mask: Mask, size: int) -> Mask:
    """The minimum over a size x size neighbourhood; outside the array it is False."""
    return np.asarray(ndimage.minimum_filter(mask, size=size, mode="constant", cval=False), dtype=bool)


def maximum_filter(mask: Mask, size: int) -> Mask:
    """The maximum over a size x size neighbourhood."""
    return np.asarray(ndimage.maximum_filter(mask, size=size, mode="constant", cval=False), dtype=bool)


def label_regions(mask: Mask) -> tuple[Labels, int]:
    """Connected regions (sides, not corners), numbered from 1, and how many there are."""
    labels, count = ndimage.label(mask)  # type: ignore[misc]
    return np.asarray(labels, dtype=np.int32), int(count)


def region_boxes(labels: Labels) -> list[Box]:
    """The bounding box of each region, in the order of its number."""
    return list(ndimage.find_objects(labels))


def roomiest_cells(mask: Mask, labels: Labels, count: int) -> NDArray[np.intp]:
    """(count, 2): in each region, a cell farthest from what is not in the mask."""
    if count == 0:
        return np.empty((0, 2), dtype=np.intp)
    room = ndimage.distance_transform_edt(mask)
    return np.asarray(ndimage.maximum_position(room, labels, range(1, count + 1)), dtype=np.intp)


def nearest_of(mask: Mask) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Of each cell how many cells the nearest one of the mask is away, and the flat index of that one."""
    away, (rows, columns) = ndimage.distance_transform_edt(~mask, return_indices=True)  # type: ignore[misc]
    return np.asarray(away), np.asarray(rows * mask.shape[1] + columns, dtype=np.intp)


def shortest_walks(
    nodes: int,
    heads: NDArray[np.intp],
    tails: NDArray[np.intp],
    weights: NDArray[np.float64],
    starts: NDArray[np.intp],
    stops: NDArray[np.intp],
) -> NDArray[np.float64]:
    """(starts, stops) lengths of the shortest ways; inf where there is none."""
    graph = sparse.csr_matrix((weights, (heads, tails)), shape=(nodes, nodes))
    return np.asarray(csgraph.dijkstra(graph, directed=False, indices=starts))[:, stops]
