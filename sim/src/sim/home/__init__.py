"""Seeded homes: pure data about rooms, furniture and things, and the MuJoCo model that shows them."""

from sim.home.home import Home, HomeFileError
from sim.home.mjcf import home_mjcf
from sim.home.model import Appearance, Dock, Door, Furniture, Room, Rug, Thing, Wall, Wanted

__all__ = [
    "Appearance", "Dock", "Door", "Furniture", "Home", "HomeFileError", "Room", "Rug", "Thing", "Wall", "Wanted",
    "home_mjcf",
]  # fmt: skip
