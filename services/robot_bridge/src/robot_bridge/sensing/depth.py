"""How far away what a box shows is: depth pixels registered to the picture, and their near mode. Pure."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from contracts.description import DepthNoise
from contracts.geometry import Point3D
from robot_bridge.sensing.sensor_readings import Intrinsics

Box = tuple[float, float, float, float]

CORE_WIDTH = 0.5
CORE_HEIGHT = 0.6
"""The part of a box that is looked at: its borders show the background."""
SAMPLES_MIN = 12
SAMPLES_MAX = 4000
DEPTH_M_MAX = 65.535
"""What a depth picture in millimetres can say; a pixel that says more measured nothing."""
HOLE_M = 1.0
"""Where a hole is taken to be when nothing round it was measured either."""
MODE_SHARE_MIN = 0.15
"""A nearer group of depths counts as the thing from this share of the samples on; fewer are noise at the edges."""
NEAR_M = 0.3
TURN_AT_EDGE = 2.0
"""So much more than in its middle a turn moves what is seen at the edge of a picture 90 degrees wide."""
SHIFTS_MAX = 20
"""Of the window towards the middle of the group it was first laid over the near edge of."""


@dataclass(frozen=True, slots=True)
class Measured:
    """`distance_m` is along the optical axis, none where nothing was measured; `spread_m` a robust deviation."""

    distance_m: float | None
    spread_m: float | None
    samples: int
    reason: str = ""
    holes: float | None = None
    """Share of the box's depth pixels that measured nothing; none where the box shows no depth pixel at all."""


@dataclass(frozen=True, slots=True)
class InBox:
    """What the depth camera says inside a box: (n,) depths along the colour camera's axis, m; how much is missing."""

    depths_m: NDArray[np.float64]
    holes: float | None


def scaled_box(box: Box, from_px: tuple[int, int], to_px: tuple[int, int]) -> Box:
    """The same box in a picture of another size (width, height)."""
    sx, sy = to_px[0] / from_px[0], to_px[1] / from_px[1]
    return box[0] * sx, box[1] * sy, box[2] * sx, box[3] * sy


def core(box: Box) -> Box:
    """The middle of the box, at least 3 px wide and high."""
    cx, cy = (box[0] + box[2]) / 2.0, (box[1] + box[3]) / 2.0
    half_w = max(1.5, (box[2] - box[0]) * CORE_WIDTH / 2.0)
    half_h = max(1.5, (box[3] - box[1]) * CORE_HEIGHT / 2.0)
    return cx - half_w, cy - half_h, cx + half_w, cy + half_h


def depths_in_box(
    depth_m: NDArray[np.float32],
    box: Box,
    colour: Intrinsics,
    depth: Intrinsics,
    depth_in_colour: NDArray[np.float64] | None,
) -> InBox:
    """The depth pixels that fall into `box` of the colour picture.

    Each depth pixel becomes a point, is moved by `depth_in_colour` (4x4; none: the cameras share their place), and is
    projected into the colour picture. A hole has no depth to be projected with: it counts as being as far as the
    median of the window, which is right to within the parallax of the two cameras.
    """
    rows, columns = _window(depth_m.shape, box, colour, depth, depth_in_colour)
    part = depth_m[rows, columns].astype(np.float64)
    v, u = np.mgrid[rows, columns]
    good = (part > 0.0) & (part <= DEPTH_M_MAX)
    inside, z = _projected(part[good], u[good], v[good], box, colour, depth, depth_in_colour)
    typical_m = float(np.median(part[good])) if good.any() else HOLE_M
    missing = np.full(int((~good).sum()), typical_m)
    hollow, _ = _projected(missing, u[~good], v[~good], box, colour, depth, depth_in_colour)
    measured, missed = int(inside.sum()), int(hollow.sum())
    return InBox(z[inside], missed / (measured + missed) if measured + missed else None)


