"""What each kind of furniture looks like, and the surfaces on which things may stand."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from sim.home.catalog import Place
from sim.home.shapes import Geom, Vec, box, cylinder, ellipsoid, four, shade, unit_mesh

_DARK: Vec = (0.10, 0.10, 0.11)
_STEEL: Vec = (0.72, 0.73, 0.75)
_LINEN: Vec = (0.95, 0.94, 0.92)
_PORCELAIN: Vec = (0.97, 0.97, 0.97)
_OPEN_M = 2.0
"""Headroom of a surface with nothing above it."""
_PAINT: Final[tuple[Vec, ...]] = ((0.93, 0.92, 0.89), (0.80, 0.82, 0.84))


@dataclass(frozen=True, slots=True)
class Surface:
    """A level rectangle in the furniture's own frame; things on it may be `headroom_m` tall."""

    place: Place
    x_m: float
    y_m: float
    half_x_m: float
    half_y_m: float
    z_m: float
    headroom_m: float


def furniture_geoms(kind: str, rgb: Vec | None, size_m: Vec, variant: int) -> list[Geom]:
    """Geoms of one piece in its own frame, base centre at the origin, front along +y; `rgb` None is bare wood."""
    return _BUILDERS[kind](rgb, size_m, variant)


def surfaces(kind: str, size_m: Vec) -> list[Surface]:
    """Where things may stand on a piece of this kind and size."""
    w, d, h = size_m
    tops = {
        "coffee table": Surface(Place.LOW, 0, 0, w / 2 - 0.06, d / 2 - 0.06, h, _OPEN_M),
        "cabinet": Surface(Place.LOW, 0, d * 0.08, w / 2 - 0.06, d / 2 - 0.09, h, _OPEN_M),
        "bed": Surface(Place.LOW, 0, d / 2 - 0.16, w / 2 - 0.15, 0.03, 0.445, _OPEN_M),
        "couch": Surface(Place.LOW, 0, d / 2 - 0.17, w / 2 - 0.35, 0.02, 0.43, _OPEN_M),
        "counter": Surface(Place.HIGH, 0, d * 0.1, w / 2 - 0.06, d / 2 - 0.12, h, _OPEN_M),
    }
    if kind == "shelf":
        return [
            Surface(Place.BOARD, 0, 0.04, w / 2 - 0.15, 0.03, z + 0.0125, above - z - 0.03)
            for z, above in pairwise(_board_heights(h))
        ]
    return [tops[kind]] if kind in tops else []


def _board_heights(height_m: float) -> tuple[float, ...]:
    return (0.08, 0.08 + 0.42 * (height_m - 0.095), height_m - 0.0125)


def _painted(rgb: Vec | None, wood: str = "wood0") -> tuple[Vec, str]:
    return ((1.0, 1.0, 1.0), wood) if rgb is None else (rgb, "matte")


