"""What a declared action that moves comes to: legs for the core, rooms looked up among memory's. Pure."""

from typing import assert_never

from contracts.actions import SPECS, ActionName, Drive, Explore, GoTo, LookAround, Patrol, Rotate, Undock
from contracts.intent import WantedAction
from contracts.mission import CommandRefusal
from contracts.rooms import NamedRoom
from coordinator.core.motions import GoToPlace, LookRound, Motion, Straight, Turn
from coordinator.questions.rooms_meant import KnownRooms
from mesh.errors import UnprocessableError
from vocabulary.rooms import called

Moving = GoTo | LookAround | Rotate | Drive | Explore | Patrol | Undock
ROOMS_TOLD = 8


def motion_of(action: Moving, rooms: KnownRooms) -> Motion:  # noqa: PLR0911 - one per action
    """Raises `UnprocessableError` for a room that nobody knows, or of which there are several (`code` says which)."""
    limit_s = SPECS[action.action].limit_s
    match action:
        case GoTo(room=str() as room):
            return way_to(one_room(room, rooms))
        case GoTo(x_m=float() as x, y_m=float() as y, yaw_rad=yaw):
            place = f"x {x:.1f} m, y {y:.1f} m"
            return Motion(f"to {place}", (GoToPlace(x, y, yaw, place),), WantedAction.GO, limit_s)
        case GoTo():
            raise ValueError("a thing is looked for: it is no plain motion")
        case LookAround():
            return Motion("once round, looking", (LookRound(),), limit_s=limit_s)
        case Rotate(angle_rad=angle):
            side = "left" if angle > 0.0 else "right"
            return Motion(f"turned {abs(angle):.2f} rad to the {side}", (Turn(angle),), limit_s=limit_s)
        case Drive(distance_m=distance):
            return Motion(f"driven {distance:.2f} m straight ahead", (Straight(distance),), limit_s=limit_s)
        case Explore():
            return Motion("looking at all of the map", limit_s=limit_s, explores=True)
        case Patrol(rooms=names):
            return _tour([one_room(name, rooms) for name in names], limit_s)
        case Undock():
            return Motion("off the dock", limit_s=limit_s)
        case _:
            assert_never(action)


def way_to(room: NamedRoom) -> Motion:
    """To its roomiest place."""
    return Motion(f"to {called(room.name)}", (_place(room),), WantedAction.GO, SPECS[ActionName.GO_TO].limit_s)


def one_room(said: str, rooms: KnownRooms) -> NamedRoom:
    """The room of exactly that name, else the only one of that kind."""
    exact = [one for one in rooms.rooms if one.name.casefold() == said.casefold()]
    some = exact[:1] if exact else list(rooms.meant(said))
    if len(some) == 1:
        return some[0]
    if some:
        names = " or ".join(called(one.name) for one in some[:ROOMS_TOLD])
        raise UnprocessableError(f"Which {said}: {names}?", code=CommandRefusal.WHICH_ROOM.value)
    known = ", ".join(called(one) for one in rooms.names[:ROOMS_TOLD])
    told = f"I know {known}" if known else "my map names no rooms yet"
    raise UnprocessableError(f"I know no room called '{said[:40]}': {told}", code=CommandRefusal.NO_ROOMS.value)


def _tour(rooms: list[NamedRoom], limit_s: float) -> Motion:
    legs = tuple(leg for room in rooms for leg in (_place(room, may_miss=True), LookRound()))
    return Motion(f"through {', '.join(called(one.name) for one in rooms)}", legs, limit_s=limit_s)


def _place(room: NamedRoom, *, may_miss: bool = False) -> GoToPlace:
    return GoToPlace(room.x, room.y, None, called(room.name), may_miss)
