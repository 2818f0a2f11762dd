"""Furniture into rooms: against walls with their fronts free, tables with their chairs, all rooms still connected."""

import math
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from sim.home.catalog import FURNITURE
from sim.home.floor import CELL_M, Floor
from sim.home.layout import Layout, Rect
from sim.home.model import Furniture, Room

_FRONT_FREE_M = 0.80
_WALL_GAP_M = 0.03
_GAP_M = 0.03
"""Least distance between two pieces of furniture that are no group."""
_PLANS: Final[dict[str, tuple[str, ...]]] = {
    "living room": ("couch", "tv cabinet", "coffee table", "shelf", "couch", "chair"),
    "kitchen": ("refrigerator", "counter", "oven", "dining set", "cabinet"),
    "bedroom": ("bed", "cabinet", "shelf", "bench", "chair"),
    "study": ("desk set", "shelf", "coffee table", "couch", "cabinet"),
    "hallway": ("bench", "cabinet", "shelf", "coffee table"),
    "bathroom": ("toilet", "sink", "cabinet", "shelf"),
}


@dataclass
class Furnishing:
    """Furniture placed so far, its floor, and the cells that other furniture must leave free."""

    layout: Layout
    rng: np.random.Generator
    floor: Floor
    must: tuple[tuple[str, str | None], ...] = ()
    pieces: list[Furniture] = field(default_factory=list[Furniture])
    tv_cabinet: str | None = None

    def __post_init__(self) -> None:
        self.walls = self.floor.occupied.copy()
        self.reserved = np.zeros_like(self.floor.occupied)
        for zone in self.layout.keep_free:
            self.reserved |= self.floor.footprint(
                (zone.x_min_m + zone.x_max_m) / 2,
                (zone.y_min_m + zone.y_max_m) / 2,
                0.0,
                zone.x_max_m - zone.x_min_m,
                zone.y_max_m - zone.y_min_m,
            )

    def next_id(self, kind: str) -> str:
        """A fresh id such as "coffee_table_2"."""
        return f"{kind.replace(' ', '_')}_{sum(p.kind == kind for p in self.pieces) + 1}"


def furnish(
    layout: Layout, rng: np.random.Generator, floor: Floor, must: tuple[tuple[str, str | None], ...]
) -> Furnishing:
    """Fill every room after its plan, leaving out what finds no place; `must` = (kind, colour) come first, once."""
    state = Furnishing(layout, rng, floor, must)
    for kind, colour in must:
        for k in rng.permutation(len(layout.rooms)):
            if _add(state, layout.rooms[int(k)], kind, colour):
                break
    for room in layout.rooms:
        for what in (w for w in _PLANS[room.name] if (w, None) not in must):
            _add(state, room, what, None)
    return state


def _add(state: Furnishing, room: Room, what: str, colour: str | None) -> bool:
    match what:
        case "dining set":
            return _add_table(state, room, int(state.rng.integers(2, 5)))
        case "desk set":
            return _add_table(state, room, 1)
        case "dining table":
            return _add_table(state, room, 2)
        case "tv cabinet":
            placed = _against_wall(state, room, _piece(state, "cabinet", None, width_m=1.25))
            state.tv_cabinet = state.pieces[-1].id if placed else state.tv_cabinet
            return placed
        case "coffee table":
            piece = _piece(state, what, colour)
            return _in_the_open(state, room, [piece]) or _against_wall(state, room, piece)
        case _:
            return _against_wall(state, room, _piece(state, what, colour))


def _piece(state: Furnishing, kind: str, colour: str | None, width_m: float | None = None) -> Furniture:
    """A piece of varied size at the origin."""
    rng, entry = state.rng, FURNITURE[kind]
    w, d, h = entry.size_m
    w = width_m or w * rng.uniform(0.92, 1.08)
    if kind in ("coffee table", "cabinet"):
        h = rng.uniform(0.20, 0.30)
    if colour is None and entry.colours:
        colour = str(rng.choice([c for c in entry.colours if (kind, c) not in state.must]))
    size = (round(float(w), 3), round(d, 3), round(float(h), 3))
    return Furniture(state.next_id(kind), kind, colour, 0.0, 0.0, 0.0, size, int(rng.integers(entry.variants)))


