"""Where something could stand that the laser does not see: arcs of unknown beams, and the places in them. Pure."""

import math

import numpy as np
from numpy.typing import NDArray

THING_M = 0.03
"""What is to be seen: the leg of a chair. Nearer than `THING_M / width` an arc of `width` rad cannot hide one."""
RAYS_APART_RAD = 0.05
PLACES_APART_M = 0.05

Arcs = NDArray[np.float64]
"""(n, 2): where each arc begins, counter-clockwise from base_link's x axis, and how wide it is, rad."""
NO_ARCS: Arcs = np.empty((0, 2))
ALL_ROUND: Arcs = np.array([[0.0, math.tau]])
BEHIND_A_BEAM_M = 1e-3


def arcs_of(unknown: NDArray[np.bool_], first_rad: float, step_rad: float) -> Arcs:
    """The runs of unknown beams among all round a full circle: (n,) beams from `first_rad`, `step_rad` apart; what they
    do not reach is unknown."""
    if step_rad < 0.0:
        unknown, first_rad, step_rad = unknown[::-1], first_rad + step_rad * (unknown.size - 1), -step_rad
    rest = max(0, round((math.tau - unknown.size * step_rad) / step_rad))
    ring = np.concatenate([unknown, np.ones(rest, np.bool_)])
    if ring.all():
        return np.array([[first_rad, math.tau]])
    if not ring.any():
        return NO_ARCS
    known = int(np.argmin(ring))
    turned = np.roll(ring, -known).astype(np.int8)  # begins with a known beam: no run passes the end
    edges = np.diff(np.append(turned, 0))
    begin, end = np.flatnonzero(edges == 1) + 1, np.flatnonzero(edges == -1) + 1
    starts_rad = first_rad + (known + begin - 0.5) * step_rad
    return np.stack([starts_rad, (end - begin) * step_rad], axis=1).astype(np.float64)


def hiding_places(arcs: Arcs, laser_m: tuple[float, float], body_m: float, reach_m: float) -> NDArray[np.float64]:
    """(n, 2) points in base_link, from the body (a disc of `body_m`) to `reach_m` from its middle, where a thing of
    `THING_M` could stand unseen in one of the arcs, as the laser at `laser_m` looks."""
    near = arcs[arcs[:, 1] * (reach_m + math.hypot(*laser_m)) >= THING_M]
    if not near.size:
        return np.empty((0, 2))
    rays = np.ceil(near[:, 1] / RAYS_APART_RAD).astype(int)
    arc = np.repeat(np.arange(len(near)), rays)
    of_arc = np.arange(arc.size) - np.repeat(np.cumsum(rays) - rays, rays)
    begin, width = near[arc, 0], near[arc, 1]
    bearing = begin + width * (of_arc + 0.5) / rays[arc]
    along = np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
    origin = np.asarray(laser_m)
    from_m = np.maximum(THING_M / width, _out_of_body(origin, along, body_m) + BEHIND_A_BEAM_M)
    steps = np.arange(0.0, reach_m + math.hypot(*laser_m), PLACES_APART_M)
    places = (origin + along[:, None, :] * (from_m[:, None] + steps)[:, :, None]).reshape(-1, 2)
    return places[np.hypot(places[:, 0], places[:, 1]) <= reach_m]


def _out_of_body(origin: NDArray[np.float64], along: NDArray[np.float64], body_m: float) -> NDArray[np.float64]:
    """(n,) how far each ray goes until it is out of the body, m; 0 where it never is in it."""
    ahead = along @ origin
    inside = ahead**2 - origin @ origin + body_m**2
    return np.where(inside > 0.0, np.maximum(0.0, -ahead + np.sqrt(np.maximum(0.0, inside))), 0.0)
