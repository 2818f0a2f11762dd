"""What is known of this robot's laser that its messages do not say."""

import math
from enum import StrEnum

from pydantic import BaseModel, ConfigDict, Field, model_validator

from robot_bridge.body import BodyLimits

MASK_RAD_MAX = 0.5


class ZeroRange(StrEnum):
    """What a laser means by a range of 0.0."""

    UNKNOWN = "unknown"
    """It may be anything: what is too near reads 0.0 with many."""
    NOTHING_THERE = "nothing_there"
    """No echo from within its reach."""


class LaserMask(BaseModel):
    """A part of the robot that the laser sees: bearings from base_link's x axis, counter-clockwise, as seen from the
    laser, and how far from the laser it is at most. What is seen past it counts."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    from_rad: float = Field(ge=-math.tau, le=math.tau)
    to_rad: float = Field(ge=-math.tau, le=math.tau)
    range_m_max: float = Field(gt=0.0, le=0.5)

    @model_validator(mode="after")
    def is_narrow(self) -> "LaserMask":
        """What is masked is not seen: no more than a post of the robot's may be."""
        if not 0.0 < self.to_rad - self.from_rad <= MASK_RAD_MAX:
            raise ValueError(f"a mask goes counter-clockwise from from_rad to to_rad, {MASK_RAD_MAX} rad at most")
        return self


class LaserRules(BodyLimits):
    laser_zero_means: ZeroRange = Field(default=ZeroRange.UNKNOWN, description="what a range of 0.0 says")
    laser_masks: tuple[LaserMask, ...] = Field(default=(), description="the robot's own parts in the scan")
