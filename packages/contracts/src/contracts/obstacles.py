"""What stands round the robot, from one pass over the laser scan (requirement C4)."""

from enum import StrEnum

from pydantic import Field

from contracts.base import Message, StampS

BearingRad = Field(ge=-3.15, le=3.15, description="rad from the robot's x axis, counter-clockwise positive")


class SectorLabel(StrEnum):
    """What a distance means to somebody who wants to drive there."""

    WALL = "WALL"
    """Nearly touched."""
    OBSTACLE = "OBSTACLE"
    """Too near to drive there."""
    NEAR = "NEAR"
    """Only slowly."""
    CLEAR = "CLEAR"
    """Free."""


class RingSector(Message):
    """One of the twelve sectors of 30 degrees; the first is centred straight ahead, the next ones to its left."""

    bearing_rad: float = BearingRad
    distance_m: float | None = Field(
        default=None, ge=0.0, description="10th percentile of the distances from the footprint; none = nothing in reach"
    )
    label: SectorLabel | None = Field(default=None, description="none = no beam says anything about it")


class Gap(Message):
    """An opening between two things, wide enough for a doorway."""

    bearing_rad: float = BearingRad
    distance_m: float = Field(ge=0.0, description="from base_link to its middle")
    width_m: float = Field(gt=0.0)


class Affordances(Message):
    """How well one could drive there: 0.1 (blocked, or not known) to 1.0 (free), linear in the distance."""

    forward: float = Field(default=0.1, ge=0.1, le=1.0)
    forward_left: float = Field(default=0.1, ge=0.1, le=1.0)
    forward_right: float = Field(default=0.1, ge=0.1, le=1.0)
    left: float = Field(default=0.1, ge=0.1, le=1.0)
    right: float = Field(default=0.1, ge=0.1, le=1.0)
    backward: float = Field(default=0.1, ge=0.1, le=1.0)


class Obstacles(Message):
    """Nearest distance to the footprint, by named sector, and what can be read from it."""

    stamp_s: StampS
    sectors_m: dict[str, float | None] = Field(
        description="front, front_wide, front_left, front_right, left, right, back: metres from the footprint, "
        "none = nothing seen"
    )
    ring: tuple[RingSector, ...] = Field(default=(), max_length=12)
    gaps: tuple[Gap, ...] = Field(default=(), max_length=20, description="nearest first")
    affordances: Affordances = Affordances()
    emergency: bool = Field(description="something is inside the stop distance ahead")
