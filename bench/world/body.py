"""The simulated robot's body, as robot_bridge describes it: for who needs it without a bridge that runs."""

from contracts.description import CameraModel, RobotDescription
from contracts.geometry import Point3D
from robot_bridge.settings import Settings
from sim.world.base import SPEED_MAX_M_S, TURN_MAX_RAD_S
from sim.world.robot import RGB_CAMERA, ROBOT_RADIUS_M

DESCRIPTION = RobotDescription(
    footprint_radius_m=ROBOT_RADIUS_M,
    speed_m_s_max=SPEED_MAX_M_S,
    turn_rad_s_max=TURN_MAX_RAD_S,
    camera=CameraModel(
        width_px=RGB_CAMERA.width_px, height_px=RGB_CAMERA.height_px,
        fx=RGB_CAMERA.fx, fy=RGB_CAMERA.fy, cx=RGB_CAMERA.cx, cy=RGB_CAMERA.cy,
        position_in_base=Point3D(x=RGB_CAMERA.x_m, y=0.0, z=RGB_CAMERA.z_m),
    ),
    depth_noise=Settings().depth_noise,
)  # fmt: skip
