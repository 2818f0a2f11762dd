"""The rooms of the map the robot is in, by name: through the front door."""

import asyncio
import threading
from collections.abc import AsyncIterator, Iterator
from dataclasses import replace

import numpy as np
import pytest

from contracts.geometry import Pose2D
from contracts.memory import RememberedObject
from contracts.rooms import NamedBy, NamedRoom, RoomGrid, RoomsReply
from geometry import room_grids
from geometry.grids import OCCUPIED, OccupancyGrid
from geometry.rooms import Rooms, rooms_of
from memory.app import create_app
from memory.ports import KeptMap, KeptRoom
from memory.room_book import RoomBook
from memory.settings import Settings
from memory.whereabouts import Whereabouts
from mesh.errors import ConflictError
from mesh.http import ServiceClient
from store.shared_lock import SharedLock
from support.bus import MemoryBus
from support.fake_clock import FakeClock
from support.fake_senses import FakeSenses
from support.memory_store import FakeStore
from support.observations import seen

from .conftest import served


def three_rooms(*, shifted_cells: int = 0) -> OccupancyGrid:
    """12 x 4 m: three rooms in a row, their middles at 2, 6 and 10 m. Shifted: the same, saved with a margin."""
    cells = np.zeros((80, 240), np.int8)
    cells[:2] = cells[-2:] = cells[:, :2] = cells[:, -2:] = OCCUPIED
    for wall in (80, 160):
        cells[:, wall : wall + 2] = OCCUPIED
        cells[30:48, wall : wall + 2] = 0
    cells = np.pad(cells, shifted_cells, constant_values=-1)
    corner = -0.05 * shifted_cells
    return OccupancyGrid(cells, 0.05, Pose2D(x=corner, y=corner, yaw=0.0))


def without_the_last_room() -> OccupancyGrid:
    grid = three_rooms()
    return OccupancyGrid(grid.cells[:, :162], grid.resolution_m, grid.origin)


@pytest.fixture
def senses() -> FakeSenses:
    return FakeSenses(ground=three_rooms())


@pytest.fixture
async def client(senses: FakeSenses, store: FakeStore) -> AsyncIterator[ServiceClient]:
    async with served(create_app(Settings(), bus=MemoryBus(), store=store, senses=senses)) as client:
        yield client


async def remember(client: ServiceClient, **things: float) -> None:
    """Each label at this x, in the middle of the home's depth."""
    batch = [seen(label, x=x - 1.0, y=2.0, at=(x, 2.0)).model_dump() for label, x in things.items()]
    assert (await client.http.post("/observations", json={"observations": batch})).status_code == 200


async def things(client: ServiceClient, asked: str = "") -> list[RememberedObject]:
    answer = (await client.http.get(f"/objects{asked}")).raise_for_status()
    told = [RememberedObject.model_validate(one) for one in answer.json()]
    assert told
    return told


async def named(client: ServiceClient, path: str, body: dict[str, str]) -> NamedRoom:
    return NamedRoom.model_validate((await client.http.put(path, json=body)).raise_for_status().json())


async def rooms(client: ServiceClient) -> dict[int, NamedRoom]:
    """By the metres of their middle along x."""
    return {round(one.x): one for one in (await client.get("/rooms", RoomsReply)).rooms}


async def test_rooms_are_named_by_what_stands_there_and_nothing_is_claimed_of_others(client: ServiceClient) -> None:
    await remember(client, refrigerator=1.5, oven=2.5, bed=6.0, chair=10.0)
    found = await rooms(client)
    assert [(one.named_by, one.kind) for one in (found[2], found[6], found[10])] == [
        (NamedBy.CONTENTS, "kitchen"),
        (NamedBy.CONTENTS, "bedroom"),
        (NamedBy.NOBODY, None),
    ]
    assert found[10].name.startswith("unnamed room ")
    assert found[2].labels == ("oven", "refrigerator")


async def test_a_name_given_by_a_person_is_kept_over_a_map_saved_anew_and_a_restart(
    client: ServiceClient, senses: FakeSenses, store: FakeStore
) -> None:
    await remember(client, bed=6.0)
    number = (await rooms(client))[6].id
    told = await named(client, f"/rooms/{number}/name", {"name": "  Anna's room "})
    assert (told.name, told.named_by, told.kind) == ("Anna's room", NamedBy.PERSON, "bedroom")
    senses.map = three_rooms(shifted_cells=7)
    async with served(create_app(Settings(), bus=MemoryBus(), store=store, senses=senses)) as again:
        after = await rooms(again)
    assert (after[6].id, after[6].name) == (number, "Anna's room")
    assert len(after) == 3


async def test_an_empty_name_takes_the_persons_name_away(client: ServiceClient) -> None:
    number = (await rooms(client))[6].id
    await named(client, f"/rooms/{number}/name", {"name": "den"})
    plain = await named(client, f"/rooms/{number}/name", {"name": " "})
    assert plain.named_by is NamedBy.NOBODY