def _chair(rgb: Vec | None, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    c, m = _painted(rgb)
    seat = 0.46
    geoms = [box((0, 0.01, seat), (w, d - 0.02, 0.045), c, m)]
    geoms += [box((x, y, seat / 2), (0.042, 0.042, seat), c, m) for x, y in four(w / 2 - 0.03, d / 2 - 0.03)]
    back_y, up = -d / 2 + 0.03, h - seat
    geoms += [box((s * (w / 2 - 0.03), back_y, seat + up / 2), (0.042, 0.042, up), c, m) for s in (-1, 1)]
    if variant == 0:
        geoms += [box((0, back_y, seat + up * k), (w - 0.06, 0.024, 0.07), c, m) for k in (0.36, 0.62, 0.88)]
    elif variant == 1:
        geoms.append(box((0, back_y, seat + up * 0.66), (w - 0.06, 0.03, up * 0.62), c, m))
    else:
        geoms.append(box((0, back_y, h - 0.04), (w - 0.06, 0.03, 0.08), c, m))
        geoms += [box((x * w, back_y, seat + up / 2), (0.03, 0.02, up), c, m) for x in (-0.22, 0.0, 0.22)]
    return geoms


def _couch(rgb: Vec | None, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    c = rgb or (0.6, 0.6, 0.62)
    cushion = shade(c, 1.08) if sum(c) > 0.5 else shade(c, 1.5)
    arm, arm_h = 0.17, 0.58
    geoms = [
        box((0, 0, 0.20), (w, d, 0.30), c, "fabric"),
        box((0, -d / 2 + 0.11, h / 2 + 0.02), (w, 0.22, h - 0.04), c, "fabric"),
    ]
    for side in (-1, 1):
        geoms.append(box((side * (w / 2 - arm / 2), 0, arm_h / 2 + 0.03), (arm, d, arm_h - 0.06), c, "fabric"))
        top = (side * (w / 2 - arm / 2), 0.0, arm_h)
        geoms.append(ellipsoid(top, (arm * 1.05, d * 1.0, 0.09), c, "fabric", solid=False))
    seats = 2 if variant == 0 else 3
    each = (w - 2 * arm) / seats
    for k in range(seats):
        x = -(w - 2 * arm) / 2 + each * (k + 0.5)
        geoms.append(box((x, 0.10, 0.39), (each - 0.015, d - 0.24, 0.08), cushion, "fabric"))
        geoms.append(ellipsoid((x, d / 2 - 0.03, 0.385), (each - 0.02, 0.09, 0.09), cushion, "fabric", solid=False))
        geoms.append(ellipsoid((x, -d / 2 + 0.26, 0.58), (each * 0.96, 0.2, 0.40), cushion, "fabric", solid=False))
    geoms += [cylinder((x, y, 0.03), 0.05, 0.06, (0.2, 0.13, 0.08)) for x, y in four(w / 2 - 0.08, d / 2 - 0.08)]
    return geoms


def _bed(rgb: Vec | None, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    quilt = rgb or (0.45, 0.58, 0.74)
    geoms = [
        box((0, 0.03, 0.13), (w, d - 0.06, 0.26), (1.0, 1.0, 1.0), "wood0"),
        box((0, 0.03, 0.34), (w * 0.98, d - 0.10, 0.16), _LINEN, "fabric"),
        box((0, d * 0.15, 0.37), (w * 1.0, d * 0.69, 0.15), quilt, "fabric"),
        box((0, -d / 2 + 0.03, h / 2), (w, 0.06, h), (1.0, 1.0, 1.0), "wood0"),
    ]
    pillows = (-w * 0.25, w * 0.25) if w > 1.1 else (0.0,)
    geoms += [ellipsoid((x, -d / 2 + 0.33, 0.47), (w * 0.42, 0.42, 0.2), _LINEN, "fabric") for x in pillows]
    return geoms


def _dining_table(rgb: Vec | None, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    c, m = _painted(rgb, f"wood{variant}")
    geoms = [box((0, 0, h - 0.018), (w, d, 0.036), c, m)]
    geoms.append(box((0, 0, h - 0.07), (w - 0.16, d - 0.16, 0.07), c, m))
    geoms += [box((x, y, h / 2 - 0.02), (0.065, 0.065, h - 0.04), c, m) for x, y in four(w / 2 - 0.06, d / 2 - 0.06)]
    return geoms


def _bench(rgb: Vec | None, size: Vec, variant: int) -> list[Geom]:
    """A park bench: slats on two dark frames."""
    w, d, h = size
    slat: Vec = (1.0, 1.0, 1.0)
    geoms = [
        box((0, y, 0.44), (w, 0.085, 0.03), slat, "wood0")
        for y in (-d / 2 + 0.09, -d / 2 + 0.19, -d / 2 + 0.29, d / 2 - 0.05)
    ]
    geoms += [box((0, -d / 2 + 0.03, z), (w, 0.028, 0.085), slat, "wood0") for z in (h - 0.05, h - 0.17, h - 0.29)]
    for side in (-1, 1):
        x = side * (w / 2 - 0.1)
        geoms.append(box((x, d / 2 - 0.04, 0.21), (0.05, 0.05, 0.42), _DARK))
        geoms.append(box((x, -d / 2 + 0.055, h / 2), (0.05, 0.05, h), _DARK))
        geoms.append(box((x, 0, 0.40), (0.05, d - 0.04, 0.04), _DARK))
    return geoms


def _toilet(rgb: Vec | None, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    bowl_d = d - 0.2
    y = d / 2 - bowl_d / 2
    quarter = 0.40
    return [
        unit_mesh("toilet_bowl", (w * 0.92, bowl_d, quarter), _PORCELAIN, "gloss", centre_m=(0, y, 0)),
        ellipsoid((0, y, quarter), (w * 0.95, bowl_d, 0.05), _PORCELAIN, "gloss"),
        box((0, -d / 2 + 0.17, 0.2), (w * 0.5, 0.26, 0.4), _PORCELAIN, "gloss"),
        box((0, -d / 2 + 0.1, 0.56), (w, 0.2, h - 0.40), _PORCELAIN, "gloss"),
        box((0, -d / 2 + 0.1, h - 0.012), (w * 1.04, 0.22, 0.03), _PORCELAIN, "gloss"),
        ellipsoid((0, -d / 2 + 0.26, 0.60), (w * 0.92, 0.04, 0.46), (0.93, 0.93, 0.94), "gloss", solid=False),
        box((w * 0.3, -d / 2 + 0.205, h - 0.08), (0.07, 0.02, 0.025), _STEEL, "gloss", solid=False),
    ]


def _sink(rgb: Vec | None, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    top = h - 0.1
    return [
        cylinder((0, -0.05, (top - 0.12) / 2), 0.19, top - 0.12, _PORCELAIN, "gloss"),
        unit_mesh("basin", (w, d, 0.2), _PORCELAIN, "gloss", centre_m=(0, 0, top - 0.18)),
        box((0, -d / 2 + 0.06, top - 0.02), (w * 0.8, 0.12, 0.06), _PORCELAIN, "gloss"),
        cylinder((0, -d / 2 + 0.07, top + 0.05), 0.03, 0.12, _STEEL, "gloss", solid=False),
        box((0, -d / 2 + 0.13, h - 0.015), (0.03, 0.15, 0.025), _STEEL, "gloss", solid=False),
    ]


def _oven(rgb: Vec | None, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    case: Vec = ((0.93, 0.93, 0.93), (0.62, 0.63, 0.65))[variant]
    front = d / 2 - 0.03
    geoms = [
        box((0, -0.02, h / 2), (w, d - 0.04, h), case),
        box((0, front + 0.004, h * 0.44), (w * 0.92, 0.02, h * 0.56), _DARK, "gloss", solid=False),
        box((0, front + 0.016, h * 0.44), (w * 0.66, 0.004, h * 0.34), (0.24, 0.20, 0.18), "gloss", solid=False),
        box((0, front + 0.02, h * 0.69), (w * 0.8, 0.03, 0.022), _STEEL, "gloss", solid=False),
        box((0, front + 0.004, h * 0.10), (w * 0.92, 0.016, h * 0.09), shade(case, 0.86), solid=False),
        box((0, -0.02, h - 0.004), (w, d - 0.04, 0.012), _DARK, "gloss", solid=False),
    ]
    quarter = (1.5708, 0.0, 0.0)
    for k in range(5):
        x = (k - 2) * w * 0.19
        geoms.append(cylinder((x, front + 0.012, h * 0.87), 0.05, 0.03, _DARK, euler_rad=quarter, solid=False))
    return geoms


def _refrigerator(rgb: Vec | None, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    case: Vec = ((0.95, 0.95, 0.95), (0.72, 0.74, 0.76), (0.88, 0.90, 0.92))[variant]
    front, split = d / 2 - 0.03, h * 0.36
    return [
        box((0, -0.03, h / 2), (w, d - 0.06, h), shade(case, 0.9)),
        box((0, front - 0.01, split / 2 + 0.02), (w * 0.99, 0.05, split - 0.05), case),
        box((0, front - 0.01, (h + split) / 2), (w * 0.99, 0.05, h - split - 0.02), case),
        box((0, front - 0.02, 0.02), (w * 0.95, 0.03, 0.04), _DARK, solid=False),
        box((-w * 0.42, front + 0.03, split + 0.28), (0.028, 0.03, 0.46), (0.45, 0.46, 0.48), "gloss", solid=False),
        box((-w * 0.42, front + 0.03, split - 0.20), (0.028, 0.03, 0.26), (0.45, 0.46, 0.48), "gloss", solid=False),
    ]


def _coffee_table(rgb: Vec | None, size: Vec, variant: int) -> list[Geom]:
    """A plate on a closed plinth, so that a lidar sees what a robot would hit."""
    w, d, h = size
    c, m = _painted(_PAINT[0] if variant == 1 else None, "wood1")
    return [
        box((0, 0, h - 0.02), (w, d, 0.04), c, m),
        box((0, 0, (h - 0.04) / 2), (w - 0.06, d - 0.06, h - 0.04), shade(c, 0.9), m),
    ]


def _drawers(size: Vec, columns: int, rows: int, rgb: Vec, material: str) -> list[Geom]:
    w, d, h = size
    geoms = [box((0, -0.012, h / 2), (w, d - 0.024, h), rgb, material)]
    high = (h - 0.06) / rows
    for i in range(columns):
        for k in range(rows):
            x, z = -w / 2 + w * (i + 0.5) / columns, 0.05 + high * (k + 0.5)
            door = box((x, d / 2 - 0.018, z), (w / columns - 0.02, 0.018, high - 0.015), shade(rgb, 0.94), material)
            geoms.append(door)
            handle = (x, d / 2 - 0.004, z + high * 0.3)
            geoms.append(box(handle, (0.11, 0.014, 0.014), (0.35, 0.35, 0.36), solid=False))
    return geoms


def _cabinet(rgb: Vec | None, size: Vec, variant: int) -> list[Geom]:
    c, m = _painted(_PAINT[1] if variant == 1 else None, "wood1")
    return _drawers(size, max(1, round(size[0] / 0.5)), 1, c, m)


def _counter(rgb: Vec | None, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    c, m = _painted(_PAINT[0] if variant == 1 else None, "wood1")
    top = box((0, 0, h - 0.02), (w, d, 0.04), (0.42, 0.43, 0.45))
    return [*_drawers((w, d - 0.02, h - 0.04), max(2, round(w / 0.5)), 2, c, m), top]


def _shelf(rgb: Vec | None, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    c, m = _painted(_PAINT[0] if variant == 1 else None, "wood1")
    geoms = [box((0, 0, z), (w - 0.04, d, 0.025), c, m) for z in _board_heights(h)]
    geoms += [box((s * (w / 2 - 0.015), 0, h / 2), (0.03, d, h), c, m) for s in (-1, 1)]
    geoms.append(box((0, -d / 2 + 0.006, h / 2), (w - 0.04, 0.012, h), shade(c, 0.88), m))
    geoms.append(box((0, d / 2 - 0.02, 0.035), (w - 0.04, 0.02, 0.07), c, m))
    return geoms


_BUILDERS: Final[dict[str, Callable[[Vec | None, Vec, int], list[Geom]]]] = {
    "chair": _chair,
    "couch": _couch,
    "bed": _bed,
    "dining table": _dining_table,
    "bench": _bench,
    "toilet": _toilet,
    "sink": _sink,
    "oven": _oven,
    "refrigerator": _refrigerator,
    "coffee table": _coffee_table,
    "cabinet": _cabinet,
    "counter": _counter,
    "shelf": _shelf,
}
