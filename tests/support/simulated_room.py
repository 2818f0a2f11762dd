"""One bare room of 6 m x 4 m with two bottles, a cup on a table and a shelf, as small as a scene can be."""

import math

from contracts.geometry import Pose2D
from sim.world import Scene, SceneThing, World, WorldOptions
from sim.world.robot import ACTUATORS_XML, ROBOT_XML, SENSORS_XML, TIMESTEP_S

WIDTH_M, DEPTH_M = 6.0, 4.0
DOCK = Pose2D(x=0.5, y=2.0, yaw=math.pi)
MIDDLE = Pose2D(x=2.0, y=2.0, yaw=0.0)
PERFECT = WorldOptions(noise_free=True)


def _wall(name: str, x: float, y: float, half_x: float, half_y: float) -> str:
    return f'<geom name="{name}" type="box" pos="{x} {y} 1.2" size="{half_x} {half_y} 1.2" rgba=".9 .9 .9 1"/>'


def _bottle(name: str, x: float, y: float, rgba: str) -> str:
    return f"""<body name="{name}" pos="{x} {y} 0">
      <geom type="cylinder" pos="0 0 0.15" size="0.04 0.15" rgba="{rgba}"/></body>"""


ROOM = f"""
<mujoco>
  <compiler angle="radian"/>
  <option timestep="{TIMESTEP_S}" integrator="implicitfast"/>
  <statistic center="3 2 1" extent="8"/>
  <visual><global offwidth="640" offheight="400"/><map znear="0.003" zfar="3"/></visual>
  <worldbody>
    <light directional="true" dir="0.3 0.3 -1" castshadow="false"/>
    <geom name="floor" type="plane" size="10 10 .1" rgba=".6 .5 .4 1"/>
    {_wall("west", -0.05, 2, 0.05, 2.1)}{_wall("east", 6.05, 2, 0.05, 2.1)}
    {_wall("south", 3, -0.05, 3.1, 0.05)}{_wall("north", 3, 4.05, 3.1, 0.05)}
    <geom name="rug" type="box" pos="3 2 0.002" size="0.5 0.5 0.002" contype="0" conaffinity="0"/>
    {_bottle("bottle_red", 4.5, 3.0, ".8 .1 .1 1")}
    {_bottle("bottle_blue", 4.5, 1.0, ".1 .1 .8 1")}
    <body name="table" pos="1.5 3.5 0">
      <geom type="box" pos="0 0 0.43" size="0.6 0.4 0.02"/>
      <geom type="box" pos="-0.5 0 0.205" size="0.03 0.38 0.205"/>
      <geom type="box" pos="0.5 0 0.205" size="0.03 0.38 0.205"/>
      <geom type="box" pos="0 0.3 0.205" size="0.48 0.02 0.205"/>
    </body>
    <body name="cup_white" pos="1.5 3.6 0.45"><geom type="cylinder" pos="0 0 0.05" size="0.04 0.05"/></body>
    <body name="cupboard" pos="5.6 0.4 0"><geom type="box" pos="0 0 0.5" size="0.3 0.3 0.5"/></body>
    {ROBOT_XML}
  </worldbody>
  <actuator>{ACTUATORS_XML}</actuator>
  <sensor>{SENSORS_XML}</sensor>
</mujoco>"""

SCENE = Scene(
    ROOM,
    {},
    DOCK,
    (
        SceneThing("bottle_red", "bottle", "red"),
        SceneThing("bottle_blue", "bottle", "blue"),
        SceneThing("cup_white", "cup", "white"),
        SceneThing("table", "dining table", furniture=True),
    ),
)


def world_at(pose: Pose2D = MIDDLE, *, seed: int = 0, options: WorldOptions = PERFECT) -> World:
    """The room with the robot at a pose; every sensor true unless told otherwise."""
    return World(SCENE, seed=seed, start=pose, options=options)


def drive(world: World, linear_x: float, angular_z: float, seconds: float, *, behaviour: bool = False) -> None:
    """Commands at 20 Hz, as the arbiter sends them."""
    for _ in range(round(seconds * 20)):
        world.command(linear_x, angular_z, behaviour=behaviour)
        world.advance(0.05)
