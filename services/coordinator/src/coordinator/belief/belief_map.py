"""One belief: how probably the target stands in each cell, and how probably nowhere here. It sums to one.

A look in vain takes from every cell in sight what the detector would have seen there. Looks at a cell from one side
count once, by the best of them: what hides a thing in one picture hides it in the next one too. So the order of looks
is no matter, and none is counted twice.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from coordinator.belief.clues import Clue
from coordinator.belief.detection_probability import across, by_distance
from coordinator.coverage.untyped import maximum_filter
from coordinator.coverage.viewpoints import CoarseMap, blocks_of, candidate_cells, coarsen
from coordinator.coverage.visibility import VisibilityIndex
from geometry.grids import Mask, OccupancyGrid
from geometry.poses import wrap

HERE = 0.85
"""That a thing one asks for is in this home at all, where memory knows nothing of it."""
AT_AN_EDGE = 4.0
"""Times as probable as the middle of a floor: things stand at walls and at furniture."""
BEYOND = 3.0
"""A cell at the edge of the unknown stands for so many cells behind it."""
OFF_THE_FLOOR_M = 1.2
"""A thing on a shelf lies so far off the free floor at most. It is looked for at the edge nearest to it."""
SIDES = 8
REACH_M = 4.5
RAYS = 180
PLACES_AT_ONCE = 256
"""Views that are worked out together: 12 MB, however large the map."""
SEEN_TIMES = 6.0
"""A box of the target's class makes what lies behind it so many times more probable, until it is judged."""
CONFIRMED_TIMES = 100.0
"""The same of a place where the votes confirmed it, until it is reached or refused."""
REFUSED_M, REFUSED_LEFT = 0.4, 0.05

Cells = NDArray[np.float64]
_Shown = tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]
"""Cells of one look: sides, rows, columns."""


@dataclass(frozen=True, slots=True)
class Glance:
    """One look: from where, and the bearings (in the robot's frame) of boxes that may be the target."""

    pose: Pose2D
    hfov_rad: float
    boxes_rad: tuple[tuple[float, float], ...] = ()
    moving: bool = False


@dataclass(frozen=True, slots=True)
class _Seen:
    """Of the cells in reach of one picture: whether it shows them, how probably it would what stands there, how
    probably in its middle, and the bearing from the camera's axis, rad.
    """

    shown: NDArray[np.bool_]
    chance: Cells
    in_the_middle: Cells
    bearings: Cells
    sides: NDArray[np.intp]
    rows: NDArray[np.intp]
    columns: NDArray[np.intp]

    def at(self, some: NDArray[np.bool_]) -> _Shown:
        return self.sides[some], self.rows[some], self.columns[some]


