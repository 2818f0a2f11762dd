"""The body of the robot that most tests are about: the one the simulator has."""

from contracts.description import CameraModel, DepthNoise, RobotDescription
from contracts.geometry import Point3D
from contracts.topics import ROBOT_DESCRIPTION
from support.bus import MemoryBus

NOISE = DepthNoise(at_1m_m=0.012, exponent=3.461)
DESCRIPTION = RobotDescription(
    footprint_radius_m=0.189,
    speed_m_s_max=0.306,
    turn_rad_s_max=1.9,
    camera=CameraModel(
        width_px=320, height_px=320, fx=314.0, fy=314.0, cx=160.0, cy=160.0,
        position_in_base=Point3D(x=0.06, y=0.0, z=0.244),
    ),
    depth_noise=NOISE,
)  # fmt: skip


def described_bus() -> MemoryBus:
    """One on which the bridge has told of its robot."""
    bus = MemoryBus()
    bus.keep(ROBOT_DESCRIPTION, DESCRIPTION)
    return bus