def _projected(
    z: NDArray[np.float64],
    u: NDArray[np.float64],
    v: NDArray[np.float64],
    box: Box,
    colour: Intrinsics,
    depth: Intrinsics,
    depth_in_colour: NDArray[np.float64] | None,
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Of each depth pixel (n,): does it fall into the box, and its depth along the colour camera's axis."""
    x = (u - depth.cx) / depth.fx * z
    y = (v - depth.cy) / depth.fy * z
    if depth_in_colour is not None:
        rotation, offset = depth_in_colour[:3, :3], depth_in_colour[:3, 3]
        x, y, z = rotation @ np.stack([x, y, z]) + offset[:, None]
    ahead = z > 0.0
    safe = np.where(ahead, z, 1.0)
    colour_u = colour.fx * x / safe + colour.cx
    colour_v = colour.fy * y / safe + colour.cy
    inside = (colour_u >= box[0]) & (colour_u <= box[2]) & (colour_v >= box[1]) & (colour_v <= box[3])
    return ahead & inside, z


def measure(found: InBox, noise: DepthNoise) -> Measured:
    """The near mode of what is in the box, and how much of the box says nothing."""
    measured = near_mode(found.depths_m, noise)
    return replace(measured, holes=found.holes)


def near_mode(depths_m: NDArray[np.float64], noise: DepthNoise) -> Measured:
    """The nearest group of depths that is large enough to be a thing: its median, spread and size."""
    if depths_m.size < SAMPLES_MIN:
        return Measured(None, None, int(depths_m.size), "too few depth pixels in the box")
    ordered = np.sort(depths_m[:: depths_m.size // SAMPLES_MAX + 1])
    enough = max(SAMPLES_MIN, int(MODE_SHARE_MIN * ordered.size))
    start = 0
    while start < ordered.size:
        near = float(ordered[start])
        width = max(0.06, 4.0 * noise.sigma_m(near))
        end = int(np.searchsorted(ordered, near + width, side="right"))
        if end - start >= enough:
            break
        start += 1
    else:
        return Measured(None, None, int(ordered.size), "no depth is shared by enough pixels")
    around = ordered[start:end]
    median = float(np.median(around))
    for _ in range(SHIFTS_MAX):
        around = ordered[np.abs(ordered - median) <= max(0.06, 2.5 * noise.sigma_m(median))]
        before, median = median, float(np.median(around))
        if median == before:
            break
    spread = 1.4826 * float(np.median(np.abs(around - median)))
    return Measured(median, spread, int(around.size))


def ray_point(u_px: float, v_px: float, distance_m: float, camera: Intrinsics) -> NDArray[np.float64]:
    """The point a pixel shows at a depth, in the camera's optical frame (requirement L3), homogeneous."""
    return np.array(
        [
            distance_m * (u_px - camera.cx) / camera.fx,
            distance_m * (v_px - camera.cy) / camera.fy,
            distance_m,
            1.0,
        ]
    )


@dataclass(frozen=True, slots=True)
class Localised:
    """A thing in base_link. `distance_m` is horizontal, from the camera to its near surface."""

    bearing_rad: float
    distance_m: float | None
    base_point: Point3D | None


def localise(box: Box, distance_m: float | None, camera: Intrinsics, camera_in_base: NDArray[np.float64]) -> Localised:
    """Where the middle of the box is; without a distance only its bearing (as of something 2 m away)."""
    u, v = (box[0] + box[2]) / 2.0, (box[1] + box[3]) / 2.0
    point = camera_in_base @ ray_point(u, v, distance_m if distance_m is not None else 2.0, camera)
    bearing = math.atan2(float(point[1]), float(point[0]))
    if distance_m is None:
        return Localised(bearing, None, None)
    horizontal = math.hypot(float(point[0] - camera_in_base[0, 3]), float(point[1] - camera_in_base[1, 3]))
    return Localised(bearing, horizontal, Point3D(x=float(point[0]), y=float(point[1]), z=float(point[2])))


def _window(
    shape: tuple[int, ...],
    box: Box,
    colour: Intrinsics,
    depth: Intrinsics,
    depth_in_colour: NDArray[np.float64] | None,
) -> tuple[slice, slice]:
    """The rows and columns of the depth image that can show the box, of what is `NEAR_M` away or farther."""
    aside = 0.0  # as the tangent of an angle
    if depth_in_colour is not None:
        turned = math.acos(max(-1.0, min(1.0, (float(np.trace(depth_in_colour[:3, :3])) - 1.0) / 2.0)))
        aside = float(np.linalg.norm(depth_in_colour[:3, 3])) / NEAR_M + TURN_AT_EDGE * math.tan(min(turned, 1.0))
    room_u, room_v = aside * depth.fx + 4.0, aside * depth.fy + 4.0
    u0 = (box[0] - colour.cx) / colour.fx * depth.fx + depth.cx - room_u
    u1 = (box[2] - colour.cx) / colour.fx * depth.fx + depth.cx + room_u
    v0 = (box[1] - colour.cy) / colour.fy * depth.fy + depth.cy - room_v
    v1 = (box[3] - colour.cy) / colour.fy * depth.fy + depth.cy + room_v
    height, width = shape[0], shape[1]
    return (
        slice(int(min(max(v0, 0), height)), int(min(max(v1 + 1, 0), height))),
        slice(int(min(max(u0, 0), width)), int(min(max(u1 + 1, 0), width))),
    )
