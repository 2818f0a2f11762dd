"""A bottle in a home that no weights were trained on, seen from the robot's camera, in any colour."""

import math
from dataclasses import dataclass, replace

from inference.ports import RgbImage
from sim.home import Home
from sim.home.model import Wanted
from sim.training.camera import HomeCamera
from sim.training.records import Box
from sim.training.views import FIELD_OF_VIEW_DEG, View
from sim.world.robot import CAMERA_Z_M

BEARINGS = 24
BORDER_PX = 8


@dataclass(frozen=True)
class BottleScene:
    """The same view of the same home, the bottle being of one colour or another."""

    home: Home
    bottle: str
    view: View
    box: Box

    def picture(self, colour: str) -> RgbImage:
        things = tuple(
            replace(thing, colour=colour) if thing.id == self.bottle else thing for thing in self.home.things
        )
        with HomeCamera(replace(self.home, things=things)) as camera:
            camera.boxes(self.view)
            return camera.picture().copy()


def bottle_scene(seed: int, distance_m: float = 1.0) -> BottleScene:
    """The home's red bottle from the first bearing from which it is seen whole, with no other bottle in the picture."""
    home = Home.generate(seed, wanted=Wanted("bottle", "red"))
    (bottle,) = (thing for thing in home.things if (thing.kind, thing.colour) == ("bottle", "red"))
    with HomeCamera(home) as camera:
        for step in range(BEARINGS):
            yaw = 2 * math.pi * step / BEARINGS
            x_m, y_m = bottle.x_m - distance_m * math.cos(yaw), bottle.y_m - distance_m * math.sin(yaw)
            if not any(room.contains(x_m, y_m) for room in home.rooms):
                continue
            view = View(x_m, y_m, CAMERA_Z_M, yaw, 0.0, 0.0, FIELD_OF_VIEW_DEG)
            bottles = [box for box in camera.boxes(view) if box.kind == "bottle"]
            if len(bottles) == 1 and bottles[0].thing == bottle.id and whole(bottles[0]):
                return BottleScene(home, bottle.id, view, bottles[0])
    raise LookupError(f"the red bottle of home {seed} is seen whole from nowhere at {distance_m} m")


def whole(box: Box) -> bool:
    inside = min(box.bbox_xyxy) > BORDER_PX and max(box.bbox_xyxy) < 250 - BORDER_PX
    filled = box.pixels / ((box.bbox_xyxy[2] - box.bbox_xyxy[0]) * (box.bbox_xyxy[3] - box.bbox_xyxy[1]))
    return inside and filled > 0.5
