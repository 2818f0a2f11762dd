"""The TurtleBot4 Lite as MuJoCo sees it: Create 3 base, lidar, camera on its bracket; sizes in m, masses in kg.

Where the sensors sit is what turtlebot4_description 2.1.1 says of the Lite (`urdf/lite/turtlebot4.urdf.xacro`), whose
base_link is on the floor: the camera looks out over the lidar and sees a little of the base's front edge.
"""

import math

from contracts.geometry import Pose2D
from sim.world.types import CameraModel

WHEEL_RADIUS_M = 0.036
WHEEL_BASE_M = 0.233
BODY_RADIUS_M = 0.171
ROBOT_RADIUS_M = 0.189
"""Of its footprint, as Nav2 and robot_bridge are told it: the body and what stands out from it."""
CAMERA_X_M, CAMERA_Z_M = -0.037, 0.186
LIDAR = Pose2D(x=0.004, y=0.0, yaw=math.pi / 2)
"""Of `rplidar_link` in base_link: the Lite's lidar is mounted a quarter turn to the left."""
LIDAR_Z_M = 0.140
RGB_SIZE_PX = 250
RGB_FOV_RAD = math.radians(54.0)
DEPTH_WIDTH_PX, DEPTH_HEIGHT_PX = 640, 400
DEPTH_HORIZONTAL_FOV_RAD = math.radians(72.0)

ROBOT_BODY = "base_link"
TIMESTEP_S = 0.005


def _pinhole(width_px: int, height_px: int, horizontal_fov_rad: float) -> CameraModel:
    focal = width_px / (2 * math.tan(horizontal_fov_rad / 2))
    return CameraModel(width_px, height_px, focal, focal, width_px / 2, height_px / 2, CAMERA_X_M, CAMERA_Z_M)


RGB_CAMERA = _pinhole(RGB_SIZE_PX, RGB_SIZE_PX, RGB_FOV_RAD)
DEPTH_CAMERA = _pinhole(DEPTH_WIDTH_PX, DEPTH_HEIGHT_PX, DEPTH_HORIZONTAL_FOV_RAD)


def vertical_fov_deg(camera: CameraModel) -> float:
    """MuJoCo's `fovy` of a camera, degrees."""
    return math.degrees(2 * math.atan(camera.height_px / (2 * camera.fy)))


def _wheel(side: str, y_m: float) -> str:
    return f"""
    <body name="wheel_{side}" pos="0 {y_m} {WHEEL_RADIUS_M}">
      <joint name="wheel_{side}" type="hinge" axis="0 1 0" damping="0.002" armature="0.01"/>
      <geom type="cylinder" size="{WHEEL_RADIUS_M} 0.01" quat="0.7071068 0.7071068 0 0" mass="0.2"
            friction="1 0.01 0.001" rgba="0.05 0.05 0.05 1"/>
    </body>"""


def _caster(x_m: float) -> str:
    return (
        f'<geom type="sphere" pos="{x_m} 0 0.0125" size="0.0125" condim="1" priority="1" mass="0" '
        'rgba="0.2 0.2 0.2 1"/>'
    )


def _camera(name: str, camera: CameraModel) -> str:
    return (
        f'<camera name="{name}" pos="{camera.x_m} 0 {camera.z_m}" xyaxes="0 -1 0 0 0 1" '
        f'fovy="{vertical_fov_deg(camera):.6f}"/>'
    )


SHELL_XML = f"""
<geom name="bumper" type="cylinder" pos="0 0 0.055" size="{BODY_RADIUS_M} 0.037" rgba="0.10 0.10 0.10 1" mass="0"/>
<geom name="lidar" type="cylinder" pos="{LIDAR.x} 0 0.1195" size="0.038 0.0275" rgba="0.08 0.08 0.08 1" mass="0"/>
<geom name="bracket" type="box" pos="-0.09 0 0.137" size="0.004 0.02 0.045" rgba="0.12 0.12 0.12 1" mass="0"/>
<geom name="arm" type="box" pos="-0.073 0 0.186" size="0.017 0.01 0.004" rgba="0.12 0.12 0.12 1" mass="0"/>
<geom name="camera" type="box" pos="{CAMERA_X_M - 0.01} 0 {CAMERA_Z_M}" size="0.009 0.045 0.014"
      rgba="0.12 0.12 0.12 1" mass="0"/>"""
"""What of the robot can be seen, in base_link; also in the pictures that the detector learns from."""

ROBOT_XML = f"""
<body name="{ROBOT_BODY}" pos="0 0 0">
  <freejoint name="base"/>
  <inertial pos="0 0 0.06" mass="3.3" diaginertia="0.03 0.03 0.05"/>
  {SHELL_XML}
  {_caster(0.13)}{_caster(-0.13)}
  {_wheel("left", WHEEL_BASE_M / 2)}{_wheel("right", -WHEEL_BASE_M / 2)}
  <site name="lidar" pos="{LIDAR.x} 0 {LIDAR_Z_M}" euler="0 0 {LIDAR.yaw}"/>
  <site name="imu" pos="0 0 0.06"/>
  {_camera("rgb", RGB_CAMERA)}{_camera("depth", DEPTH_CAMERA)}
</body>"""
"""The robot's body, for a `<worldbody>`."""

ACTUATORS_XML = """
<velocity name="wheel_left" joint="wheel_left" kv="1" forcerange="-1.5 1.5"/>
<velocity name="wheel_right" joint="wheel_right" kv="1" forcerange="-1.5 1.5"/>"""
"""For `<actuator>`: wheel speeds in rad/s. kv and armature belong together: with a stiffer servo on a lighter wheel the
body outruns its wheels by 6 cm/s while it speeds up."""

SENSORS_XML = '<gyro name="gyro" site="imu"/><accelerometer name="accelerometer" site="imu"/>'
"""For `<sensor>`."""
