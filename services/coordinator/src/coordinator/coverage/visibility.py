"""What can be seen from each of many places: a row of bits over the same disc of cells round every one of them."""

import heapq

import numpy as np
from numpy.typing import NDArray

from geometry.grids import Mask

RAYS = 72
BATCH = 2048


class VisibilityIndex:
    """`places` is (n, 2) cells of a map; everything within `reach` cells of one that no `blocked` cell hides is seen.

    With `edges` the first hiding cell of a ray is seen too: what stands at a wall fills its cell of the map.
    Rays leave every place at the same angles, so they cross the same cells relative to it: the disc is worked out once.
    """

    def __init__(
        self, blocked: Mask, places: NDArray[np.intp], reach: int, *, rays: int = RAYS, edges: bool = False
    ) -> None:
        self.shape = blocked.shape
        self._reach = reach
        self._rays = rays
        self._width = blocked.shape[1] + 2 * reach
        open_cells = ~np.pad(blocked, reach, constant_values=True).ravel()
        self._middles = (places[:, 0] + reach) * self._width + places[:, 1] + reach
        ray_cells, self._disc, order, starts = self._geometry()
        self._seen = np.empty((len(places), len(self._disc)), dtype=bool)
        for first in range(0, len(places), BATCH):
            middles = self._middles[first : first + BATCH, None]
            clear = np.empty((ray_cells.shape[1], *(len(middles), ray_cells.shape[0])), dtype=bool)
            alive = np.ones(clear.shape[1:], dtype=bool)
            for k in range(ray_cells.shape[1]):
                reached = alive & open_cells[middles + ray_cells[:, k]]
                clear[k] = alive if edges else reached
                alive = reached
            by_cell = clear.transpose(1, 0, 2).reshape(len(middles), -1)[:, order]
            self._seen[first : first + BATCH] = np.logical_or.reduceat(by_cell, starts, axis=1)

    @property
    def around(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """(rows, columns) of the disc's cells, relative to a place."""
        shifted = self._disc + self._reach * (self._width + 1)
        return shifted // self._width - self._reach, shifted % self._width - self._reach

    @property
    def seen(self) -> Mask:
        """(places, disc)."""
        return self._seen

    @property
    def cells(self) -> NDArray[np.intp]:
        """(places, disc): flat cells of the map with `reach` cells added on each side."""
        return self._middles[:, None] + self._disc

    def cover(self, wanted: Mask, *, gain_min: int, places_max: int) -> tuple[list[int], Mask]:
        """Greedy set cover: always the place that sees most of what is left, until none sees `gain_min` cells.

        Returns the places, and which of the wanted cells none of them sees. Gains only ever fall, so a place whose old
        gain is the highest is looked at again, and taken if it still leads.
        """
        padded = np.pad(wanted, self._reach)
        left = padded.ravel()
        heap = [(-gain, place) for place, gain in enumerate(self._gains(left)) if gain >= gain_min]
        heapq.heapify(heap)
        chosen: list[int] = []
        while heap and len(chosen) < places_max:
            place = heapq.heappop(heap)[1]
            cells = self._middles[place] + self._disc
            gain = int(np.count_nonzero(left[cells] & self._seen[place]))
            if gain < gain_min:
                continue
            if heap and gain < -heap[0][0]:
                heapq.heappush(heap, (-gain, place))
                continue
            chosen.append(place)
            left[cells[self._seen[place]]] = False
        reach = self._reach
        return chosen, padded[reach : reach + self.shape[0], reach : reach + self.shape[1]]

    def _gains(self, left: NDArray[np.bool_]) -> list[int]:
        gains = np.empty(len(self._middles), dtype=np.intp)
        for first in range(0, len(gains), BATCH):
            cells = self._middles[first : first + BATCH, None] + self._disc
            gains[first : first + BATCH] = (left[cells] & self._seen[first : first + BATCH]).sum(axis=1)
        return gains.tolist()

    def _geometry(self) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
        """Offsets of each ray's cells (rays, steps), of the disc's cells, and how the former sort into the latter."""
        angles = np.linspace(0.0, 2 * np.pi, self._rays, endpoint=False)
        steps = np.arange(self._reach + 1)
        rows = np.rint(np.sin(angles)[:, None] * steps).astype(np.intp)
        columns = np.rint(np.cos(angles)[:, None] * steps).astype(np.intp)
        rays = rows * self._width + columns
        flat = rays.T.ravel()
        order = np.argsort(flat, kind="stable")
        disc, starts = np.unique(flat[order], return_index=True)
        return rays, disc, order, starts
