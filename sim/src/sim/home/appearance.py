"""The colours of a home's floors, walls and woods, its rugs and its pictures, chosen pale so that things stand out."""

import math

import numpy as np

from sim.home.layout import Layout, Rect, dock_zone, door_zone
from sim.home.model import Appearance, Furniture, Room, Rug
from sim.home.shapes import Vec

_WALLS: tuple[Vec, ...] = (
    (0.90, 0.88, 0.84), (0.86, 0.89, 0.91), (0.91, 0.91, 0.90), (0.88, 0.90, 0.84), (0.92, 0.87, 0.85),
)  # fmt: skip
_WOODS: tuple[Vec, ...] = ((0.74, 0.56, 0.38), (0.60, 0.42, 0.27), (0.82, 0.68, 0.50), (0.46, 0.32, 0.22))
_PLANKS: tuple[Vec, ...] = ((0.70, 0.55, 0.40), (0.78, 0.66, 0.52), (0.56, 0.43, 0.32), (0.66, 0.62, 0.57))
_TILES: tuple[Vec, ...] = ((0.82, 0.82, 0.80), (0.70, 0.73, 0.75), (0.78, 0.73, 0.66))
_CARPETS: tuple[Vec, ...] = ((0.66, 0.65, 0.62), (0.58, 0.62, 0.68), (0.70, 0.64, 0.58), (0.60, 0.65, 0.60))
_RUGS: tuple[Vec, ...] = ((0.62, 0.50, 0.46), (0.48, 0.54, 0.62), (0.66, 0.62, 0.52), (0.52, 0.58, 0.52))
_QUILTS: tuple[Vec, ...] = ((0.55, 0.66, 0.78), (0.78, 0.66, 0.62), (0.66, 0.72, 0.62), (0.72, 0.70, 0.80))


def decorate(layout: Layout, pieces: list[Furniture], rng: np.random.Generator) -> Appearance:
    """Everything about a home's looks that is not a piece of furniture or a thing."""

    def pick(choices: tuple[Vec, ...]) -> Vec:
        chosen, light = choices[int(rng.integers(len(choices)))], rng.uniform(0.96, 1.04)
        r, g, b = (round(float(c * light), 3) for c in chosen)
        return (r, g, b)

    planks = pick(_PLANKS)
    floors: list[tuple[str, Vec]] = []
    for room in layout.rooms:
        if room.name in ("kitchen", "bathroom"):
            floors.append(("tiles", pick(_TILES)))
        elif rng.random() < 0.3:
            floors.append(("carpet", pick(_CARPETS)))
        else:
            floors.append(("planks", planks))
    woods = rng.permutation(len(_WOODS))[:2]
    rugs = tuple(_rug(room, rng, pick(_RUGS)) for room in layout.rooms if room.area_m2 > 11 and rng.random() < 0.5)
    pictures = [p for room in layout.rooms for p in _pictures(room, layout, pieces, rng)]
    return Appearance(
        tuple(floors), pick(_WALLS), pick(((0.95, 0.95, 0.94), (0.66, 0.62, 0.57))),
        (_WOODS[int(woods[0])], _WOODS[int(woods[1])]), pick(_QUILTS), rugs, tuple(pictures),
    )  # fmt: skip


def _rug(room: Room, rng: np.random.Generator, rgb: Vec) -> Rug:
    width, depth = rng.uniform(1.2, 1.8), rng.uniform(0.9, 1.4)
    x = rng.uniform(room.x_min_m + width / 2 + 0.2, room.x_max_m - width / 2 - 0.2)
    y = rng.uniform(room.y_min_m + depth / 2 + 0.2, room.y_max_m - depth / 2 - 0.2)
    return Rug(round(float(x), 3), round(float(y), 3), round(float(width), 3), round(float(depth), 3), rgb)


def _pictures(
    room: Room, layout: Layout, pieces: list[Furniture], rng: np.random.Generator
) -> list[tuple[float, float, float]]:
    """At most one picture per room, away from doorways and from tall furniture."""
    side = int(rng.integers(4))
    yaw = (0.0, math.pi / 2, math.pi, -math.pi / 2)[side]
    x, y = rng.uniform(room.x_min_m + 0.6, room.x_max_m - 0.6), rng.uniform(room.y_min_m + 0.6, room.y_max_m - 0.6)
    x = round(float((x, room.x_max_m, x, room.x_min_m)[side]), 3)
    y = round(float((room.y_min_m, y, room.y_max_m, y)[side]), 3)
    here = Rect(x - 0.4, y - 0.4, x + 0.4, y + 0.4)
    blocked = any(here.overlaps(door_zone(door)) for door in layout.doors) or here.overlaps(dock_zone(layout.dock))
    tall = any(p.size_m[2] > 1.0 and math.hypot(p.x_m - x, p.y_m - y) < 1.0 for p in pieces)
    return [] if blocked or tall or rng.random() < 0.3 else [(x, y, yaw)]
