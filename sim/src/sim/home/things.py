"""What each kind of thing looks like: its geoms, filling the bounding box the catalogue gives it."""

import math
from collections.abc import Callable
from typing import Final

from sim.home.shapes import (
    WHITE,
    Geom,
    Vec,
    box,
    cylinder,
    ellipsoid,
    four,
    front_panel,
    shade,
    tint,
    unit_mesh,
)

_DARK: Vec = (0.10, 0.10, 0.11)
_STEEL: Vec = (0.74, 0.75, 0.77)
_PAPER: Vec = (0.96, 0.94, 0.87)
_SOIL: Vec = (0.24, 0.16, 0.10)


def thing_geoms(kind: str, rgb: Vec, size_m: Vec, variant: int) -> list[Geom]:
    """Geoms of one thing in its own frame; `rgb` is unused by kinds that have their natural colour."""
    return _BUILDERS[kind](rgb, size_m, variant)


def _bottle(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    return [unit_mesh(f"bottle{variant}", size, rgb, "label")]


def _cup(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    reach = (w - d) / 2
    handle = unit_mesh(
        "handle", (reach + 0.012, 0.016, h * 0.62), rgb, "gloss", centre_m=(d / 2 + reach / 2 - 0.006, 0, h * 0.2)
    )
    return [unit_mesh(f"cup{variant}", (d, d, h), rgb, "gloss"), handle]


def _bowl(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    return [unit_mesh(f"bowl{variant}", size, rgb, "gloss")]


def _vase(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    return [unit_mesh(f"vase{variant}", size, rgb, "gloss")]


def _book(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    if variant == 0:  # stands closed, cover to the front
        t = min(d, 0.05)
        return [
            box((0, 0, h / 2), (w, t, h), rgb),
            box((0.004, 0, h / 2), (w, t * 0.74, h + 0.002), _PAPER, solid=False),
            front_panel((0, t / 2 + 0.001, h / 2), w, h, rgb, "cover"),
        ]
    if variant == 1:  # stands half open, like a tent seen from above
        lean = math.atan2(d * 0.9, w)
        half = w * 0.5 / math.cos(lean)
        geoms: list[Geom] = []
        for side in (-1, 1):
            middle = (side * w / 4, 0.0, h / 2)
            turn = (0.0, 0.0, -side * lean)
            geoms.append(box(middle, (half, 0.008, h), rgb, euler_rad=turn))
            inner = (side * w / 4, -0.012, h / 2)
            geoms.append(box(inner, (half * 0.94, 0.018, h * 0.96), _PAPER, euler_rad=turn, solid=False))
        return geoms
    pile: list[Geom] = []  # three volumes lying on each other
    for k, turn in enumerate((0.0, 0.12, -0.1)):
        z = (k + 0.5) * h / 3
        pile.append(box((0, 0, z), (w * 0.97, d * 0.97, h / 3 * 0.97), rgb, euler_rad=(0, 0, turn)))
        pile.append(
            box((0.004, 0.003, z), (w * 0.97, d * 0.98, h / 3 * 0.62), _PAPER, euler_rad=(0, 0, turn), solid=False)
        )
    return pile


def _teddy_bear(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    sx, sy, sz = size[0] / 0.29, size[1] / 0.27, size[2] / 0.385
    muzzle = tint(rgb, (0.93, 0.84, 0.68), 0.75)

    def ball(x: float, y: float, z: float, a: float, b: float, c: float, colour: Vec, material: str = "fur") -> Geom:
        return ellipsoid((x * sx, (y - 0.05) * sy, z * sz), (2 * a * sx, 2 * b * sy, 2 * c * sz), colour, material)

    geoms = [
        ball(0, 0, 0.12, 0.095, 0.085, 0.12, rgb),
        ball(0, 0.055, 0.11, 0.06, 0.045, 0.08, muzzle),
        ball(0, 0.005, 0.285, 0.083, 0.075, 0.077, rgb),
        ball(0, 0.07, 0.268, 0.038, 0.032, 0.03, muzzle),
        ball(0, 0.1, 0.28, 0.014, 0.01, 0.011, _DARK, "matte"),
    ]
    for side in (-1, 1):
        geoms += [
            ball(side * 0.066, 0, 0.352, 0.034, 0.018, 0.033, rgb),
            ball(side * 0.066, 0.012, 0.350, 0.02, 0.01, 0.02, muzzle),
            ball(side * 0.11, 0.03, 0.17, 0.035, 0.05, 0.075, rgb),
            ball(side * 0.07, 0.1, 0.045, 0.045, 0.085, 0.045, rgb),
            ball(side * 0.072, 0.176, 0.05, 0.03, 0.012, 0.03, muzzle),
            ball(side * 0.032, 0.069, 0.305, 0.011, 0.008, 0.012, _DARK, "matte"),
        ]
    return geoms


def _sports_ball(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    return [unit_mesh("ball", size, rgb, ("football", "basketball", "gloss")[variant], euler_rad=(0.0, 0.0, 0.0))]


def _backpack(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    pocket, strap = shade(rgb, 0.78), tint(shade(rgb, 0.5), _DARK, 0.3)
    geoms = [
        box((0, -d * 0.1, h * 0.42), (w * 0.9, d * 0.56, h * 0.78), rgb, "fabric"),
        ellipsoid((0, -d * 0.1, h * 0.76), (w * 0.9, d * 0.56, h * 0.36), rgb, "fabric"),
        ellipsoid((0, d * 0.1, h * 0.44), (w * 0.86, d * 0.5, h * 0.84), rgb, "fabric"),
        box((0, d * 0.28, h * 0.26), (w * 0.72, d * 0.36, h * 0.36), pocket, "fabric"),
        ellipsoid((0, d * 0.28, h * 0.44), (w * 0.72, d * 0.36, h * 0.14), pocket, "fabric"),
        box((0, d * 0.465, h * 0.385), (w * 0.6, 0.006, 0.012), _STEEL, "gloss", solid=False),
        unit_mesh("strap", (w * 0.34, 0.03, h * 0.11), strap, centre_m=(0, -d * 0.15, h * 0.89), solid=False),
    ]
    for side in (-1, 1):
        geoms.append(ellipsoid((side * w * 0.44, 0, h * 0.26), (w * 0.14, d * 0.5, h * 0.38), pocket, "fabric"))
        geoms.append(ellipsoid((side * w * 0.27, -d * 0.42, h * 0.5), (w * 0.14, d * 0.16, h * 0.74), strap, "fabric"))
    return geoms


def _handbag(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    body, gold = h * 0.62, (0.90, 0.76, 0.36)
    geoms = [
        box((0, 0, body * 0.45), (w, d, body * 0.9), rgb, "fabric"),
        ellipsoid((0, 0, body * 0.86), (w, d, body * 0.28), rgb, "fabric"),
        unit_mesh("strap", (w * 0.56, 0.03, h * 0.42), shade(rgb, 0.6), centre_m=(0, 0, h * 0.58), solid=False),
    ]
    if variant == 0:
        geoms.append(box((0, d / 2, body * 0.66), (w * 0.98, 0.012, body * 0.46), shade(rgb, 0.72), "fabric"))
    geoms.append(box((0, d / 2 + 0.006, body * 0.5), (0.05, 0.012, 0.035), gold, "gloss", solid=False))
    return geoms


def _suitcase(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    shell = h * 0.74
    bottom = 0.05
    geoms = [box((0, 0, bottom + shell / 2), (w, d * 0.88, shell), rgb)]
    for x, y in four(w * 0.42, d * 0.32):
        geoms.append(cylinder((x, y, 0.025), 0.05, 0.03, _DARK, euler_rad=(0.0, math.pi / 2, 0.0)))
    for side in (-1, 1):
        rod = h - bottom - shell
        geoms.append(box((side * w * 0.24, -d * 0.3, h - rod / 2), (0.018, 0.018, rod), _STEEL, solid=False))
    geoms.append(box((0, -d * 0.3, h - 0.015), (w * 0.54, 0.034, 0.03), _DARK))
    for k in range(-3, 4):
        ridge = (k * w / 8, d * 0.44, bottom + shell / 2)
        geoms.append(box(ridge, (0.016, d * 0.06, shell * 0.92), shade(rgb, 0.7), solid=False))
    return geoms


def _umbrella(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    """Open, lying on its rim: the shaft leans back from the floor to the canopy's tip."""
    radius = min(size[0], size[1]) / 2 * 0.96
    lean = 1.02
    tip = 0.40 * radius
    # In the canopy's own frame the rim is at z = 0 and the tip at about 0.7 radius; tilt it about the x axis.
    s, c = math.sin(lean), math.cos(lean)
    lift = radius * s * 0.62
    middle = (0.0, -radius * 0.15, lift)

    def at(z: float) -> Vec:
        return (middle[0], middle[1] + z * s, middle[2] + z * c)

    canopy = unit_mesh("umbrella", (2 * radius * 0.72, 2 * radius * 0.72, 0.55 * radius), rgb, "fabric")
    euler = (-lean, 0.0, 0.0)
    parts = [Geom(canopy.shape, at(0), canopy.size_m, rgb, "fabric", euler, "umbrella")]
    parts.append(cylinder(at(-0.05), 0.018, 1.2 * radius, _STEEL, euler_rad=euler, solid=False))
    parts.append(cylinder(at(tip + 0.2 * radius), 0.02, 0.1 * radius, _DARK, euler_rad=euler, solid=False))
    return parts


def _potted_plant(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, _, h = size
    pot_rgb: Vec = ((0.76, 0.40, 0.25), (0.90, 0.89, 0.85), (0.34, 0.40, 0.46))[variant]
    pot = (w * 0.52, w * 0.52, h * 0.36)
    return [
        unit_mesh("pot", pot, pot_rgb),
        cylinder((0, 0, pot[2] * 0.93), pot[0] * 0.86, 0.01, _SOIL, solid=False),
        unit_mesh(f"leaves{variant}", (w, w, h * 0.68), WHITE, "leaf", centre_m=(0, 0, h * 0.32), solid=False),
    ]


def _clock(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    quarter = (math.pi / 2, 0.0, 0.0)
    return [
        cylinder((0, 0, h / 2), w, d, (0.16, 0.16, 0.18), euler_rad=quarter),
        cylinder((0, d / 2, h / 2), w * 0.9, 0.004, (0.98, 0.98, 0.97), euler_rad=quarter, solid=False),
        front_panel((0, d / 2 + 0.002, h / 2), w * 0.66, h * 0.66, WHITE, "clock"),
    ]


def _laptop(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    """Base towards the viewer (+y), screen leaning back; the keyboard rises a little so that a low camera sees it."""
    w, d, h = size
    case: Vec = ((0.72, 0.73, 0.75), (0.20, 0.20, 0.22))[variant]
    open_rad, deep = 0.35, d * 0.66
    tall = (h - 0.02) / math.cos(open_rad)
    hinge_y = -d / 2 + tall * math.sin(open_rad) + 0.005
    middle_y, middle_z = hinge_y - tall / 2 * math.sin(open_rad), 0.018 + tall / 2 * math.cos(open_rad)
    lid = (math.pi / 2 + open_rad, 0.0, 0.0)
    facing = (-math.pi / 2 + open_rad, 0.0, math.pi)
    face_y, face_z = middle_y + 0.006 * math.cos(open_rad), middle_z + 0.006 * math.sin(open_rad)
    return [
        box((0, hinge_y + deep / 2, 0.01), (w, deep, 0.02), case),
        box((0, hinge_y + deep * 0.42, 0.021), (w * 0.88, deep * 0.55, 0.002), WHITE, "keys", solid=False),
        box((0, middle_y, middle_z), (w, tall, 0.010), case, euler_rad=lid),
        box((0, face_y, face_z), (w * 0.92, tall * 0.88, 0.003), WHITE, "screen", euler_rad=facing, solid=False),
    ]


def _keyboard(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    lean = math.atan2(h - 0.022, d)
    return [
        box((0, 0, h / 2), (w, d / math.cos(lean) * 0.97, 0.02), (0.22, 0.22, 0.24), euler_rad=(-lean, 0.0, 0.0)),
        box(
            (0, 0.011 * math.sin(lean), h / 2 + 0.011 * math.cos(lean)),
            (w * 0.97, d / math.cos(lean) * 0.9, 0.003),
            WHITE,
            "keys",
            euler_rad=(-lean, 0.0, math.pi),
            solid=False,
        ),
        box((0, -d * 0.4, h * 0.42), (w * 0.9, 0.02, h * 0.84), (0.22, 0.22, 0.24)),
    ]


def _wine_glass(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    wine = ellipsoid((0, 0, h * 0.64), (w * 0.86, d * 0.86, h * 0.28), (0.42, 0.03, 0.10), "gloss", solid=False)
    return [wine, unit_mesh("wine_glass", size, (0.80, 0.88, 0.94), "gloss", alpha=0.45)]


def _apple(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    stalk = cylinder((0, 0, h * 0.94), 0.007, h * 0.14, (0.3, 0.2, 0.1), solid=False)
    return [unit_mesh("apple", (w, d, h * 0.9), rgb, "gloss"), stalk]


def _orange(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    dimple = ellipsoid((0, 0, h * 0.985), (0.016, 0.016, 0.008), (0.25, 0.42, 0.12), solid=False)
    return [unit_mesh("ball", (w, d, h), (1.0, 0.50, 0.03)), dimple]


def _banana(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    yellow: Vec = (0.98, 0.84, 0.12)
    return [
        unit_mesh("banana", (w, d * 0.42, h), shade(yellow, 1.0 - 0.06 * k), "matte", centre_m=(0, y, 0))
        for k, y in enumerate((-d * 0.28, 0.0, d * 0.28))
    ]


def _microwave(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    case: Vec = ((0.86, 0.86, 0.87), (0.20, 0.20, 0.22))[variant]
    return [
        box((0, -0.01, h / 2 + 0.008), (w, d - 0.04, h - 0.016), case),
        box((w * 0.12, d / 2 - 0.028, h / 2), (w * 0.66, 0.006, h * 0.74), (0.05, 0.05, 0.07), "gloss", solid=False),
        box((-w * 0.25, d / 2 - 0.015, h / 2), (0.018, 0.03, h * 0.72), _STEEL, "gloss", solid=False),
        box((-w * 0.39, d / 2 - 0.028, h * 0.76), (w * 0.16, 0.006, h * 0.16), (0.10, 0.36, 0.30), solid=False),
        box((-w * 0.39, d / 2 - 0.028, h * 0.4), (w * 0.16, 0.006, h * 0.4), (0.55, 0.56, 0.58), solid=False),
    ]


def _toaster(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    case: Vec = ((0.80, 0.81, 0.83), (0.82, 0.10, 0.10))[variant]
    geoms = [
        box((0, 0, h * 0.44), (w * 0.9, d, h * 0.84), case, "gloss"),
        box((0, 0, 0.012), (w, d * 0.96, 0.024), _DARK),
        box((w * 0.47, 0, h * 0.6), (w * 0.06, 0.05, 0.022), _DARK, solid=False),
    ]
    for y in (-d * 0.2, d * 0.2):
        geoms.append(box((0, y, h * 0.86), (w * 0.7, 0.035, 0.006), _DARK, solid=False))
        geoms.append(box((0, y, h * 0.92), (w * 0.52, 0.018, h * 0.15), (0.80, 0.58, 0.30), solid=False))
    return geoms


def _tv(rgb: Vec, size: Vec, variant: int) -> list[Geom]:
    w, d, h = size
    panel_h = h - 0.07
    return [
        box((0, 0, 0.07 + panel_h / 2), (w, 0.05, panel_h), (0.05, 0.05, 0.06), "gloss"),
        front_panel((0, 0.027, 0.07 + panel_h / 2), w - 0.05, panel_h - 0.05, WHITE, "screen"),
        box((0, 0, 0.008), (w * 0.4, d, 0.016), (0.07, 0.07, 0.08)),
        box((0, -0.01, 0.05), (0.07, 0.04, 0.09), (0.07, 0.07, 0.08)),
    ]


_BUILDERS: Final[dict[str, Callable[[Vec, Vec, int], list[Geom]]]] = {
    "bottle": _bottle,
    "cup": _cup,
    "bowl": _bowl,
    "vase": _vase,
    "book": _book,
    "teddy bear": _teddy_bear,
    "sports ball": _sports_ball,
    "backpack": _backpack,
    "handbag": _handbag,
    "suitcase": _suitcase,
    "umbrella": _umbrella,
    "potted plant": _potted_plant,
    "clock": _clock,
    "laptop": _laptop,
    "keyboard": _keyboard,
    "wine glass": _wine_glass,
    "apple": _apple,
    "orange": _orange,
    "banana": _banana,
    "microwave": _microwave,
    "toaster": _toaster,
    "tv": _tv,
}
