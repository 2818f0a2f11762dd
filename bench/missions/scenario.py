"""What a mission of the campaign is: where, for what, with which memory, rules and faults; all drawn from its seed."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np

from bench.missions.place import SimulatedPlace
from bench.world.faults import Faults, draw
from contracts.geometry import Pose2D

KINDS_WANTED = ("bottle", "cup", "bowl", "vase", "book", "teddy bear", "sports ball", "backpack")
HOMES = 40
COLOURS = ("red", "green", "blue", "yellow")


class Present(StrEnum):
    """Whether the thing asked for is in the home."""

    THERE = "there"
    ABSENT = "absent"


class Remembered(StrEnum):
    """What memory says about it."""

    RIGHT = "right"
    MOVED = "moved"
    """Views of where it stood when the home was mapped; it stands elsewhere now."""
    NOTHING = "nothing"


@dataclass(frozen=True)
class Scenario:
    seed: int
    home: int
    kind: str
    colour: str
    asked_colour: str
    present: Present
    remembered: Remembered
    docked: bool
    faults: Faults
    rules: dict[str, Any] = field(default_factory=dict[str, Any])
    start: Pose2D | None = None
    """Where the robot begins; none: anywhere, or on the dock."""

    @property
    def command(self) -> str:
        return f"find the {self.asked_colour} {self.kind}"


def scenario(seed: int, *, faults: Faults | None = None) -> Scenario:
    """The campaign's mission of that seed. A fifth has no faults at all, the others one to four kinds together."""
    rng = np.random.default_rng([seed, 1])
    home = seed % HOMES
    kind, colour = wanted_in(home)
    present = Present.ABSENT if rng.random() < 0.2 else Present.THERE
    remembered = (Remembered.RIGHT, Remembered.MOVED, Remembered.NOTHING)[int(rng.choice(3, p=[0.45, 0.25, 0.3]))]
    asked = colour if present is Present.THERE else _absent_colour(home)
    count = 0 if rng.random() < 0.2 else int(rng.integers(1, 5))
    rules: dict[str, Any] = {}
    if rng.random() < 0.12:
        rules["approach_rule"] = "straight"
    if rng.random() < 0.12:
        rules["centering_rule"] = "proportional"
    if rng.random() < 0.12:
        rules["coverage_rule"] = "lawnmower"
    return Scenario(
        seed=seed, home=home, kind=kind, colour=colour, asked_colour=asked, present=present, remembered=remembered,
        docked=bool(rng.random() < 0.2), faults=draw(rng, count) if faults is None else faults, rules=rules,
    )  # fmt: skip


def wanted_in(home: int) -> tuple[str, str]:
    """The kind and colour that a home of the campaign holds exactly one of."""
    rng = np.random.default_rng([home, 2])
    return str(rng.choice(KINDS_WANTED)), str(rng.choice(COLOURS))


def _absent_colour(home: int) -> str:
    """None of the eight colours a home may hold that kind in: nothing there can be it."""
    return "brown" if wanted_in(home)[0] != "teddy bear" else "grey"


def remembered_views(place: SimulatedPlace, one: Scenario, rng: np.random.Generator) -> tuple[Pose2D, ...]:
    matching = [t for t in place.things if t.kind == one.kind and t.colour == one.colour]
    match one.remembered:
        case Remembered.NOTHING:
            return ()
        case Remembered.RIGHT if one.present is Present.THERE and matching:
            spot = matching[0]
        case _:
            spot = place.things[int(rng.integers(len(place.things)))]
    return place.views_of(spot.x_m, spot.y_m, rng, 4)
