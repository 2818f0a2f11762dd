"""Somebody was here: a home after a thing was carried elsewhere or taken away."""

from dataclasses import replace

import numpy as np

from sim.home.catalog import THINGS
from sim.home.floor import Floor
from sim.home.furnish import Furnishing
from sim.home.home import Home
from sim.home.layout import Layout
from sim.home.model import Room, Thing
from sim.home.placement import Placement, place_at

_TRIES = 60


class NoPlaceError(RuntimeError):
    """No other room has a place for the thing."""


def without(home: Home, thing_id: str) -> Home:
    return replace(home, things=tuple(thing for thing in home.things if thing.id != thing_id))


def with_thing(home: Home, moved: Thing) -> Home:
    """The thing of that id as it is given."""
    return replace(home, things=tuple(moved if thing.id == moved.id else thing for thing in home.things))


def room_of(home: Home, thing: Thing) -> Room | None:
    return next((room for room in home.rooms if room.contains(thing.x_m, thing.y_m)), None)


def carried_elsewhere(home: Home, thing_id: str, rng: np.random.Generator) -> Thing:
    """The thing in another room, where such a thing may stand. Raises `NoPlaceError`."""
    thing = next(thing for thing in home.things if thing.id == thing_id)
    entry, room, rest = THINGS[thing.kind], room_of(home, thing), without(home, thing_id)
    for _ in range(_TRIES):
        state = _placement(rest, rng)
        place = entry.places[int(rng.integers(len(entry.places)))]
        if place_at(state, entry, replace(thing, z_m=0.0, support="floor"), place):
            moved = state.things[-1]
            if room_of(home, moved) not in {room, None}:
                return moved
    raise NoPlaceError(f"{thing_id} of home {home.seed} finds no place in another room")


def _placement(home: Home, rng: np.random.Generator) -> Placement:
    """The home as the generator would go on placing things in it."""
    layout = Layout(home.width_m, home.depth_m, home.rooms, home.walls, home.doors, home.dock)
    floor = Floor(layout)
    for piece in home.furniture:
        floor.occupied |= floor.footprint(piece.x_m, piece.y_m, piece.yaw, piece.size_m[0], piece.size_m[1])
    furnishing = Furnishing(layout, rng, floor, pieces=list(home.furniture))
    furnishing.tv_cabinet = next((thing.support for thing in home.things if thing.kind == "tv"), None)
    state = Placement(furnishing, rng)
    for thing in home.things:
        state.things.append(thing)
        if thing.support == "floor":
            side = max(thing.size_m[:2])
            floor.occupied |= floor.footprint(thing.x_m, thing.y_m, 0.0, side, side)
    standing = floor.standing()
    state.standing = standing if standing is not None else state.standing
    return state
