"""What a declared action that moves comes to: legs for the core, rooms looked up among memory's. Pure."""

from typing import assert_never

from contracts.actions import (
    SPECS,
    ActionName,
    DriveAction,
    ExploreAction,
    GoToAction,
    LookAroundAction,
    PatrolAction,
    RotateAction,
    UndockAction,
)
from contracts.intent import WantedAction
from contracts.mission import CommandRefusal
from contracts.rooms import NamedRoom
from coordinator.core.motions import PlaceLeg, PlainMotion, RoundLeg, StraightLeg, TurnLeg
from coordinator.questions.rooms_meant import KnownRooms
from mesh.errors import UnprocessableError
from vocabulary.rooms import called

Moving = GoToAction | LookAroundAction | RotateAction | DriveAction | ExploreAction | PatrolAction | UndockAction
ROOMS_TOLD = 8


def motion_of(action: Moving, rooms: KnownRooms) -> PlainMotion:  # noqa: PLR0911 - one per action
    """Raises `UnprocessableError` for a room that nobody knows, or of which there are several (`code` says which)."""
    limit_s = SPECS[action.action].limit_s
    match action:
        case GoToAction(room=str() as room):
            return way_to(one_room(room, rooms))
        case GoToAction(x_m=float() as x, y_m=float() as y, yaw_rad=yaw):
            place = f"x {x:.1f} m, y {y:.1f} m"
            return PlainMotion(f"to {place}", (PlaceLeg(x, y, yaw, place),), WantedAction.GO, limit_s)
        case GoToAction():
            raise ValueError("a thing is looked for: it is no plain motion")
        case LookAroundAction():
            return PlainMotion("once round, looking", (RoundLeg(),), limit_s=limit_s)
        case RotateAction(angle_rad=angle):
            side = "left" if angle > 0.0 else "right"
            return PlainMotion(f"turned {abs(angle):.2f} rad to the {side}", (TurnLeg(angle),), limit_s=limit_s)
        case DriveAction(distance_m=distance):
            return PlainMotion(f"driven {distance:.2f} m straight ahead", (StraightLeg(distance),), limit_s=limit_s)
        case ExploreAction(duration_s=duration_s):
            what = "exploring what the map does not show yet"
            return PlainMotion(what, limit_s=limit_s, explores=True, explore_s=duration_s)
        case PatrolAction(rooms=names):
            return _tour([one_room(name, rooms) for name in names], limit_s)
        case UndockAction():
            return PlainMotion("off the dock", limit_s=limit_s)
        case _:
            assert_never(action)


def way_to(room: NamedRoom) -> PlainMotion:
    """To its roomiest place."""
    return PlainMotion(f"to {called(room.name)}", (_place(room),), WantedAction.GO, SPECS[ActionName.GO_TO].limit_s)


def one_room(name: str, rooms: KnownRooms) -> NamedRoom:
    """The room of exactly that name, else the only one of that kind."""
    exact = [one for one in rooms.rooms if one.name.casefold() == name.casefold()]
    return exact[0] if exact else one_room_meant(name, rooms)


def one_room_meant(said: str, rooms: KnownRooms) -> NamedRoom:
    """Of what a person says: where there are 'bedroom' and 'bedroom 2', 'the bedroom' may be either."""
    some = list(rooms.meant(said))
    if len(some) == 1:
        return some[0]
    if some:
        names = " or ".join(called(one.name) for one in some[:ROOMS_TOLD])
        raise UnprocessableError(f"Which {said}: {names}?", code=CommandRefusal.WHICH_ROOM.value)
    known = ", ".join(called(one) for one in rooms.names[:ROOMS_TOLD])
    told = f"I know {known}" if known else "my map names no rooms yet"
    raise UnprocessableError(f"I know no room called '{said[:40]}': {told}", code=CommandRefusal.NO_ROOMS.value)


def _tour(rooms: list[NamedRoom], limit_s: float) -> PlainMotion:
    legs = tuple(leg for room in rooms for leg in (_place(room, may_miss=True), RoundLeg()))
    return PlainMotion(f"through {', '.join(called(one.name) for one in rooms)}", legs, limit_s=limit_s)


def _place(room: NamedRoom, *, may_miss: bool = False) -> PlaceLeg:
    return PlaceLeg(room.x, room.y, None, called(room.name), may_miss)
