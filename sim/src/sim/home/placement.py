"""Things onto floors, tables, boards and walls, each where a robot can drive up to it and see it."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from sim.home.catalog import THINGS, Kind, Place
from sim.home.floor import Floor, Mask
from sim.home.furnish import Furnishing
from sim.home.furniture import Surface, surfaces
from sim.home.model import Furniture, Thing

Wish = tuple[str, str | None]
_SOFT = ("couch", "bed")
_FITS_SOFT = ("teddy bear", "handbag", "book")
_TRIES = 40
_PART_OF_MOST = 0.65
_HANG_M = (0.36, 0.44)
"""Height of the lower rim of a wall clock: low enough for a low camera that stands before it."""


@dataclass
class Placement:
    """Things placed so far and the standing places they must be seen from."""

    furnishing: Furnishing
    rng: np.random.Generator
    things: list[Thing] = field(default_factory=list[Thing])

    def __post_init__(self) -> None:
        self.floor: Floor = self.furnishing.floor
        standing = self.floor.standing()
        assert standing is not None, "furnish keeps every doorway reachable"
        self.standing: Mask = standing
        self.bare = self.floor.clearance_m()
        self.forbidden = np.zeros_like(self.floor.occupied)
        for zone in self.furnishing.layout.keep_free:
            x, y = (zone.x_min_m + zone.x_max_m) / 2, (zone.y_min_m + zone.y_max_m) / 2
            self.forbidden |= self.floor.footprint(x, y, 0.0, zone.x_max_m - zone.x_min_m, zone.y_max_m - zone.y_min_m)


def place_things(furnishing: Furnishing, rng: np.random.Generator, must: tuple[Wish, ...]) -> list[Thing]:
    """The wished things first, then a mix of every kind, no two alike in kind and colour."""
    state = Placement(furnishing, rng)
    _place_tv(state)
    for wish in must:
        _place(state, *wish)
    for kind, colour in _draw(rng, must):
        _place(state, kind, colour)
    return state.things


def _draw(rng: np.random.Generator, must: tuple[Wish, ...]) -> list[Wish]:
    """How many of each kind, and in which colours, beyond those in `must`."""
    wishes: list[Wish] = []
    for entry in THINGS.values():
        taken = [colour for kind, colour in must if kind == entry.label]
        fewest, most = entry.per_home
        count = fewest + int(rng.binomial(most - fewest, _PART_OF_MOST))
        if taken and not entry.colours:
            continue  # a wanted kind that has no colours must not be there twice
        colours = [str(c) for c in rng.permutation(entry.colours)] if entry.colours else [None] * count
        fresh = list(dict.fromkeys(c for c in colours if c not in taken)) if entry.colours else colours
        wishes += [(entry.label, c) for c in fresh[: max(0, count - len(taken))]]
    return [wishes[int(k)] for k in rng.permutation(len(wishes))]


def _place(state: Placement, kind: str, colour: str | None) -> bool:
    entry = THINGS[kind]
    scale = state.rng.uniform(0.93, 1.08)
    w, d, h = (round(float(side * scale), 3) for side in entry.size_m)
    if kind == "book":
        w, d, h = _book_size(int(state.rng.integers(entry.variants)), w, d, h)
    thing = Thing(
        f"{kind.replace(' ', '_')}_{sum(t.kind == kind for t in state.things) + 1}",
        kind, colour, 0.0, 0.0, 0.0, 0.0, (w, d, h), "floor",
        _book_variant(d, h) if kind == "book" else int(state.rng.integers(entry.variants)),
    )  # fmt: skip
    places = [entry.places[int(k)] for k in state.rng.permutation(len(entry.places))]
    return any(place_at(state, entry, thing, place) for place in dict.fromkeys(places))


def _book_size(variant: int, w: float, d: float, h: float) -> tuple[float, float, float]:
    """Closed upright, half open upright, or three lying on each other."""
    return ((w, 0.05, h), (w * 1.2, d, h), (w * 1.2, d * 1.1, 0.12))[variant]


def _book_variant(d: float, h: float) -> int:
    return 0 if d <= 0.05 else 1 if h > 0.15 else 2


def place_at(state: Placement, entry: Kind, thing: Thing, place: Place) -> bool:
    """Puts it somewhere of that sort; false where it finds no place."""
    match place:
        case Place.FLOOR:
            return _on_floor(state, thing)
        case Place.WALL:
            return _on_wall(state, thing)
        case Place.LOW | Place.BOARD | Place.HIGH:
            return _on_furniture(state, entry, thing, place)


def _on_floor(state: Placement, thing: Thing) -> bool:
    """Beside a wall or a piece of furniture, turned towards where it is seen from."""
    radius = max(thing.size_m[:2]) / 2
    good = (state.bare >= radius + 0.03) & (state.bare <= radius + 0.16) & ~state.forbidden & ~state.floor.occupied
    rows, columns = np.nonzero(good)
    if len(rows) == 0:
        return False
    for k in state.rng.integers(len(rows), size=_TRIES):
        x, y = float(state.floor.x_m[0, columns[k]]), float(state.floor.y_m[rows[k], 0])
        near = [math.hypot(t.x_m - x, t.y_m - y) - max(t.size_m[:2]) / 2 for t in state.things if t.support == "floor"]
        if near and min(near) < radius + 0.22:
            continue
        shape = state.floor.footprint(x, y, 0.0, 2 * radius, 2 * radius)
        view = state.floor.viewpoint(state.standing, x, y, shape)
        if view is None:
            continue
        occupied = state.floor.occupied | shape
        standing = state.floor.standing(occupied)
        if standing is None or not _still_seen(state, standing, occupied):
            continue
        placed = replace(thing, x_m=round(x, 3), y_m=round(y, 3), yaw=_facing(state, x, y, view, 0.6))
        if _viewpoint(state, placed, standing, occupied) is None:
            continue
        state.floor.occupied, state.standing = occupied, standing
        state.things.append(placed)
        return True
    return False


def _on_wall(state: Placement, thing: Thing) -> bool:
    room = state.furnishing.layout.rooms[int(state.rng.integers(len(state.furnishing.layout.rooms)))]
    half, deep = thing.size_m[0] / 2 + 0.1, thing.size_m[1] / 2 + 0.005
    for _ in range(_TRIES):
        side = int(state.rng.integers(4))
        x = state.rng.uniform(room.x_min_m + half, room.x_max_m - half)
        y = state.rng.uniform(room.y_min_m + half, room.y_max_m - half)
        x = (x, room.x_max_m - deep, x, room.x_min_m + deep)[side]
        y = (room.y_min_m + deep, y, room.y_max_m - deep, y)[side]
        yaw = (0.0, math.pi / 2, math.pi, -math.pi / 2)[side]
        back_x, back_y = x + math.sin(yaw) * 0.05, y - math.cos(yaw) * 0.05
        behind = state.floor.footprint(back_x, back_y, yaw, thing.size_m[0], 0.01)
        if state.forbidden[state.floor.cell(x, y)] or not state.floor.occupied[behind].all():
            continue
        z = round(float(state.rng.uniform(*_HANG_M)), 3)
        placed = replace(thing, x_m=round(x, 3), y_m=round(y, 3), z_m=z, yaw=yaw, support="wall")
        if _viewpoint(state, placed, state.standing, state.floor.occupied) is None:
            continue
        state.things.append(placed)
        return True
    return False


def _on_furniture(state: Placement, entry: Kind, thing: Thing, place: Place) -> bool:
    spots = [
        (piece, surface)
        for piece in state.furnishing.pieces
        for surface in surfaces(piece.kind, piece.size_m)
        if surface.place is place
        and piece.id != state.furnishing.tv_cabinet
        and surface.headroom_m > thing.size_m[2]
        and (piece.kind not in _SOFT or thing.kind in _FITS_SOFT)
    ]
    if not spots:
        return False
    radius = max(thing.size_m[:2]) / 2
    for k in state.rng.integers(len(spots), size=_TRIES):
        piece, surface = spots[int(k)]
        placed = _put_on(state, thing, piece, surface)
        crowd = [t for t in state.things if t.support == piece.id and abs(t.z_m - placed.z_m) < 0.1]
        gaps = [math.hypot(t.x_m - placed.x_m, t.y_m - placed.y_m) - max(t.size_m[:2]) / 2 for t in crowd]
        if gaps and min(gaps) < radius + 0.06:
            continue
        if entry.findable and _viewpoint(state, placed, state.standing, state.floor.occupied) is None:
            continue
        state.things.append(placed)
        return True
    return False


def _put_on(state: Placement, thing: Thing, piece: Furniture, surface: Surface) -> Thing:
    rng = state.rng
    shrink_x = max(0.0, surface.half_x_m - max(0.0, thing.size_m[0] / 2 - 0.06))
    shrink_y = max(0.0, surface.half_y_m - max(0.0, thing.size_m[1] / 2 - 0.06))
    if surface.place is Place.BOARD:
        shrink_y = 0.0
    dx, dy = surface.x_m + rng.uniform(-shrink_x, shrink_x), surface.y_m + rng.uniform(-shrink_y, shrink_y)
    c, s = math.cos(piece.yaw), math.sin(piece.yaw)
    x, y = piece.x_m + c * dx - s * dy, piece.y_m + s * dx + c * dy
    spread = 0.15 if surface.place in (Place.HIGH, Place.BOARD) else 0.6
    yaw = piece.yaw + rng.uniform(-spread, spread)
    if piece.kind == "coffee table":
        yaw += float(rng.integers(2)) * math.pi
    return replace(
        thing,
        x_m=round(float(x), 3),
        y_m=round(float(y), 3),
        z_m=round(surface.z_m, 4),
        yaw=round(math.remainder(yaw, 2 * math.pi), 3),
        support=piece.id,
    )


def _place_tv(state: Placement) -> None:
    for piece in state.furnishing.pieces:
        if piece.id == state.furnishing.tv_cabinet:
            kind = THINGS["tv"]
            x = piece.x_m + math.sin(piece.yaw) * 0.05
            y = piece.y_m - math.cos(piece.yaw) * 0.05
            tv = Thing("tv_1", "tv", None, round(x, 3), round(y, 3), piece.size_m[2], piece.yaw, kind.size_m, piece.id)
            state.things.append(tv)


def _viewpoint(state: Placement, thing: Thing, standing: Mask, occupied: Mask) -> tuple[float, float] | None:
    """From where the thing can be approached and seen."""
    side = max(thing.size_m[:2])
    through = state.floor.footprint(thing.x_m, thing.y_m, 0.0, side, side)
    front = None
    if thing.support == "wall":
        through |= state.floor.footprint(thing.x_m, thing.y_m, 0.0, 0.2, 0.2)
        front = thing.yaw + math.pi / 2
    for piece in state.furnishing.pieces:
        if piece.id == thing.support:
            through |= state.floor.footprint(
                piece.x_m, piece.y_m, piece.yaw, piece.size_m[0], piece.size_m[1], grow_m=0.03
            )
            front = piece.yaw + math.pi / 2 if piece.kind != "coffee table" else None
    return state.floor.viewpoint(standing, thing.x_m, thing.y_m, through, front_yaw=front, occupied=occupied)


def _still_seen(state: Placement, standing: Mask, occupied: Mask) -> bool:
    """Whether every findable thing placed before can still be approached."""
    placed = (t for t in state.things if THINGS[t.kind].findable)
    return all(_viewpoint(state, t, standing, occupied) is not None for t in placed)


def _facing(state: Placement, x: float, y: float, view: tuple[float, float], spread: float) -> float:
    """Yaw that turns a thing's front (+y) to the viewer, give or take."""
    yaw = math.atan2(view[1] - y, view[0] - x) - math.pi / 2 + state.rng.uniform(-spread, spread)
    return round(math.remainder(yaw, 2 * math.pi), 3)
