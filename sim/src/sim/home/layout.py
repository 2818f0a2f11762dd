"""The plan of a home: four to six rooms in two rows, doorways that connect them all, and a place for the dock."""

import math
from dataclasses import dataclass

import numpy as np

from sim.home.model import Dock, Door, Room, Wall

WALL_M = 0.10
HEIGHT_M = 2.50
DOOR_HEIGHT_M = 2.05
DOCK_GAP_M = 0.30
"""Distance from the docked robot's centre to the wall behind the dock."""
DOCK_FREE_M = (0.90, 1.50)
"""Width and length of the floor kept free in front of the dock, from the wall."""
_DOOR_MARGIN_M = 0.35
_NAMES = ("living room", "kitchen", "bedroom", "study", "hallway", "bathroom")


@dataclass(frozen=True)
class Rect:
    """An axis-aligned rectangle in m."""

    x_min_m: float
    y_min_m: float
    x_max_m: float
    y_max_m: float

    def overlaps(self, other: "Rect") -> bool:
        """Whether the two share an area."""
        return (
            self.x_min_m < other.x_max_m
            and other.x_min_m < self.x_max_m
            and self.y_min_m < other.y_max_m
            and other.y_min_m < self.y_max_m
        )


@dataclass(frozen=True)
class Layout:
    """The empty home."""

    width_m: float
    depth_m: float
    rooms: tuple[Room, ...]
    walls: tuple[Wall, ...]
    doors: tuple[Door, ...]
    dock: Dock

    @property
    def keep_free(self) -> tuple[Rect, ...]:
        """Floor that nothing may stand on: both sides of every doorway, and before the dock."""
        return (*(door_zone(door) for door in self.doors), dock_zone(self.dock))


@dataclass(frozen=True)
class _Shared:
    """A stretch of wall that two rooms share: where a doorway could be."""

    first: int
    second: int
    upright: bool
    at_m: float
    low_m: float
    high_m: float


def plan(rng: np.random.Generator) -> Layout:
    """A random plan; every room can be reached from every other."""
    width, depth = rng.uniform(9.0, 10.8), rng.uniform(7.2, 8.8)
    counts = ((2, 2), (2, 3), (3, 2), (3, 3))[int(rng.integers(4))]
    split = depth * rng.uniform(0.46, 0.54)
    cuts = [_cuts(rng, width, count) for count in counts]
    rooms = _rooms(cuts, split, width, depth)
    doors = _doors(rng, rooms, _shared_walls(cuts, split, depth))
    walls = _walls(cuts, split, width, depth, doors)
    dock = _dock(rng, rooms, doors)
    return Layout(width, depth, tuple(rooms), tuple(walls), tuple(doors), dock)


def door_zone(door: Door) -> Rect:
    """The floor on both sides of a doorway that stays free."""
    along, across = door.width_m / 2 + 0.05, 0.75
    half_x, half_y = (across, along) if door.normal_x else (along, across)
    return Rect(door.x_m - half_x, door.y_m - half_y, door.x_m + half_x, door.y_m + half_y)


def dock_zone(dock: Dock) -> Rect:
    """The floor in front of the dock that stays free."""
    out_x, out_y = -math.cos(dock.yaw), -math.sin(dock.yaw)
    wall_x, wall_y = dock.x_m - out_x * DOCK_GAP_M, dock.y_m - out_y * DOCK_GAP_M
    far_x, far_y = wall_x + out_x * DOCK_FREE_M[1], wall_y + out_y * DOCK_FREE_M[1]
    side = DOCK_FREE_M[0] / 2
    half_x, half_y = (side, 0.0) if abs(out_y) > 0.5 else (0.0, side)
    return Rect(
        min(wall_x, far_x) - half_x,
        min(wall_y, far_y) - half_y,
        max(wall_x, far_x) + half_x,
        max(wall_y, far_y) + half_y,
    )


def _cuts(rng: np.random.Generator, width: float, count: int) -> list[float]:
    shares = rng.uniform(0.8, 1.25, count)
    return [0.0, *np.round(np.cumsum(shares / shares.sum())[:-1] * width, 2).tolist(), width]


def _rooms(cuts: list[list[float]], split: float, width: float, depth: float) -> list[Room]:
    boxes: list[Rect] = []
    for row, (low, high) in enumerate(((0.0, split), (split, depth))):
        for left, right in zip(cuts[row], cuts[row][1:], strict=False):
            h = WALL_M / 2
            boxes.append(Rect(left + h, low + h, right - h, high - h))
    order = sorted(range(len(boxes)), key=lambda k: -_area(boxes[k]))
    chosen = (*_NAMES[: len(boxes) - 1], "bathroom")
    names = {k: name for k, name in zip(order, chosen, strict=True)}
    return [Room(names[k], b.x_min_m, b.y_min_m, b.x_max_m, b.y_max_m) for k, b in enumerate(boxes)]