async def test_two_rooms_never_bear_one_name(client: ServiceClient) -> None:
    await remember(client, oven=2.0, bed=6.0, toilet=10.0)
    found = await rooms(client)
    await named(client, f"/rooms/{found[6].id}/name", {"name": "Kitchen"})
    refused = await client.http.put(f"/rooms/{found[10].id}/name", json={"name": "kitchen"})
    assert refused.status_code == 409
    names = [one.name.casefold() for one in (await rooms(client)).values()]
    assert len(set(names)) == 3


@pytest.mark.parametrize(("number", "body", "status"), [
    (99, {"name": "den"}, 404), (0, {"name": "den"}, 422), (1, {"name": "x" * 41}, 422), (1, {"name": "a\nb"}, 422),
    (1, {}, 422), (1, {"name": "Unnamed  room 3"}, 422),
])  # fmt: skip
async def test_what_cannot_be_named_is_refused(
    client: ServiceClient, number: int, body: dict[str, str], status: int
) -> None:
    await rooms(client)
    assert (await client.http.put(f"/rooms/{number}/name", json=body)).status_code == status


async def test_things_know_their_room_and_are_asked_for_by_it(client: ServiceClient) -> None:
    await remember(client, cup=2.0, book=6.0)
    found = await rooms(client)
    told = [RememberedObject.model_validate(one) for one in (await client.http.get("/objects")).json()]
    assert {one.label: one.room_id for one in told} == {"cup": found[2].id, "book": found[6].id}
    there = (await client.http.get(f"/objects?room={found[6].id}")).json()
    assert [one["label"] for one in there] == ["book"]
    assert (await client.http.get(f"/objects?room={found[10].id}")).json() == []


async def test_without_a_map_there_are_no_rooms(store: FakeStore) -> None:
    async with served(create_app(Settings(), bus=MemoryBus(), store=store, senses=FakeSenses())) as client:
        assert (await client.get("/rooms", RoomsReply)).rooms == ()


def many_rooms() -> OccupancyGrid:
    """14 x 15 closed rooms of 2 m."""
    cells = np.zeros((14 * 40 + 2, 15 * 40 + 2), np.int8)
    for k in (0, 1):
        cells[k::40] = cells[:, k::40] = OCCUPIED
    return OccupancyGrid(cells, 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0))


async def test_of_more_rooms_than_a_reply_holds_the_largest_are_told(client: ServiceClient, senses: FakeSenses) -> None:
    senses.map = many_rooms()
    told = (await client.get("/rooms", RoomsReply)).rooms
    assert len(told) == 200
    hidden = next(iter(set(range(1, 211)) - {one.id for one in told}))
    refused = await client.http.put(f"/rooms/{hidden}/name", json={"name": "den"})
    assert refused.status_code == 404
    assert "den" not in {one.name for one in (await client.get("/rooms", RoomsReply)).rooms}
    assert (await named(client, f"/rooms/{told[7].id}/name", {"name": "den"})).name == "den"


class SlowCut:
    """Cuts a map when it is let."""

    def __init__(self) -> None:
        self.times = 0
        self.begun, self.may = threading.Event(), threading.Event()

    def __call__(self, grid: OccupancyGrid) -> Rooms:
        self.times += 1
        self.begun.set()
        self.may.wait()
        return rooms_of(grid)


@pytest.fixture
def slow_cut(monkeypatch: pytest.MonkeyPatch) -> Iterator[SlowCut]:
    cut = SlowCut()
    monkeypatch.setattr("memory.room_book.rooms_of", cut)
    yield cut
    cut.may.set()


