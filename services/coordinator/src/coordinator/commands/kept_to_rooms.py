"""What a search that keeps to some rooms begins with: where they lie, and what memory knows of inside and outside."""

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from http import HTTPStatus

from contracts.geometry import Pose2D
from contracts.memory import RecalledView, RememberedObject
from contracts.mission import SearchedRoom, SeenElsewhere
from contracts.rooms import RoomGrid
from contracts.vision import Target
from coordinator.belief.clues import Clue
from coordinator.core.area import SearchArea
from coordinator.core.sightings import ELSEWHERE_MAX
from coordinator.coverage.areas import area_of
from coordinator.ports import Memory
from coordinator.questions.rooms_meant import KnownRooms
from coordinator.questions.tallies import THERE
from geometry.room_grids import decode
from mesh.errors import UpstreamError

THINGS_MAX = 200
PLACING_TASK = "plan-rooms"


@dataclass(frozen=True, slots=True)
class KeptRooms:
    """`area` is of the rooms that there are, as they are called now; `gone` are those the map shows no more."""

    area: SearchArea
    elsewhere: tuple[SeenElsewhere, ...]
    gone: tuple[SearchedRoom, ...] = ()


class NoSuchRoomsError(Exception):
    """The map the robot is in shows none of the rooms any more, or memory tells the rooms of another map."""


async def kept_to(
    rooms: Sequence[SearchedRoom], target: Target, memory: Memory, *, map_id: str | None = None
) -> KeptRooms:
    """`map_id` is of the map the robot is in; none where it has not been told.

    Raises `NoSuchRoomsError`, `RoomGridError`, `UnavailableError` and `UpstreamError`.
    """
    try:
        grid = await memory.room_grid()
    except UpstreamError as error:
        if error.upstream_status != HTTPStatus.NOT_FOUND:
            raise
        raise NoSuchRoomsError from error
    told = await memory.rooms()
    if told.map_id != grid.map_id or (map_id is not None and grid.map_id != map_id):
        raise NoSuchRoomsError
    known = KnownRooms(told.rooms)
    names = {one.id: one.name for one in known.rooms}
    named = [SearchedRoom(id=one.id, name=names[one.id]) for one in rooms if one.id in names]
    placing = asyncio.to_thread(_placed, grid, named)
    area = await asyncio.create_task(placing, name=PLACING_TASK)
    if area is None:
        raise NoSuchRoomsError
    things = await memory.objects(target.label, THINGS_MAX)
    shown = {one.id for one in area.rooms}
    gone = tuple(one for one in rooms if one.id not in shown)
    return KeptRooms(area, elsewhere(target, things, area, known), gone)


def _placed(grid: RoomGrid, rooms: Sequence[SearchedRoom]) -> SearchArea | None:
    """Raises `RoomGridError`. A large home takes a while: for a thread."""
    return area_of(decode(grid), rooms)


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
