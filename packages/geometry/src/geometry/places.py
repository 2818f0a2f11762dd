"""Are two maps of one place? Told by what stands in them, not by how they are written down.

A map is sketched on squares of 0.1 m of the map frame, so that its resolution, the corner it begins at and the way its
rows run make no difference. Where both maps know something, walls of one are looked for within one square of walls of
the other, both ways; the agreement is the lesser share found, with what chance would find taken out (as Cohen's kappa
does). Measured by `python -m bench.map_likeness` over 40 simulated homes that all begin at one corner: of 780 pairs of
different homes the most alike agree by 0.54; a home with things moved, a twentieth of its cells wrong, its frame 0.1 m
off, or three quarters of it not yet seen agrees with itself by 0.85 at least.
"""

import hashlib
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from contracts.geometry import Pose2D
from geometry.grids import OCCUPIED, UNKNOWN, Mask, OccupancyGrid

SQUARE_M = 0.1
AGREEMENT_MIN = 0.7
SHARED_MIN = 0.3
"""Of the smaller map's known squares; with less in common nothing can be told."""
WALLS_MIN = 40
"""Squares of wall that both know; with fewer, two maps are of one place only where they know the same squares."""
ALIKE_MIN = 0.9
GROWN_BY = 1.05


class Verdict(StrEnum):
    """What a second map is to a first."""

    SAME = "same"
    """Of the same place, in the same frame."""
    GROWN = "grown"
    """The same, and it knows more."""
    OTHER = "other"
    """Of another place, or of the same one in another frame: coordinates of the first mean nothing in it."""


@dataclass(frozen=True, slots=True)
class Likeness:
    """`agreement`: of the walls, 1 as good as can be, 0 as by chance. `shared`: of the smaller map, known to both."""

    verdict: Verdict
    agreement: float
    shared: float

    @property
    def is_one_place(self) -> bool:
        return self.verdict is not Verdict.OTHER


def sketch_of(grid: OccupancyGrid) -> OccupancyGrid:
    """The known part of a map on squares of the map frame, its rows along the frame's axes: what `same_place` compares.

    A square with an occupied cell is occupied, else free where any cell of it is.
    """
    rows, columns = np.nonzero(grid.free | grid.occupied)
    if not rows.size:
        return OccupancyGrid(np.full((1, 1), UNKNOWN, np.int8), SQUARE_M, Pose2D(x=0.0, y=0.0, yaw=0.0))
    x, y = grid.points(columns + 0.5, rows + 0.5)
    i, j = (np.floor(each / SQUARE_M + 1e-6).astype(np.intp) for each in (x, y))
    left, low = int(i.min()), int(j.min())
    cells = np.full((int(j.max()) - low + 1, int(i.max()) - left + 1), UNKNOWN, np.int8)
    cells[j - low, i - left] = 0
    wall = grid.occupied[rows, columns]
    cells[j[wall] - low, i[wall] - left] = OCCUPIED
    return OccupancyGrid(cells, SQUARE_M, Pose2D(x=left * SQUARE_M, y=low * SQUARE_M, yaw=0.0))


def content_id(sketch: OccupancyGrid) -> str:
    """12 letters that stand for what a sketch shows: the same for a map that was saved, cut or packed anew."""
    corner = (round(sketch.origin.x / SQUARE_M), round(sketch.origin.y / SQUARE_M), *sketch.cells.shape)
    return hashlib.sha256(repr(corner).encode() + sketch.cells.tobytes()).hexdigest()[:12]


def same_place(a: OccupancyGrid, b: OccupancyGrid) -> Likeness:
    """What the map of sketch `b` is to that of sketch `a`."""
    size_a, size_b = (int(np.count_nonzero(~one.unknown)) for one in (a, b))
    box = _Box.shared_by(a, b)
    known_a, known_b = box.cut(a, ~a.unknown), box.cut(b, ~b.unknown)
    walls_a, walls_b = box.cut(a, _standing(a)), box.cut(b, _standing(b))
    both = known_a & known_b
    common = int(np.count_nonzero(both))
    shared = common / max(1, min(size_a, size_b))
    verdict = Verdict.GROWN if size_b > GROWN_BY * size_a else Verdict.SAME
    seen_a, seen_b = walls_a & _near(known_b), walls_b & _near(known_a)
    if min(np.count_nonzero(seen_a), np.count_nonzero(seen_b)) < WALLS_MIN:
        alike = common / max(1, size_a + size_b - common)
        return Likeness(Verdict.SAME if alike >= ALIKE_MIN else Verdict.OTHER, alike, shared)
    agreement = min(_beyond_chance(seen_a, _near(walls_b), both), _beyond_chance(seen_b, _near(walls_a), both))
    is_one = shared >= SHARED_MIN and agreement >= AGREEMENT_MIN
    return Likeness(verdict if is_one else Verdict.OTHER, agreement, shared)


@dataclass(frozen=True, slots=True)
class _Box:
    """Squares of the map frame: from `left` and `low`, `width` x `height` of them."""

    left: int
    low: int
    width: int
    height: int

    @classmethod
    def of(cls, sketch: OccupancyGrid) -> "_Box":
        height, width = sketch.cells.shape
        return cls(round(sketch.origin.x / SQUARE_M), round(sketch.origin.y / SQUARE_M), width, height)

    @classmethod
    def shared_by(cls, a: OccupancyGrid, b: OccupancyGrid) -> "_Box":
        """What lies in both, and a square round it: walls are looked for that near."""
        one, other = cls.of(a), cls.of(b)
        left, low = max(one.left, other.left) - 1, max(one.low, other.low) - 1
        right = min(one.left + one.width, other.left + other.width) + 1
        high = min(one.low + one.height, other.low + other.height) + 1
        return cls(left, low, max(0, right - left), max(0, high - low))

    def cut(self, sketch: OccupancyGrid, mask: Mask) -> Mask:
        """(height, width): what the sketch's `mask` says in this box; false beyond the sketch."""
        own = _Box.of(sketch)
        out = np.zeros((self.height, self.width), bool)
        r, c = own.low - self.low, own.left - self.left
        part = mask[max(0, -r) : max(0, self.height - r), max(0, -c) : max(0, self.width - c)]
        out[max(0, r) : max(0, r) + part.shape[0], max(0, c) : max(0, c) + part.shape[1]] = part
        return out


def _beyond_chance(walls: Mask, near: Mask, both: Mask) -> float:
    """The share of `walls` that is `near` the other's, less what a square put down anywhere would have."""
    found, chance = float(near[walls].mean()), float(near[both].mean()) if both.any() else 1.0
    return (found - chance) / max(1e-9, 1.0 - chance)


def _standing(sketch: OccupancyGrid) -> Mask:
    """Occupied squares beside another: a lone one is as likely a speck as a table's leg."""
    wall = np.pad(sketch.occupied, 1).astype(np.int8)
    rows = wall[:-2] + wall[1:-1] + wall[2:]
    return sketch.occupied & (rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:] > 1)


def _near(mask: Mask) -> Mask:
    """Within a square of it, corners too."""
    rows = mask.copy()
    rows[1:] |= mask[:-1]
    rows[:-1] |= mask[1:]
    out = rows.copy()
    out[:, 1:] |= rows[:, :-1]
    out[:, :-1] |= rows[:, 1:]
    return out
