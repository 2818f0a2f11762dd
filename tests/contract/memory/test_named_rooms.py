"""The rooms of the map the robot is in, by name: through the front door."""

from collections.abc import AsyncIterator

import numpy as np
import pytest

from contracts.geometry import Pose2D
from contracts.memory import RememberedObject
from contracts.rooms import NamedBy, NamedRoom, RoomsReply
from geometry.grids import OCCUPIED, OccupancyGrid
from memory.app import create_app
from memory.settings import Settings
from mesh.http import ServiceClient
from support.bus import MemoryBus
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
    (1, {}, 422),
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