class BeliefMap:
    """Over one map; a new map begins a new one, to which the looks are told again."""

    def __init__(
        self,
        grid: OccupancyGrid,
        *,
        label: str,
        clues: Sequence[Clue],
        radius_m: float,
        start: Pose2D | None,
        within: Mask | None = None,
    ) -> None:
        """`within`: the cells it is looked for in alone; none: all of them."""
        self.grid = grid
        self.label = label
        self.coarse: CoarseMap = coarsen(grid, radius_m, start)
        self.reach = int(REACH_M / self.coarse.resolution_m)
        self._within = within
        self.clues = tuple(clues)
        self._prior = self._believed_before()
        self.doubt = np.zeros((SIDES, *self._prior.shape))
        """(sides, rows, columns): the best chance so far of having seen it there, from each side."""
        self.looked = self.doubt.copy()
        """The same of every look, in vain or not: to look there again from that side shows nothing new."""
        self._boxed: list[tuple[_Shown, Cells]] = []
        self._refused = np.zeros(self._prior.shape, dtype=bool)
        self._expected = self._refused.copy()

    @property
    def cells(self) -> Cells:
        """(rows, columns) probabilities."""
        left = self._left()
        return left / (left.sum() + self._absent)

    @property
    def absent(self) -> float:
        """That it is nowhere on this map."""
        return self._absent / float(self._left().sum() + self._absent)

    def look(self, glance: Glance) -> None:
        """In vain but for the boxes. A look from outside the map tells nothing."""
        place = self.cell(glance.pose)
        if place is None:
            return
        seen = self._seen(place, glance.pose, glance.hfov_rad)
        vain = seen.shown.copy()
        for low, high in glance.boxes_rad:
            boxed = seen.shown & (seen.bearings >= low) & (seen.bearings <= high)
            vain &= ~boxed
            at = seen.at(boxed)
            self._boxed.append((at, seen.chance[boxed]))
            if not glance.moving:  # nobody stops for one box in passing: what it may be is still to be looked at
                self.looked[at] = np.maximum(self.looked[at], seen.in_the_middle[boxed])
        self._in_vain(seen.at(vain), seen.chance[vain])

    def spend(self, pose: Pose2D, hfov_rad: float) -> None:
        """A look from there was chosen and taken, if not quite from there: to choose it again shows nothing new."""
        place = self.cell(pose)
        if place is not None:
            seen = self._seen(place, pose, hfov_rad)
            at = seen.at(seen.shown)
            self.looked[at] = np.maximum(self.looked[at], seen.in_the_middle[seen.shown])

    def _seen(self, place: tuple[int, int], pose: Pose2D, hfov_rad: float) -> "_Seen":
        view = VisibilityIndex(self.coarse.blocked, np.array([place]), self.reach, rays=RAYS, edges=True)
        rows, columns = view.around
        bearings = np.arctan2(rows, columns) + self.grid.origin.yaw - pose.yaw
        bearings = (bearings + np.pi) % (2 * np.pi) - np.pi
        off_axis = np.abs(np.tan(np.clip(bearings, -1.5, 1.5))) / math.tan(hfov_rad / 2)
        off_axis = np.where(np.abs(bearings) < np.pi / 2, off_axis, np.inf)
        in_the_middle = by_distance(self.label, np.hypot(rows, columns) * self.coarse.resolution_m)
        chance = in_the_middle * across(off_axis)
        sides = sides_of(rows, columns)
        rows, columns = rows + place[0], columns + place[1]
        height, width = self._prior.shape
        shown = view.seen[0] & (chance > 0) & (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        return _Seen(shown, chance, in_the_middle, bearings, sides, rows, columns)

    def refuse(self, x: float, y: float) -> None:
        """What stands there was judged, and is another thing: the looks that showed its box were in vain."""
        there = self._apart_m(x, y) <= REFUSED_M
        self._refused |= there
        of_it = [there[rows, columns].any() for (_, rows, columns), _ in self._boxed]
        for (at, chance), judged in zip(self._boxed, of_it, strict=True):
            if judged:
                self._in_vain(at, chance)
        self._boxed = [one for one, judged in zip(self._boxed, of_it, strict=True) if not judged]

    def expect(self, x: float, y: float) -> None:
        """It was seen there, judged, and lost from sight: no look in vain from one side outweighs that."""
        self._expected |= self._apart_m(x, y) <= REFUSED_M

    def cell(self, pose: Pose2D) -> tuple[int, int] | None:
        fine = self.grid.cell(pose.x, pose.y)
        return (fine[0] // self.coarse.factor, fine[1] // self.coarse.factor) if fine is not None else None

    def point(self, row: int, column: int) -> tuple[float, float]:
        """(x, y) in map of a cell's middle."""
        x, y = self.grid.points((column + 0.5) * self.coarse.factor, (row + 0.5) * self.coarse.factor)
        return float(x), float(y)

    def most_likely(self) -> tuple[float, float]:
        row, column = np.unravel_index(int(np.argmax(self.cells)), self._prior.shape)
        return self.point(int(row), int(column))

    def _in_vain(self, at: _Shown, chance: Cells) -> None:
        for known in (self.doubt, self.looked):
            known[at] = np.maximum(known[at], chance)

    def _left(self) -> Cells:
        times = np.ones_like(self._prior)
        for (_, rows, columns), _ in self._boxed:
            times[rows, columns] = SEEN_TIMES
        times[self._expected] = CONFIRMED_TIMES
        times[self._refused] = REFUSED_LEFT
        return self._prior * times * np.prod(1.0 - self.doubt, axis=0)

    def _apart_m(self, x: float, y: float) -> Cells:
        rows, columns = np.indices(self.coarse.free.shape)
        at_x, at_y = self.grid.points((columns + 0.5) * self.coarse.factor, (rows + 0.5) * self.coarse.factor)
        return np.hypot(at_x - x, at_y - y)

    @property
    def looked_from(self) -> NDArray[np.bool_]:
        """(rows, columns): whence it is to be looked for, as far as the robot fits there."""
        if self._within is None:
            return np.ones(self.coarse.free.shape, dtype=bool)
        return blocks_of(self._within, self.coarse.factor)

    def _believed_before(self) -> Cells:
        """What memory is sure of stands where it stood; the rest is spread over where a thing can stand."""
        coarse = self.coarse
        edge = maximum_filter(coarse.blocked, 3) & maximum_filter(coarse.free, 3)
        spread = np.where(edge, AT_AN_EDGE, 0.0) + np.where(coarse.free & ~edge, 1.0, 0.0)
        if self._within is not None:
            spread *= blocks_of(self._within, coarse.factor)
        spread *= self._in_sight()
        rows, columns = np.nonzero(coarse.free & maximum_filter(self._unknown(), 3))
        spread[rows, columns] *= BEYOND
        own = np.zeros_like(spread)
        nowhere = 1.0
        for clue in self.clues:
            apart_m = self._apart_m(clue.x, clue.y)
            if not clue.itself:
                spread *= 1.0 + (clue.weight - 1.0) * np.exp(-0.5 * (apart_m / clue.sigma_m) ** 2)
                continue
            nearest_m = float(apart_m[spread > 0].min(initial=math.inf))
            if nearest_m <= OFF_THE_FLOOR_M:  # on this map
                near = np.exp(-0.5 * ((apart_m - nearest_m) / clue.sigma_m) ** 2) * (spread > 0)
                own += clue.weight * near / near.sum()
                nowhere *= 1.0 - clue.weight
        known, total = 1.0 - nowhere, float(spread.sum())
        rest = (1.0 - known) * HERE
        self._absent = 1.0 - known - rest if total else 1.0
        if own.any():
            own *= known / own.sum()
        return own + (spread * (rest / total) if total else spread)

    def _in_sight(self) -> NDArray[np.bool_]:
        """Cells that are seen from some place to stand. In no other could it have been seen or will it be: a gap inside
        a cabinet would keep for ever what memory puts beside it, and the search would end unsure of all else.
        """
        places = candidate_cells(self.grid, self.coarse, (), 0.0)
        meant = self.looked_from[tuple(places.T)]
        places = places[meant] if meant.any() else places
        if not len(places):
            return np.ones(self.coarse.free.shape, dtype=bool)
        padded = np.pad(np.zeros(self.coarse.free.shape, dtype=bool), self.reach)
        for first in range(0, len(places), PLACES_AT_ONCE):
            some = places[first : first + PLACES_AT_ONCE]
            index = VisibilityIndex(self.coarse.blocked, some, self.reach, rays=RAYS, edges=True)
            padded.ravel()[index.cells[index.seen]] = True
        return padded[self.reach : -self.reach, self.reach : -self.reach]

    def _unknown(self) -> NDArray[np.bool_]:
        factor = self.coarse.factor
        rows, columns = (-(-n // factor) for n in self.grid.cells.shape)
        padded = np.ones((rows * factor, columns * factor), dtype=bool)
        padded[: self.grid.cells.shape[0], : self.grid.cells.shape[1]] = self.grid.unknown
        return padded.reshape(rows, factor, columns, factor).mean(axis=(1, 3)) > 0.5


def sides_of(rows: NDArray[np.intp], columns: NDArray[np.intp]) -> NDArray[np.intp]:
    """From which of the sides a cell so far away is looked at."""
    turn = np.arctan2(rows, columns) / (2 * np.pi) * SIDES
    return np.floor(turn + 0.5).astype(np.intp) % SIDES


def box_bearings(x_min_px: float, x_max_px: float, width_px: int, hfov_rad: float) -> tuple[float, float]:
    """(right, left) edge of a box from the camera's axis, counter-clockwise positive."""
    focal_px = width_px / 2 / math.tan(hfov_rad / 2)
    right, left = (math.atan2(width_px / 2 - u, focal_px) for u in (x_max_px, x_min_px))
    return wrap(right), wrap(left)
