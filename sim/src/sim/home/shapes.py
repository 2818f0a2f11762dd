"""The few solid shapes every thing is assembled from, in the thing's own frame (metres, radians, z up, front +y)."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

Vec = tuple[float, float, float]
WHITE: Vec = (1.0, 1.0, 1.0)
_FACING_FRONT: Vec = (-math.pi / 2, 0.0, math.pi)


@dataclass(frozen=True, slots=True)
class Geom:
    """One MuJoCo geom: `size_m` is its full extent along its own axes; `solid` ones take part in collisions."""

    shape: str
    centre_m: Vec
    size_m: Vec
    rgb: Vec = WHITE
    material: str = "matte"
    euler_rad: Vec = (0.0, 0.0, 0.0)
    mesh: str = ""
    solid: bool = True
    group: int = 0
    alpha: float = 1.0


def box(centre_m: Vec, size_m: Vec, rgb: Vec = WHITE, material: str = "matte", **more: object) -> Geom:
    """A box by its centre and full extents."""
    return replace(Geom("box", centre_m, size_m, rgb, material), **more)  # pyright: ignore[reportArgumentType]


def ellipsoid(centre_m: Vec, size_m: Vec, rgb: Vec = WHITE, material: str = "matte", **more: object) -> Geom:
    """An ellipsoid by its centre and full extents."""
    return replace(Geom("ellipsoid", centre_m, size_m, rgb, material), **more)  # pyright: ignore[reportArgumentType]


def cylinder(
    centre_m: Vec, diameter_m: float, height_m: float, rgb: Vec = WHITE, material: str = "matte", **more: object
) -> Geom:
    """An upright cylinder by its centre."""
    geom = Geom("cylinder", centre_m, (diameter_m, diameter_m, height_m), rgb, material)
    return replace(geom, **more)  # pyright: ignore[reportArgumentType]


def unit_mesh(name: str, size_m: Vec, rgb: Vec = WHITE, material: str = "matte", **more: object) -> Geom:
    """A mesh of `meshes.build` (unit bounding box, base at z = 0) stretched to `size_m`, base centre at `centre_m`."""
    geom = Geom("mesh", (0.0, 0.0, 0.0), size_m, rgb, material, mesh=name)
    return replace(geom, **more)  # pyright: ignore[reportArgumentType]


def front_panel(centre_m: Vec, width_m: float, height_m: float, rgb: Vec = WHITE, material: str = "matte") -> Geom:
    """A thin upright picture whose texture is seen, upright and unmirrored, from +y."""
    return Geom("box", centre_m, (width_m, height_m, 0.004), rgb, material, _FACING_FRONT, solid=False)


def four(half_x_m: float, half_y_m: float) -> Iterable[tuple[float, float]]:
    """The four corners of a rectangle around the origin, for legs and wheels."""
    return ((a * half_x_m, b * half_y_m) for a in (-1, 1) for b in (-1, 1))


def shade(rgb: Vec, factor: float) -> Vec:
    """The colour made darker (< 1) or lighter (> 1), clipped to 0..1."""
    r, g, b = (min(1.0, max(0.0, c * factor)) for c in rgb)
    return (r, g, b)


def tint(rgb: Vec, towards: Vec, part: float) -> Vec:
    """A mix of two colours: `part` = 0 gives `rgb`, 1 gives `towards`."""
    r, g, b = (a + (z - a) * part for a, z in zip(rgb, towards, strict=True))
    return (r, g, b)