def _area(rect: Rect) -> float:
    return (rect.x_max_m - rect.x_min_m) * (rect.y_max_m - rect.y_min_m)


def _shared_walls(cuts: list[list[float]], split: float, depth: float) -> list[_Shared]:
    bottom, top = len(cuts[0]) - 1, len(cuts[1]) - 1
    shared = [_Shared(k, k + 1, True, cuts[0][k + 1], 0.0, split) for k in range(bottom - 1)]
    shared += [_Shared(bottom + k, bottom + k + 1, True, cuts[1][k + 1], split, depth) for k in range(top - 1)]
    for i in range(bottom):
        for k in range(top):
            low, high = max(cuts[0][i], cuts[1][k]), min(cuts[0][i + 1], cuts[1][k + 1])
            shared.append(_Shared(i, bottom + k, False, split, low, high))
    return [s for s in shared if s.high_m - s.low_m >= 1.9]


def _doors(rng: np.random.Generator, rooms: list[Room], shared: list[_Shared]) -> list[Door]:
    """A random spanning tree of doorways and up to two more, so that there are loops."""
    group = list(range(len(rooms)))
    tree: list[_Shared] = []
    others: list[_Shared] = []
    for k in rng.permutation(len(shared)):
        s = shared[int(k)]
        if group[s.first] == group[s.second]:
            others.append(s)
            continue
        old, new = group[s.second], group[s.first]
        group = [new if g == old else g for g in group]
        tree.append(s)
    return [_door(rng, s) for s in (*tree, *others[:2])]


def _door(rng: np.random.Generator, s: _Shared) -> Door:
    width = round(rng.uniform(0.95, 1.10), 2)
    margin = _DOOR_MARGIN_M + width / 2
    at = round(rng.uniform(s.low_m + margin, s.high_m - margin), 2)
    return Door(s.at_m, at, 1.0, 0.0, width) if s.upright else Door(at, s.at_m, 0.0, 1.0, width)


def _walls(cuts: list[list[float]], split: float, width: float, depth: float, doors: list[Door]) -> list[Wall]:
    h = WALL_M / 2
    walls = [
        Wall(-h, -h, width + h, h, 0.0, HEIGHT_M),
        Wall(-h, depth - h, width + h, depth + h, 0.0, HEIGHT_M),
        Wall(-h, h, h, depth - h, 0.0, HEIGHT_M),
        Wall(width - h, h, width + h, depth - h, 0.0, HEIGHT_M),
    ]
    flat = [d for d in doors if d.normal_y]
    for low, high, z_min in _pieces(h, width - h, [(d.x_m, d.width_m) for d in flat]):
        walls.append(Wall(low, split - h, high, split + h, z_min, HEIGHT_M))
    for row, (bottom, top) in enumerate(((h, split - h), (split + h, depth - h))):
        for x in cuts[row][1:-1]:
            here = [(d.y_m, d.width_m) for d in doors if d.normal_x and d.x_m == x and bottom < d.y_m < top]
            for low, high, z_min in _pieces(bottom, top, here):
                walls.append(Wall(x - h, low, x + h, high, z_min, HEIGHT_M))
    return walls


def _pieces(low: float, high: float, gaps: list[tuple[float, float]]) -> list[tuple[float, float, float]]:
    """Cut low..high at the gaps (centre, width): (from, to, z_min), with the lintels above the gaps."""
    pieces: list[tuple[float, float, float]] = []
    for centre, width in sorted(gaps):
        pieces.append((low, centre - width / 2, 0.0))
        pieces.append((centre - width / 2, centre + width / 2, DOOR_HEIGHT_M))
        low = centre + width / 2
    return [*pieces, (low, high, 0.0)]


def _dock(rng: np.random.Generator, rooms: list[Room], doors: list[Door]) -> Dock:
    """Against a wall, away from doorways; the living room where it fits."""
    zones = [door_zone(door) for door in doors]
    for room in sorted(rooms, key=lambda r: -r.area_m2):
        for _ in range(40):
            side = int(rng.integers(4))
            yaw = side * math.pi / 2
            x = rng.uniform(room.x_min_m + 0.55, room.x_max_m - 0.55)
            y = rng.uniform(room.y_min_m + 0.55, room.y_max_m - 0.55)
            x = (room.x_max_m - DOCK_GAP_M, x, room.x_min_m + DOCK_GAP_M, x)[side]
            y = (y, room.y_max_m - DOCK_GAP_M, y, room.y_min_m + DOCK_GAP_M)[side]
            dock = Dock(round(float(x), 3), round(float(y), 3), yaw if yaw <= math.pi else yaw - 2 * math.pi)
            if not any(dock_zone(dock).overlaps(zone) for zone in zones):
                return dock
    raise RuntimeError("no wall has room for a dock")
