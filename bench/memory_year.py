"""A year of sightings: a home whose things stay or wander by their kind, and a robot that drives through it daily."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from contracts.geometry import Point3D, Pose2D
from contracts.memory import Observation

SIDE_M = 12.0
"""The home is a square; walls hide nothing, so that more is seen from more places than in a real one."""
REACH_M = 2.8
HFOV_RAD = 0.942
YEAR_S = 365.0 * 86_400.0
START_S = 1.7e9
STAYS = ("couch", "bed", "tv", "refrigerator", "sink", "toilet", "dining table", "potted plant", "clock", "oven")
WANDERS = ("cup", "bottle", "bowl", "book", "remote", "cell phone", "backpack", "chair", "teddy bear", "vase")
COLOURS = ("red", "blue", "green", "white", None)


@dataclass
class Item:
    """One thing of the home; `moves_a_year` is how often somebody puts it elsewhere."""

    label: str
    colour: str | None
    x: float
    y: float
    z: float
    moves_a_year: float


def household(rng: np.random.Generator, count: int = 80) -> list[Item]:
    items: list[Item] = []
    for index in range(count):
        wanders = index % 4 != 0
        label = str(rng.choice(WANDERS if wanders else STAYS))
        x, y = rng.uniform(0.5, SIDE_M - 0.5, 2)
        moves = float(rng.choice([6.0, 26.0, 100.0])) if wanders else 0.2
        items.append(
            Item(label, COLOURS[index % len(COLOURS)], float(x), float(y), float(rng.uniform(0.1, 0.9)), moves)
        )
    return items


def frames(sightings: int, *, seed: int) -> Iterator[list[Observation]]:
    """The observations of one frame at a time, about so many in all, evenly over the year."""
    rng = np.random.default_rng(seed)
    items = household(rng)
    made = 0
    x, y, yaw = SIDE_M / 2.0, SIDE_M / 2.0, 0.0
    last_s = START_S
    while made < sightings:
        stamp_s = START_S + YEAR_S * made / sightings
        _wander(items, (stamp_s - last_s) / YEAR_S, rng)
        last_s = stamp_s
        yaw = math.remainder(yaw + rng.normal(0.0, 0.5), 2.0 * math.pi)
        x = min(max(x + 0.15 * math.cos(yaw), 0.3), SIDE_M - 0.3)
        y = min(max(y + 0.15 * math.sin(yaw), 0.3), SIDE_M - 0.3)
        seen = _seen(items, Pose2D(x=x, y=y, yaw=yaw), stamp_s, rng)
        if seen:
            made += len(seen)
            yield seen


def _wander(items: list[Item], years: float, rng: np.random.Generator) -> None:
    for item in items:
        if rng.random() < item.moves_a_year * years:
            item.x, item.y = (float(one) for one in rng.uniform(0.5, SIDE_M - 0.5, 2))


def _seen(items: list[Item], pose: Pose2D, stamp_s: float, rng: np.random.Generator) -> list[Observation]:
    found: list[Observation] = []
    for item in items:
        dx, dy = item.x - pose.x, item.y - pose.y
        away_m = math.hypot(dx, dy)
        bearing = math.remainder(math.atan2(dy, dx) - pose.yaw, 2.0 * math.pi)
        if not 0.3 < away_m < REACH_M or abs(bearing) > HFOV_RAD / 2.0 or rng.random() > 1.1 - away_m / 3.0:
            continue
        error_m = rng.normal(0.0, 0.012 * away_m**3.461 + 0.05, 2)
        confidence = float(np.clip(0.95 - 0.2 * away_m + rng.normal(0.0, 0.08), 0.3, 0.99))
        found.append(
            Observation(
                label=item.label,
                confidence=confidence,
                pose=pose,
                stamp_s=stamp_s,
                colour=item.colour if rng.random() < 0.6 else None,
                position=Point3D(x=item.x + float(error_m[0]), y=item.y + float(error_m[1]), z=item.z)
                if away_m < 2.5
                else None,
            )
        )
    return found
