"""Where to take pictures from: poses of the robot's camera on free floor, mostly with something to find ahead."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from sim.home import Furniture, Home, Thing
from sim.home.catalog import COCO_IDS, THINGS
from sim.world.robot import CAMERA_Z_M, RGB_FOV_RAD

FIELD_OF_VIEW_DEG = math.degrees(RGB_FOV_RAD)
ROOM_FOR_ROBOT_M = 0.2
SHARE_ANYWHERE = 0.15
SHARE_OF_FURNITURE = 0.15
TRIES = 400


@dataclass(frozen=True)
class View:
    """A camera pose: yaw counter-clockwise, pitch down positive, roll clockwise, all in radians."""

    x_m: float
    y_m: float
    z_m: float
    yaw: float
    pitch: float
    roll: float
    field_of_view_deg: float


@dataclass(frozen=True)
class _Block:
    """The footprint of something that stands on the floor."""

    x_m: float
    y_m: float
    yaw: float
    half_width_m: float
    half_depth_m: float

    def covers(self, x_m: float, y_m: float, margin_m: float) -> bool:
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        along = cos * (x_m - self.x_m) + sin * (y_m - self.y_m)
        across = -sin * (x_m - self.x_m) + cos * (y_m - self.y_m)
        return abs(along) < self.half_width_m + margin_m and abs(across) < self.half_depth_m + margin_m


class Viewpoints:
    """Draws views of one home."""

    def __init__(self, home: Home, rng: np.random.Generator) -> None:
        self._rng = rng
        self._rooms = home.rooms
        standing = [*home.furniture, *(thing for thing in home.things if thing.support == "floor")]
        self._blocks = [_Block(p.x_m, p.y_m, p.yaw, p.size_m[0] / 2, p.size_m[1] / 2) for p in standing]
        self._findable = _by_kind(thing for thing in home.things if THINGS[thing.kind].findable)
        large = (*home.furniture, *(thing for thing in home.things if not THINGS[thing.kind].findable))
        self._large = _by_kind(piece for piece in large if piece.kind in COCO_IDS)

    def draw(self) -> View | None:
        """A view, or None when no free floor was met."""
        for _ in range(TRIES):
            x_m, y_m, yaw = self._place()
            if self._free(x_m, y_m):
                return self._jittered(x_m, y_m, yaw)
        return None

    def _place(self) -> tuple[float, float, float]:
        rng, choice = self._rng, self._rng.random()
        if choice < SHARE_ANYWHERE or not self._findable:
            room = self._rooms[int(rng.integers(len(self._rooms)))]
            x_m, y_m = rng.uniform(room.x_min_m, room.x_max_m), rng.uniform(room.y_min_m, room.y_max_m)
            return float(x_m), float(y_m), float(rng.uniform(-math.pi, math.pi))
        furniture = choice < SHARE_ANYWHERE + SHARE_OF_FURNITURE and bool(self._large)
        targets, reach_m = (self._large, (1.1, 4.0)) if furniture else (self._findable, (0.4, 2.6))
        places = targets[int(rng.integers(len(targets)))]
        target_x, target_y = places[int(rng.integers(len(places)))]
        distance_m = math.exp(rng.uniform(math.log(reach_m[0]), math.log(reach_m[1])))
        bearing = rng.uniform(-math.pi, math.pi)
        x_m, y_m = target_x - distance_m * math.cos(bearing), target_y - distance_m * math.sin(bearing)
        return float(x_m), float(y_m), float(bearing + rng.normal(0, math.radians(12)))

    def _free(self, x_m: float, y_m: float) -> bool:
        inside = any(
            room.x_min_m + ROOM_FOR_ROBOT_M < x_m < room.x_max_m - ROOM_FOR_ROBOT_M
            and room.y_min_m + ROOM_FOR_ROBOT_M < y_m < room.y_max_m - ROOM_FOR_ROBOT_M
            for room in self._rooms
        )
        return inside and not any(block.covers(x_m, y_m, ROOM_FOR_ROBOT_M) for block in self._blocks)

    def _jittered(self, x_m: float, y_m: float, yaw: float) -> View:
        rng = self._rng
        return View(
            x_m=x_m,
            y_m=y_m,
            z_m=CAMERA_Z_M + float(rng.normal(0, 0.004)),
            yaw=yaw,
            pitch=math.radians(float(rng.normal(0, 1.0))),
            roll=math.radians(float(rng.normal(0, 0.8))),
            field_of_view_deg=FIELD_OF_VIEW_DEG + float(rng.normal(0, 1.0)),
        )


def _by_kind(pieces: Iterable[Thing | Furniture]) -> list[list[tuple[float, float]]]:
    """Where they stand, kind by kind, so that rare kinds are drawn as often as common ones."""
    places: dict[str, list[tuple[float, float]]] = {}
    for piece in pieces:
        places.setdefault(piece.kind, []).append((piece.x_m, piece.y_m))
    return list(places.values())
