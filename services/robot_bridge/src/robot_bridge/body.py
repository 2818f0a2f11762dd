"""The body of the robot: what `GET /description` tells of it, and the limits of several parts begin with."""

from pydantic import BaseModel, ConfigDict, Field


class BodyLimits(BaseModel):
    """The footprint is a disc round base_link."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    footprint_radius_m: float = Field(default=0.189, gt=0.0, le=2.0, description="of the disc round base_link")
    speed_m_s_max: float = Field(default=0.306, gt=0.0, le=2.0, description="of the base: no request may be faster")
    turn_rad_s_max: float = Field(default=1.9, gt=0.0, le=4.0, description="of the base: no request may turn faster")
