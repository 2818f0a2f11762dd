"""Rooms on the page: their part of the scene, and a name that a person gives one."""

import threading

import httpx
import pytest

from contracts.rooms import NamedBy, NamedRoom, RoomGrid
from geometry import room_grids
from geometry.grids import decode
from geometry.rooms import rooms_of
from support.fake_clock import FakeClock
from support.ui_world import UiWorld, home_map
from ui import rooms_layer
from ui.desk import Desk
from ui.operator_actions import ActionResult
from ui.settings import Settings


def with_rooms(world: UiWorld) -> None:
    cut = rooms_of(decode(home_map()))
    world.memory.rooms_of = "home"
    world.memory.named_rooms = [
        NamedRoom(id=r.number, name=f"unnamed room {r.number}", named_by=NamedBy.NOBODY, x=r.x_m, y=r.y_m,
                  area_m2=r.area_m2)
        for r in cut.rooms
    ]  # fmt: skip
    world.memory.rooms_lie = room_grids.encode(cut, {r.number: r.number for r in cut.rooms}, map_id="home")


def desk_of(world: UiWorld) -> Desk:
    return Desk(
        settings=Settings(), bus=world.bus, robot=world.robot, inference=world.inference.client(),
        missions=world.missions, memory=world.memory, clock=FakeClock(),
    )  # fmt: skip


async def named(client: httpx.AsyncClient, number: int, name: str) -> ActionResult:
    answer = await client.put(f"/rooms/{number}/name", json={"name": name})
    assert answer.status_code == 200, answer.text
    return ActionResult(**answer.json())


async def test_a_name_goes_to_memory_and_comes_back_to_the_page(client: httpx.AsyncClient, world: UiWorld) -> None:
    with_rooms(world)
    assert await named(client, 2, "Anna's room") == ActionResult(True, "It is called Anna's room now.")
    assert [(one.name, one.named_by) for one in world.memory.named_rooms[1:2]] == [("Anna's room", NamedBy.PERSON)]
    assert (await named(client, 2, "")).text == "It is called unnamed room 2 now."


async def test_a_refusal_is_told_in_memorys_words(client: httpx.AsyncClient, world: UiWorld) -> None:
    with_rooms(world)
    assert await named(client, 99, "attic") == ActionResult(False, "the map has no room 99")


@pytest.mark.parametrize("name", ["x" * 41, "a\nb"])
async def test_what_is_no_name_is_refused_before_anybody_is_asked(
    client: httpx.AsyncClient, world: UiWorld, name: str
) -> None:
    with_rooms(world)
    assert (await client.put("/rooms/1/name", json={"name": name})).status_code == 422
    assert world.memory.named_rooms[0].named_by is NamedBy.NOBODY


async def test_where_rooms_lie_is_asked_for_once_and_again_when_they_are_others(world: UiWorld) -> None:
    with_rooms(world)
    desk = desk_of(world)
    await desk.refresh_rooms(now=True)
    await desk.refresh_rooms(now=True)
    assert world.memory.grids_asked == 1
    first = world.memory.named_rooms[0]
    world.memory.named_rooms[0] = first.model_copy(update={"name": "den", "named_by": NamedBy.PERSON})
    await desk.refresh_rooms(now=True)
    assert (desk.facts.rooms.names[first.id], world.memory.grids_asked) == ("den", 1)
    world.memory.named_rooms[0] = first.model_copy(update={"area_m2": first.area_m2 + 1.0})
    await desk.refresh_rooms(now=True)
    assert world.memory.grids_asked == 2


async def test_a_memory_that_knows_no_rooms_leaves_none_on_the_page(world: UiWorld) -> None:
    with_rooms(world)
    desk = desk_of(world)
    await desk.refresh_rooms(now=True)
    world.memory.rooms_of, world.memory.named_rooms = "", []
    await desk.refresh_rooms(now=True)
    assert (desk.facts.rooms.rooms, desk.facts.rooms.grid) == ((), None)


async def test_rooms_are_drawn_off_the_event_loop_and_only_where_they_lie_otherwise(
    world: UiWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    with_rooms(world)
    threads: list[int] = []
    draws = rooms_layer.picture

    def noting(grid: RoomGrid) -> str | None:
        threads.append(threading.get_ident())
        return draws(grid)

    monkeypatch.setattr(rooms_layer, "picture", noting)
    desk = desk_of(world)
    await desk.refresh_rooms(now=True)
    first = desk.facts.rooms.picture
    assert first is not None
    world.memory.named_rooms[0] = world.memory.named_rooms[0].model_copy(update={"name": "Anna's room"})
    await desk.refresh_rooms(now=True)
    assert desk.facts.rooms.rooms[0].name == "Anna's room"
    assert desk.facts.rooms.picture is first
    assert len(threads) == 1
    assert threads != [threading.get_ident()]
