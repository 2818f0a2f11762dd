"""Procedural meshes with texture coordinates as OBJ bytes, each fitted into x, y in -0.5..0.5 and z in 0..1."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_SEGMENTS = 28


@dataclass(frozen=True)
class Mesh:
    """Vertices [n, 3] in m, triangles [m, 3] of vertex numbers, texture coordinates [n, 2]."""

    vertices: Array
    faces: NDArray[np.int64]
    uv: Array

    def fitted(self) -> "Mesh":
        """The mesh moved and stretched into the unit box."""
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        centred = (self.vertices - (low + high) / 2) / np.maximum(high - low, 1e-9)
        return Mesh(centred + np.array([0.0, 0.0, 0.5]), self.faces, self.uv)

    def obj_bytes(self) -> bytes:
        """Wavefront OBJ text of the mesh."""
        lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in self.vertices]
        lines += [f"vt {u:.4f} {v:.4f}" for u, v in self.uv]
        lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in self.faces + 1]
        return ("\n".join(lines) + "\n").encode()


def names() -> tuple[str, ...]:
    """The names `build` knows."""
    return tuple(_RECIPES)


@lru_cache(maxsize=64)
def build(name: str) -> bytes:
    """OBJ bytes of a named mesh; KeyError for an unknown name."""
    return _RECIPES[name]().fitted().obj_bytes()


def lathe(profile: Sequence[tuple[float, float]] | Array, segments: int = _SEGMENTS) -> Mesh:
    """Surface of revolution of a (radius, z) profile from bottom to top; u is the angle, v the length along it."""
    points = np.asarray(profile, float)
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    angle = np.linspace(0, 2 * np.pi, segments + 1)
    radius = np.maximum(points[:, :1], 1e-4)
    height = np.repeat(points[:, 1:], segments + 1, axis=1)
    vertices = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=-1).reshape(-1, 3)
    u, v = np.broadcast_arrays(angle / (2 * np.pi), (length / length[-1])[:, None])
    return Mesh(vertices, _grid_faces(len(points), segments), np.stack([u, v], axis=-1).reshape(-1, 2))


def tube(path: Array, radius_m: float | Array, sides: int = 10) -> Mesh:
    """A round tube along a polyline [n, 3], with one radius or one per point."""
    radii = np.broadcast_to(np.asarray(radius_m, float), (len(path),))
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    vertices: list[Array] = []
    for point, tangent, radius in zip(path, np.gradient(path, axis=0), radii, strict=True):
        along = tangent / np.linalg.norm(tangent)
        side = np.cross(along, (0.0, 1.0, 0.01))
        side /= np.linalg.norm(side)
        other = np.cross(along, side)
        vertices.append(point + radius * (np.outer(np.cos(angle), side) + np.outer(np.sin(angle), other)))
    uv = [(i / len(path), k / sides) for i in range(len(path)) for k in range(sides + 1)]
    return Mesh(np.concatenate(vertices), _grid_faces(len(path), sides), np.array(uv))


def leaves(seed: int, count: int, width: float, droop: float) -> Mesh:
    """A tuft of two-sided leaves of unit length growing from the origin."""
    rng = np.random.default_rng(seed)
    vertices: list[Array] = []
    faces: list[tuple[int, int, int]] = []
    uv: list[tuple[float, float]] = []
    for _ in range(count):
        turn, tilt, length = rng.uniform(0, 2 * np.pi), rng.uniform(0.1, 1.15), rng.uniform(0.65, 1.05)
        along = np.array([np.cos(turn) * np.sin(tilt), np.sin(turn) * np.sin(tilt), np.cos(tilt)])
        across = np.array([-np.sin(turn), np.cos(turn), 0.0])
        first = len(vertices)
        for step in range(7):
            t = step / 6
            middle = along * length * t - np.array([0, 0, droop * length * t * t * np.sin(tilt)])
            half = length * width * np.sin(np.pi * min(1.0, t * 0.93 + 0.05))
            vertices += [middle - across * half, middle + across * half]
            uv += [(0.0, t), (1.0, t)]
        for step in range(6):
            p = first + 2 * step
            faces += [(p, p + 1, p + 3), (p, p + 3, p + 2), (p, p + 3, p + 1), (p, p + 2, p + 3)]
    return Mesh(np.array(vertices), np.array(faces), np.array(uv))


def _grid_faces(rows: int, columns: int) -> NDArray[np.int64]:
    quads = np.array([i * (columns + 1) + k for i in range(rows - 1) for k in range(columns)])
    above = quads + columns + 1
    return np.concatenate(
        [np.stack([quads, quads + 1, above + 1], axis=1), np.stack([quads, above + 1, above], axis=1)]
    )


def _rounded(points: Sequence[tuple[float, float]], steps: int = 5) -> Array:
    """Catmull-Rom spline through the profile points, radii kept non-negative."""
    p = np.array([points[0], *points, points[-1]], float)
    out: list[Array] = []
    for a, b, c, d in zip(p, p[1:], p[2:], p[3:], strict=False):
        for t in np.arange(steps) / steps:
            cubic = -a + 3 * b - 3 * c + d
            out.append(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + cubic * t**3))
    curve = np.array([*out, p[-1]])
    curve[:, 0] = np.maximum(curve[:, 0], 0.0)
    return curve


def _bottle(shoulder: float, neck: float, slope: float) -> Mesh:
    return lathe([
        (0, 0), (0.46, 0), (0.5, 0.02), (0.5, shoulder), (0.47, shoulder + slope * 0.3),
        (0.32, shoulder + slope * 0.75), (neck, shoulder + slope), (neck, 0.90), (neck + 0.04, 0.905),
        (neck + 0.04, 0.99), (0, 1.0),
    ])  # fmt: skip


def _cup(bottom: float) -> Mesh:
    return lathe([
        (0, 0), (bottom * 0.94, 0), (bottom, 0.03), (0.5, 1), (0.46, 1), (bottom - 0.05, 0.08), (0, 0.08),
    ])  # fmt: skip


def _bowl(belly: float) -> Mesh:
    return lathe(np.concatenate([
        _rounded([(0.24, 0), (0.25, 0.08), (belly, 0.42), (0.5, 1.0)], 4),
        _rounded([(0.47, 1.0), (belly - 0.04, 0.47), (0.2, 0.15), (0, 0.14)], 4),
    ]))  # fmt: skip


def _vase(belly: float, neck: float, lip: float) -> Mesh:
    return lathe(_rounded([
        (0, 0), (0.27, 0), (0.3, 0.03), (belly, 0.36), (belly * 0.86, 0.6), (neck, 0.82), (neck, 0.9),
        (lip, 1.0), (lip - 0.05, 1.0), (neck - 0.05, 0.88), (0, 0.75),
    ]))  # fmt: skip


def _wine_glass() -> Mesh:
    stem = [(0, 0), (0.42, 0), (0.42, 0.02), (0.06, 0.05), (0.045, 0.12), (0.045, 0.42), (0.12, 0.46)]
    cup = _rounded([(0.12, 0.46), (0.44, 0.58), (0.5, 0.74), (0.42, 1.0)], 4)
    return lathe(np.concatenate([np.array(stem), cup, [[0.39, 1.0], [0.46, 0.74], [0, 0.7]]]))


def _apple() -> Mesh:
    return lathe(_rounded([(0, 0.1), (0.22, 0.0), (0.44, 0.22), (0.5, 0.56), (0.42, 0.86), (0.2, 1.0), (0, 0.84)]))


def _banana() -> Mesh:
    t = np.linspace(-1.05, 1.05, 17)
    path = np.stack([np.sin(t), 0 * t, 1 - np.cos(t)], axis=1)
    thick = 0.2 * np.clip(1.22 - np.abs(t) ** 4, 0.25, 1.0)
    return tube(path, thick)


def _arc(span_rad: float, radius_m: float, upright: bool = True) -> Mesh:
    t = np.linspace(-span_rad / 2, span_rad / 2, 15)
    path = np.stack([np.sin(t), 0 * t, np.cos(t)] if upright else [np.cos(t), 0 * t, np.sin(t)], axis=1)
    return tube(path, radius_m)


def _umbrella() -> Mesh:
    """An eight-ribbed canopy with a scalloped rim, open side down, tilted so that it rests on part of its rim."""
    turns, rings = 48, 9
    angle = np.linspace(0, 2 * np.pi, turns + 1)
    sag = 1 - 0.09 * np.abs(np.sin(angle * 4))
    reach = np.linspace(0.02, 1, rings)
    vertices: list[Array] = []
    for r in reach:
        rim = 1 - (1 - sag) * r
        z = np.cos(r * 1.25) + (1 - sag) * r
        vertices.append(np.stack([r * rim * np.cos(angle), r * rim * np.sin(angle), z], axis=1))
    for r in reach[::-1]:
        rim = 1 - (1 - sag) * r
        z = np.cos(r * 1.25) + (1 - sag) * r - 0.02
        vertices.append(np.stack([r * rim * np.cos(angle), r * rim * np.sin(angle), z], axis=1))
    uv = [(k / turns, i / rings) for i in range(2 * rings) for k in range(turns + 1)]
    # The grid runs rim to rim through the tip; faces wind outwards when listed from the rim up.
    flat = np.concatenate(vertices[::-1])
    return Mesh(flat, _grid_faces(2 * rings, turns), np.array(uv))


def _toilet_bowl() -> Mesh:
    outside = [(0, 0), (0.28, 0), (0.26, 0.25), (0.3, 0.5), (0.5, 0.9), (0.5, 1.0)]
    return lathe(_rounded([*outside, (0.36, 1.0), (0.3, 0.8), (0, 0.7)]))


def _basin() -> Mesh:
    return lathe(_rounded([(0, 0), (0.2, 0), (0.42, 0.4), (0.5, 0.9), (0.5, 1.0), (0.44, 1.0), (0.36, 0.6), (0, 0.4)]))


_POT = [(0, 0), (0.36, 0), (0.38, 0.03), (0.46, 0.82), (0.5, 0.84), (0.5, 1.0), (0.44, 1.0), (0.42, 0.86), (0, 0.86)]

_RECIPES: Final[dict[str, Callable[[], Mesh]]] = {
    "bottle0": lambda: _bottle(0.56, 0.17, 0.18),
    "bottle1": lambda: _bottle(0.62, 0.2, 0.1),
    "bottle2": lambda: _bottle(0.46, 0.15, 0.3),
    "cup0": lambda: _cup(0.44),
    "cup1": lambda: _cup(0.36),
    "handle": lambda: _arc(np.pi * 1.05, 0.2, upright=False),
    "bowl0": lambda: _bowl(0.42),
    "bowl1": lambda: _bowl(0.37),
    "vase0": lambda: _vase(0.5, 0.2, 0.3),
    "vase1": lambda: _vase(0.46, 0.27, 0.4),
    "vase2": lambda: _vase(0.5, 0.15, 0.22),
    "wine_glass": _wine_glass,
    "apple": _apple,
    "banana": _banana,
    "ball": lambda: lathe([(np.sin(t) / 2, 0.5 - np.cos(t) / 2) for t in np.linspace(0, np.pi, 17)], 32),
    "strap": lambda: _arc(np.pi, 0.09),
    "umbrella": _umbrella,
    "crook": lambda: _arc(np.pi, 0.22),
    "pot": lambda: lathe(_POT),
    "leaves0": lambda: leaves(1, 30, 0.10, 0.35),
    "leaves1": lambda: leaves(2, 18, 0.20, 0.45),
    "leaves2": lambda: leaves(3, 44, 0.06, 0.25),
    "flowers": lambda: leaves(4, 14, 0.12, 0.2),
    "toilet_bowl": _toilet_bowl,
    "basin": _basin,
}
