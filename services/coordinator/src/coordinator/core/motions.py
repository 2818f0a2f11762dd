"""Plain motions as data: what a mission of kind MOVE does, leg by leg. Each leg is one of the core's activities."""

import math
from dataclasses import dataclass
from typing import Literal

from contracts.geometry import Pose2D
from contracts.intent import WantedAction
from coordinator.core.headings import headings_round
from coordinator.core.rules import Rules

TURN_STEP_RAD = 2.5
"""A turn is cut into steps shorter than half a turn: how much of one was done can be told from the heading."""


@dataclass(frozen=True, slots=True)
class PlaceLeg:
    """In map. `yaw` none: it arrives facing the way it drove. `may_miss`: the rest is done without it."""

    x: float
    y: float
    yaw: float | None
    name: str
    may_miss: bool = False
    is_a: Literal["place"] = "place"


@dataclass(frozen=True, slots=True)
class TurnLeg:
    """By an angle that is left, counter-clockwise positive. `from_rad`: the heading where the step under way began."""

    angle_rad: float
    from_rad: float | None = None
    is_a: Literal["turn"] = "turn"


@dataclass(frozen=True, slots=True)
class FaceLeg:
    """A heading by odometry (by the map, where there is none)."""

    heading_rad: float
    is_a: Literal["face"] = "face"


@dataclass(frozen=True, slots=True)
class StraightLeg:
    """`start`: where it began, by odometry; what is driven already counts when it is taken up again."""

    distance_m: float
    start: Pose2D | None = None
    is_a: Literal["straight"] = "straight"


@dataclass(frozen=True, slots=True)
class RoundLeg:
    """A full turn, looking at each stop."""

    is_a: Literal["round"] = "round"


@dataclass(frozen=True, slots=True)
class LookLeg:
    """One picture, from here."""

    is_a: Literal["look"] = "look"


Leg = PlaceLeg | TurnLeg | FaceLeg | StraightLeg | RoundLeg | LookLeg


@dataclass(frozen=True, slots=True)
class PlainMotion:
    """`what` tells it to a person. No legs: it only leaves the dock. `explores`: an exploration leads."""

    what: str
    legs: tuple[Leg, ...] = ()
    action: WantedAction = WantedAction.MOVE
    limit_s: float | None = None
    explores: bool = False
    explore_s: float | None = None
    """It drives home after so long; none = as is set."""
    map_id: str | None = None
    """Of the home its places are in; none where nobody said."""
    reached: tuple[str, ...] = ()
    missed: tuple[str, ...] = ()
    """Places by name."""


def next_step_rad(angle_rad: float) -> float:
    """Of a turn of which so much is left."""
    return angle_rad / max(1, math.ceil(abs(angle_rad) / TURN_STEP_RAD))


def looks_round(rules: Rules, heading_rad: float) -> tuple[Leg, ...]:
    """Once round: a look at each stop, none twice, and back to where it looked first."""
    *stops, last = headings_round(rules, heading_rad, math.tau)
    return (*(leg for stop in stops for leg in (FaceLeg(stop), LookLeg())), FaceLeg(last))
