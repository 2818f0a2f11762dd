"""The laser scan as a page draws it: points round the robot, with where it stood."""

from pydantic import Field

from contracts.base import Message, StampS
from contracts.geometry import Pose2D


class LaserScan(Message):
    """`GET /scan` of robot_bridge: the newest scan, thinned to `points_max` of its points."""

    stamp_s: StampS
    pose: Pose2D | None = Field(default=None, description="base_link in map when it was taken; none = not localised")
    points_m: tuple[tuple[float, float], ...] = Field(
        default=(), max_length=2000, description="x, y of each beam that hit something, in base_link, m"
    )
