"""What a search that keeps to some rooms begins with: where they lie, and what memory knows of inside and outside."""

from collections.abc import Sequence
from dataclasses import dataclass
from http import HTTPStatus

from contracts.geometry import Pose2D
from contracts.memory import RecalledView, RememberedObject
from contracts.mission import SearchedRoom, SeenElsewhere
from contracts.vision import Target
from coordinator.belief.clues import Clue
from coordinator.core.area import SearchArea
from coordinator.coverage.areas import area_of
from coordinator.ports import Memory
from coordinator.questions.rooms_meant import KnownRooms
from coordinator.questions.tallies import THERE
from geometry.room_grids import decode
from mesh.errors import UpstreamError

THINGS_MAX = 200
ELSEWHERE_MAX = 20


@dataclass(frozen=True, slots=True)
class KeptRooms:
    area: SearchArea
    elsewhere: tuple[SeenElsewhere, ...]


class NoSuchRoomsError(Exception):
    """The map the robot is in shows none of the rooms any more."""


async def kept_to(rooms: Sequence[SearchedRoom], target: Target, memory: Memory) -> KeptRooms:
    """Raises `NoSuchRoomsError`, `RoomGridError`, `UnavailableError` and `UpstreamError`."""
    try:
        area = area_of(decode(await memory.room_grid()), rooms)
    except UpstreamError as error:
        if error.upstream_status != HTTPStatus.NOT_FOUND:
            raise
        area = None
    if area is None:
        raise NoSuchRoomsError
    known = KnownRooms((await memory.rooms()).rooms)
    things = await memory.objects(target.label, THINGS_MAX)
    return KeptRooms(area, elsewhere(target, things, area, known))


def elsewhere(
    target: Target, things: Sequence[RememberedObject], area: SearchArea, known: KnownRooms
) -> tuple[SeenElsewhere, ...]:
    """What may be the target and is remembered to stand outside the area, newest first."""
    names = {one.id: one.name for one in known.rooms}
    outside = [
        one
        for one in things
        if target.may_be(one.label, one.colour)
        and one.state in THERE
        and not area.holds(one.position.x, one.position.y)
    ]
    return tuple(
        SeenElsewhere(
            label=one.label,
            colour=one.colour,
            room=names.get(one.room_id or 0, ""),
            place=Pose2D(x=one.position.x, y=one.position.y, yaw=0.0),
            stamp_s=one.last_seen_s,
        )
        for one in sorted(outside, key=lambda one: -one.last_seen_s)[:ELSEWHERE_MAX]
    )


def shows_inside(recalled: RecalledView, area: SearchArea) -> bool:
    """Whether what is to be seen from there is in the area: the thing itself, where its place is known."""
    if recalled.thing is not None:
        return area.holds(recalled.thing.position.x, recalled.thing.position.y)
    return area.is_near(recalled.pose or recalled.view.pose)


def clues_inside(clues: Sequence[Clue], area: SearchArea) -> tuple[Clue, ...]:
    """Where the thing itself may be, in the area alone; what stands near counts from wherever it is."""
    return tuple(one for one in clues if not one.itself or area.holds(one.x, one.y))
