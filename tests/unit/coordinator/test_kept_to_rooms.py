"""Which rooms a search keeps to when its turn comes: those of the map the robot is in, as they are called now."""

import threading

import pytest

from bench.map_likeness import home_grid
from contracts.mission import SearchedRoom
from contracts.rooms import NamedBy, NamedRoom
from coordinator.commands import kept_to_rooms
from coordinator.commands.kept_to_rooms import NoSuchRoomsError, kept_to
from coordinator.core.area import SearchArea
from geometry import room_grids
from geometry.room_grids import RoomCells
from geometry.rooms import rooms_of
from support.coordinator_world import FakeMemory
from support.mission_script import TARGET

CUT = rooms_of(home_grid(7021))
FIRST, SECOND = (one.number for one in CUT.rooms[:2])
ASKED = (SearchedRoom(id=FIRST, name="kitchen"), SearchedRoom(id=SECOND, name="bedroom"))


def memory_of(*, known: tuple[int, ...] = (FIRST, SECOND), lie: tuple[int, ...] = (FIRST, SECOND)) -> FakeMemory:
    memory = FakeMemory()
    memory.things = ()
    names = {FIRST: "kitchen", SECOND: "guest room"}
    memory.named_rooms = tuple(
        NamedRoom(
            id=one.number, name=names[one.number], named_by=NamedBy.PERSON, x=one.x_m, y=one.y_m, area_m2=one.area_m2
        )
        for one in CUT.rooms
        if one.number in known
    )
    memory.rooms_lie = room_grids.encode(CUT, {number: number for number in lie}, map_id="home")
    return memory


async def test_the_rooms_are_called_as_they_are_called_now() -> None:
    kept = await kept_to(ASKED, TARGET, memory_of(), map_id="home")
    assert [(one.id, one.name) for one in kept.area.rooms] == [(FIRST, "kitchen"), (SECOND, "guest room")]
    assert kept.gone == ()


@pytest.mark.parametrize("memory", [memory_of(lie=(FIRST,)), memory_of(known=(FIRST,))], ids=["no cells", "not known"])
async def test_a_room_that_the_map_shows_no_more_is_not_one_that_is_looked_in(memory: FakeMemory) -> None:
    kept = await kept_to(ASKED, TARGET, memory, map_id="home")
    assert [one.id for one in kept.area.rooms] == [FIRST]
    assert kept.area.called == "the kitchen"
    assert [one.name for one in kept.gone] == ["bedroom"]


@pytest.mark.parametrize("map_id", ["home", None])
async def test_where_no_room_is_left_it_looks_nowhere(map_id: str | None) -> None:
    with pytest.raises(NoSuchRoomsError):
        await kept_to(ASKED[1:], TARGET, memory_of(known=(FIRST,)), map_id=map_id)


async def test_rooms_of_another_map_than_the_robots_are_not_kept_to() -> None:
    with pytest.raises(NoSuchRoomsError):
        await kept_to(ASKED, TARGET, memory_of(), map_id="office")
    assert (await kept_to(ASKED, TARGET, memory_of(), map_id=None)).area.rooms


async def test_names_and_cells_of_two_maps_do_not_go_together() -> None:
    memory = memory_of()
    memory.rooms_lie = room_grids.encode(CUT, {FIRST: FIRST}, map_id="office")
    with pytest.raises(NoSuchRoomsError):
        await kept_to(ASKED, TARGET, memory, map_id="office")


async def test_the_cells_are_read_off_the_event_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    threads: list[int] = []
    area_of = kept_to_rooms.area_of

    def noting(cells: RoomCells, rooms: list[SearchedRoom]) -> SearchArea | None:
        threads.append(threading.get_ident())
        return area_of(cells, rooms)

    monkeypatch.setattr(kept_to_rooms, "area_of", noting)
    await kept_to(ASKED, TARGET, memory_of(), map_id="home")
    assert threads != [threading.get_ident()]
    assert len(threads) == 1