async def test_things_are_told_without_rooms_while_the_map_is_cut(
    client: ServiceClient, senses: FakeSenses, slow_cut: SlowCut, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("memory.room_book.CUT_S_MAX", 0.0)
    await remember(client, cup=2.0)
    assert {one.room_id for one in await things(client)} == {None}
    assert (await client.http.get("/rooms")).status_code == 503
    assert (await client.http.get("/objects?room=1")).status_code == 503
    await asyncio.to_thread(slow_cut.begun.wait)
    senses.map = three_rooms()
    assert {one.room_id for one in await things(client)} == {None}
    assert slow_cut.times == 1, "one map at a time"
    slow_cut.may.set()
    monkeypatch.undo()
    number = (await rooms(client))[2].id
    assert {one.room_id for one in await things(client)} == {number}
    assert {one.room_id for one in await things(client, f"?room={number}")} == {number}


async def test_things_are_told_without_rooms_where_the_map_cannot_be_cut(
    client: ServiceClient, senses: FakeSenses, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(grid: OccupancyGrid) -> Rooms:
        raise MemoryError

    with monkeypatch.context() as broken:
        broken.setattr("memory.room_book.rooms_of", fail)
        await remember(client, cup=2.0)
        assert (await client.http.get("/rooms")).status_code == 503
        assert (await client.http.get("/objects?room=1")).status_code == 503
        assert {one.room_id for one in await things(client)} == {None}
    senses.map = three_rooms()
    assert len(await rooms(client)) == 3


class MergingStore(FakeStore):
    """While its rooms are read, the robot's map is merged into another; nobody has told the service so yet."""

    merges = False

    async def rooms(self, map_number: int) -> tuple[KeptRoom, ...]:
        kept = await super().rooms(map_number)
        if self.merges:
            self.merges = False
            await self.enter_map("new", ("old",), 5.0)
        return kept


class LeavingWhereabouts(Whereabouts):
    """The robot is in one map for so many questions, then in another."""

    left = 1_000_000

    async def here(self) -> KeptMap:
        self.left -= 1
        return KeptMap(0, "", 0.0) if self.left >= 0 else KeptMap(1, "next", 0.0)


async def merging() -> MergingStore:
    store = MergingStore()
    await store.enter_map("new", (), 0.0)
    await store.enter_map("old", (), 1.0)
    return store


async def test_no_room_is_written_under_the_number_of_a_map_that_is_merged_meanwhile(senses: FakeSenses) -> None:
    store = await merging()
    async with served(create_app(Settings(), bus=MemoryBus(), store=store, senses=senses)) as client:
        store.merges = True
        assert (await client.get("/rooms", RoomsReply)).rooms == ()
    assert await store.rooms(1) == ()


async def test_no_room_is_named_in_a_map_that_is_merged_meanwhile(senses: FakeSenses) -> None:
    store = await merging()
    async with served(create_app(Settings(), bus=MemoryBus(), store=store, senses=senses)) as client:
        number = (await rooms(client))[2].id
        store.merges = True
        assert (await client.http.put(f"/rooms/{number}/name", json={"name": "den"})).status_code == 409
    assert {one.name for one in await store.rooms(0)} == {""}


async def test_rooms_are_not_written_for_a_map_that_the_robot_has_left_since(senses: FakeSenses) -> None:
    store, clock, lock = FakeStore(), FakeClock(), SharedLock()
    whereabouts = LeavingWhereabouts(store, senses, clock, lock)
    book = RoomBook(store, senses, whereabouts, clock, lock)
    whereabouts.left = 1
    assert (await book.rooms()).rooms == ()
    assert await store.rooms(0) == ()
    whereabouts.left = 1_000_000
    (first, *_) = (await book.rooms()).rooms
    whereabouts.left = 1
    with pytest.raises(ConflictError):
        await book.name(first.id, "den")
    assert {one.name for one in await store.rooms(0)} == {""}


async def test_a_room_that_the_map_shows_no_more_does_not_keep_its_name(
    client: ServiceClient, senses: FakeSenses
) -> None:
    found = await rooms(client)
    await named(client, f"/rooms/{found[10].id}/name", {"name": "den"})
    senses.map = without_the_last_room()
    assert set(await rooms(client)) == {2, 6}
    told = await named(client, f"/rooms/{found[6].id}/name", {"name": "Den"})
    assert told.name == "Den"
    senses.map = three_rooms()
    assert (await rooms(client))[10].named_by is NamedBy.NOBODY


async def test_to_take_the_name_from_a_room_that_lies_in_another_is_answered(
    client: ServiceClient, senses: FakeSenses
) -> None:
    found = await rooms(client)
    newest = max(found.values(), key=lambda one: one.id)
    await named(client, f"/rooms/{newest.id}/name", {"name": "hall"})
    senses.map = OccupancyGrid(np.zeros((80, 240), np.int8), 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0))
    assert [one.id for one in (await rooms(client)).values()] == [newest.id]
    answer = await client.http.put(f"/rooms/{newest.id}/name", json={"name": ""})
    assert answer.status_code == 404, answer.text
    (left,) = (await rooms(client)).values()
    assert (left.id, left.named_by) == (min(one.id for one in found.values()), NamedBy.NOBODY)


class AlikeStore(FakeStore):
    """Of another program's time: its rooms have names that none is given now."""

    async def rooms(self, map_number: int) -> tuple[KeptRoom, ...]:
        names = {1: "Den", 2: "den", 3: "unnamed room 1"}
        return tuple(replace(one, name=names[one.id]) for one in await super().rooms(map_number))


async def test_two_rooms_that_a_database_calls_alike_are_not_told_so(senses: FakeSenses) -> None:
    app = create_app(Settings(), bus=MemoryBus(), store=AlikeStore(), senses=senses)
    async with served(app) as client:
        found = (await client.get("/rooms", RoomsReply)).rooms
    assert [one.name for one in found] == ["Den", "unnamed room 2", "unnamed room 3"]


async def test_where_the_rooms_lie_is_told_by_the_ids_they_are_named_by(client: ServiceClient) -> None:
    told, found = (await client.get("/rooms", RoomsReply)), room_grids.decode(await client.get("/rooms/grid", RoomGrid))
    for one in told.rooms:
        row, column = int((one.y - found.origin.y) / found.resolution_m), int((one.x - found.origin.x) / 0.05)
        assert found.ids[row, column] == one.id
        assert found.of([one.id]).sum() * 0.05**2 == pytest.approx(one.area_m2, abs=0.01)


async def test_without_a_map_no_room_lies_anywhere(store: FakeStore) -> None:
    app = create_app(Settings(), bus=MemoryBus(), store=store, senses=FakeSenses(ground=None))
    async with served(app) as client:
        assert (await client.http.get("/rooms/grid")).status_code == 404
