"""From a home to a scene: the same home with the robot in it."""

from contracts.geometry import Pose2D
from sim.home import Home, home_mjcf
from sim.world.robot import ACTUATORS_XML, ROBOT_XML, SENSORS_XML, TIMESTEP_S
from sim.world.types import Scene, SceneThing


def scene_of(home: Home) -> Scene:
    """The home with the robot of `sim.world.robot`; things and furniture alike are what a mission may look for."""
    xml, assets = home_mjcf(
        home,
        robot_xml=ROBOT_XML,
        actuators=ACTUATORS_XML,
        sensors=SENSORS_XML,
        timestep_s=TIMESTEP_S,
        offscreen_px=(640, 400),
    )
    things = (SceneThing(thing.id, thing.kind, thing.colour or "") for thing in home.things)
    furniture = (SceneThing(piece.id, piece.kind, piece.colour or "", furniture=True) for piece in home.furniture)
    dock = Pose2D(x=home.dock.x_m, y=home.dock.y_m, yaw=home.dock.yaw)
    return Scene(xml, assets, dock, (*things, *furniture))
