"""Poses, points and velocities: SI units, right-handed frames, yaw counter-clockwise (REP-103, REP-105)."""

from pydantic import Field

from contracts.base import Message


class Pose2D(Message):
    """Position and heading in a named frame, `map` unless a field says otherwise."""

    x: float = Field(ge=-10_000.0, le=10_000.0, description="m")
    y: float = Field(ge=-10_000.0, le=10_000.0, description="m")
    yaw: float = Field(ge=-6.2832, le=6.2832, description="rad, counter-clockwise from the x axis")


class Point3D(Message):
    x: float = Field(ge=-10_000.0, le=10_000.0, description="m")
    y: float = Field(ge=-10_000.0, le=10_000.0, description="m")
    z: float = Field(ge=-100.0, le=100.0, description="m, up")


class Twist2D(Message):
    """Velocity of base_link expressed in base_link (x forward, y left, z up)."""

    linear_x: float = Field(default=0.0, ge=-2.0, le=2.0, description="m/s, forward positive")
    angular_z: float = Field(default=0.0, ge=-4.0, le=4.0, description="rad/s, counter-clockwise positive")
