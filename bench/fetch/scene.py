"""A bare floor with the robot, and before it one thing that can be taken, with its mass and friction."""

import math
from dataclasses import dataclass
from typing import Final

from contracts.geometry import Pose2D
from grasping.things import MeasuredThing
from sim.world import Scene, SceneThing
from sim.world.robot import ACTUATORS_XML, ROBOT_XML, SENSORS_XML, TIMESTEP_S

THING: Final = "thing"
STANCE: Final = Pose2D(x=0.0, y=0.0, yaw=0.0)


@dataclass(frozen=True, slots=True)
class ThingKind:
    """Sizes in m: a cylinder where length and width are the same and it is `round`, else a box."""

    label: str
    length_m: float
    width_m: float
    height_m: float
    mass_kg: float
    friction: float = 1.0
    round: bool = True


KINDS: Final[dict[str, ThingKind]] = {
    "bottle": ThingKind("bottle", 0.066, 0.066, 0.20, 0.30),
    "small bottle": ThingKind("bottle", 0.055, 0.055, 0.15, 0.20),
    "thin bottle": ThingKind("bottle", 0.045, 0.045, 0.18, 0.15),
    "cup": ThingKind("cup", 0.070, 0.070, 0.10, 0.15),
    "carton": ThingKind("carton", 0.055, 0.040, 0.14, 0.12, round=False),
    "ball": ThingKind("sports ball", 0.060, 0.060, 0.06, 0.06),
}
PLACES: Final[dict[str, float]] = {"floor": 0.0, "step": 0.10, "low table": 0.20}
"""How high the thing stands, m."""


@dataclass(frozen=True, slots=True)
class Setting:
    """A thing before the robot: its middle so far ahead and to the left of base_link, turned."""

    kind: str
    place: str
    ahead_m: float
    left_m: float
    yaw_rad: float = 0.0

    @property
    def thing(self) -> MeasuredThing:
        """As it truly stands, in base_link of the robot at `STANCE`."""
        one = KINDS[self.kind]
        z_m = PLACES[self.place] + one.height_m / 2
        return MeasuredThing(
            self.ahead_m, self.left_m, z_m, one.length_m, one.width_m, one.height_m, self.yaw_rad, one.round
        )


def scene_of(setting: Setting) -> Scene:
    """Contacts as they hold a thing: docs/arm.md."""
    one, thing = KINDS[setting.kind], setting.thing
    shape, size = ("cylinder", f"{one.length_m / 2} {one.height_m / 2}") if one.round else (
        "box", f"{one.length_m / 2} {one.width_m / 2} {one.height_m / 2}"
    )  # fmt: skip
    if setting.kind == "ball":
        shape, size = "sphere", f"{one.length_m / 2}"
    top_m = PLACES[setting.place]
    table = (
        f'<body name="table" pos="{setting.ahead_m + 0.14} {setting.left_m} {top_m / 2}">'
        f'<geom type="box" size="0.2 0.3 {top_m / 2}"/></body>'
        if top_m > 0.0
        else ""
    )
    xml = f"""
<mujoco>
  <compiler angle="radian"/>
  <option timestep="{TIMESTEP_S}"/>
  <visual><global offwidth="640" offheight="400"/><map znear="0.003" zfar="3"/></visual>
  <worldbody>
    <light directional="true" dir="0.3 0.3 -1" castshadow="false"/>
    <geom name="floor" type="plane" size="10 10 .1" rgba=".6 .5 .4 1"/>
    {table}
    <body name="{THING}" pos="{thing.x_m} {thing.y_m} {thing.z_m + 0.001}" euler="0 0 {thing.yaw_rad}">
      <freejoint/>
      <geom type="{shape}" size="{size}" mass="{one.mass_kg}" rgba=".8 .1 .1 1" condim="4" priority="1"
        friction="{one.friction} 0.01 0.0005" solref="0.01 1" solimp="0.95 0.99 0.001"/>
    </body>
    {ROBOT_XML}
  </worldbody>
  <actuator>{ACTUATORS_XML}</actuator>
  <sensor>{SENSORS_XML}</sensor>
</mujoco>"""
    dock = Pose2D(x=-3.0, y=0.0, yaw=math.pi)
    return Scene(xml, {}, dock, (SceneThing(THING, one.label, "red"),))