def _against_wall(state: Furnishing, room: Room, piece: Furniture) -> bool:
    w, d, _ = piece.size_m
    gap = d / 2 + _WALL_GAP_M
    for _ in range(24):
        side = int(state.rng.integers(4))
        span_x, span_y = (room.x_max_m - room.x_min_m - w, room.y_max_m - room.y_min_m - w)
        if (span_x if side % 2 == 0 else span_y) < 0.1:
            continue
        share = state.rng.choice([state.rng.uniform(0, 1), 0.0, 1.0], p=[0.5, 0.25, 0.25])
        x = room.x_min_m + w / 2 + 0.02 + share * (span_x - 0.04)
        y = room.y_min_m + w / 2 + 0.02 + share * (span_y - 0.04)
        x = (x, room.x_max_m - gap, x, room.x_min_m + gap)[side]
        y = (room.y_min_m + gap, y, room.y_max_m - gap, y)[side]
        turned = replace(piece, x_m=round(float(x), 3), y_m=round(float(y), 3), yaw=_quarter(side))
        if _try(state, [turned], 0.0):
            return True
    return False


def _in_the_open(state: Furnishing, room: Room, group: list[Furniture]) -> bool:
    """Somewhere inside the room with a passage all around."""
    for _ in range(24):
        x = state.rng.uniform(room.x_min_m + 0.9, max(room.x_min_m + 0.91, room.x_max_m - 0.9))
        y = state.rng.uniform(room.y_min_m + 0.9, max(room.y_min_m + 0.91, room.y_max_m - 0.9))
        yaw = _quarter(int(state.rng.integers(4)))
        c, s = math.cos(yaw), math.sin(yaw)
        moved = [
            replace(
                p,
                x_m=round(float(x + c * p.x_m - s * p.y_m), 3),
                y_m=round(float(y + s * p.x_m + c * p.y_m), 3),
                yaw=math.remainder(p.yaw + yaw, 2 * math.pi),
            )
            for p in group
        ]
        if _try(state, moved, 0.75):
            return True
    return False


def _add_table(state: Furnishing, room: Room, chairs: int) -> bool:
    table = _piece(state, "dining table", None)
    w, d, _ = table.size_m
    seats = [(-w * 0.24, 1), (w * 0.24, -1), (w * 0.24, 1), (-w * 0.24, -1)] if chairs > 1 else [(0.0, 1)]
    first = _piece(state, "chair", None)
    group = [table]
    number = sum(p.kind == "chair" for p in state.pieces)
    for k, (x, side) in enumerate(seats[:chairs]):
        y = side * (d / 2 + 0.13)
        seat = replace(first, id=f"chair_{number + k + 1}", x_m=x, y_m=y, yaw=math.pi if side > 0 else 0.0)
        group.append(seat)
    return _in_the_open(state, room, group) or (chairs > 1 and _add_table(state, room, chairs - 1))


def _try(state: Furnishing, group: list[Furniture], around_m: float) -> bool:
    """Add the pieces if they overlap nothing, keep their surroundings free and leave every room reachable."""
    floor = state.floor
    shapes = [floor.footprint(p.x_m, p.y_m, p.yaw, p.size_m[0], p.size_m[1]) for p in group]
    whole = np.logical_or.reduce(shapes)
    inner = [floor.footprint(p.x_m, p.y_m, p.yaw, p.size_m[0], p.size_m[1], grow_m=-1.5 * CELL_M) for p in group]
    if (np.logical_or.reduce(inner) & state.walls).any() or (whole & state.reserved).any():
        return False
    if any(_rect(p, _GAP_M).overlaps(_rect(other, 0.0)) for p in group for other in state.pieces):
        return False
    if around_m:
        spread = [floor.footprint(p.x_m, p.y_m, p.yaw, p.size_m[0], p.size_m[1], grow_m=around_m) for p in group]
        zone = np.logical_or.reduce(spread) & ~whole
    else:
        p = group[0]
        reach = (p.size_m[1] + _FRONT_FREE_M) / 2
        front_x, front_y = p.x_m - math.sin(p.yaw) * reach, p.y_m + math.cos(p.yaw) * reach
        zone = floor.footprint(front_x, front_y, p.yaw, p.size_m[0] - 0.1, _FRONT_FREE_M - 0.1)
    if (zone & floor.occupied).any():
        return False
    occupied = floor.occupied | whole
    if floor.standing(occupied) is None:
        return False
    floor.occupied = occupied
    state.reserved |= zone
    state.pieces += group
    return True


def _rect(piece: Furniture, grow_m: float) -> Rect:
    """The footprint of a piece, which stands at right angles to the walls, grown on all sides."""
    w, d, _ = piece.size_m
    turned = abs(math.sin(piece.yaw)) > 0.5
    half_x, half_y = (d / 2, w / 2) if turned else (w / 2, d / 2)
    return Rect(
        piece.x_m - half_x - grow_m,
        piece.y_m - half_y - grow_m,
        piece.x_m + half_x + grow_m,
        piece.y_m + half_y + grow_m,
    )


def _quarter(side: int) -> float:
    """Yaw of a piece whose back is to the low-y, high-x, high-y or low-x wall."""
    return (0.0, math.pi / 2, math.pi, -math.pi / 2)[side]
