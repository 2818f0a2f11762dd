"""What the robot's body is like: robot_bridge tells it, whoever reasons about the body reads it there."""

import math

from pydantic import Field

from contracts.base import SIGMA_M_MAX, ImageSidePx, Message
from contracts.geometry import Point3D


class DepthNoise(Message):
    """Standard deviation of the depth camera at a distance: `at_1m_m` times the distance to the power of `exponent`."""

    at_1m_m: float = Field(gt=0.0, le=1.0, description="at one metre")
    exponent: float = Field(ge=0.0, le=6.0, description="by which it grows with the distance")

    def sigma_m(self, distance_m: float) -> float:
        return min(self.at_1m_m * distance_m**self.exponent, SIGMA_M_MAX)


class CameraModel(Message):
    """A pinhole camera that looks level along base_link's x axis; focal length and principal point in pixels."""

    width_px: ImageSidePx
    height_px: ImageSidePx
    fx: float = Field(gt=0.0)
    fy: float = Field(gt=0.0)
    cx: float
    cy: float
    position_in_base: Point3D

    @property
    def hfov_rad(self) -> float:
        return 2.0 * math.atan(self.width_px / 2.0 / self.fx)


class RobotDescription(Message):
    """The footprint is a disc round base_link."""

    footprint_radius_m: float = Field(gt=0.0, le=2.0)
    speed_m_s_max: float = Field(gt=0.0, le=2.0)
    turn_rad_s_max: float = Field(gt=0.0, le=4.0)
    camera: CameraModel = Field(description="the colour camera, from its camera_info and tf")
    depth_noise: DepthNoise
