"""What is remembered belongs to a map, in every store there is."""

import sqlite3
import uuid
from collections.abc import AsyncIterator, Callable
from contextlib import aclosing, closing
from pathlib import Path

import pytest
from sqlalchemy import create_engine, text

from contracts.geometry import Pose2D
from contracts.memory import Area, ForgetRequest
from memory.adapters.store import SqlStore
from memory.frames import Frame, frames_of
from memory.ports import ExportBatch, Store
from support.memory_database import opened, opened_at
from support.memory_store import FakeStore
from support.observations import seen
from support.postgres_server import fresh_database

Make = Callable[[str], Store]


@pytest.fixture(params=["dict", "sqlite", "postgresql"])
def make(request: pytest.FixtureRequest, tmp_path: Path) -> Make:
    if request.param == "dict":
        return lambda name: FakeStore()
    if request.param == "sqlite":
        return lambda name: opened(tmp_path / f"{name}.db")
    server = request.getfixturevalue("postgres_url")
    return lambda name: opened_at(fresh_database(server, uuid.uuid4().hex))


@pytest.fixture
async def store(make: Make) -> AsyncIterator[Store]:
    async with aclosing(make("memory")) as opened_store:
        yield opened_store


async def remember(store: Store, number: int, x: float, label: str = "cup") -> None:
    """A view without a thing, and a thing, both of one map."""
    batch = [seen(label, x=x, stamp_s=5.0), seen(label, x=x, at=(x + 1.0, 0.0), stamp_s=5.0)]
    await store.remember(frames_of(batch, number))


async def test_what_was_seen_in_one_map_is_not_of_another(store: Store) -> None:
    home, office = await store.enter_map("home", (), 1.0), await store.enter_map("office", (), 2.0)
    await remember(store, home, 1.0)
    await remember(store, office, 1.0)
    for number in (home, office):
        found = (await store.candidates({"cup": ()}, map_number=number, views_a_thing=4, views_max=10))["cup"]
        assert {view.map_number for view in found.views} == {number}
        assert {thing.map_number for thing in found.things.values()} == {number}
        assert len(await store.views("cup", 10, number)) == 2
        assert len(await store.things(None, Area(x_min=0.0, y_min=-1.0, x_max=3.0, y_max=1.0), 10, number)) == 1
        assert [(one.label, one.views, one.objects) for one in await store.labels(10, number)] == [("cup", 2, 1)]
    assert [(one.label, one.views, one.objects) for one in await store.labels(10)] == [("cup", 4, 2)]
    assert await store.map_sizes() == {home: (2, 1), office: (2, 1)}
    assert set(await store.maps_with("cup", 10)) == {home, office}
    assert await store.maps_with("bottle", 10) == ()


async def test_the_maps_are_told_with_the_one_entered_last_first(store: Store) -> None:
    numbers = [await store.enter_map(name, (), now_s) for name, now_s in (("a", 1.0), ("b", 2.0), ("a", 3.0))]
    assert numbers[0] == numbers[2]
    assert [one.id for one in await store.maps()] == ["a", "b"]


async def test_what_is_of_no_map_is_of_the_first_one_that_is_known(store: Store) -> None:
    await remember(store, 0, 1.0)
    assert [one.id for one in await store.maps()] == [""]
    first, second = await store.enter_map("home", (), 1.0), await store.enter_map("office", (), 2.0)
    assert len(await store.views(None, 10, first)) == 2
    assert await store.views(None, 10, second) == []


async def test_a_look_in_one_map_takes_nothing_from_what_was_seen_in_another(store: Store) -> None:
    home, office = await store.enter_map("home", (), 1.0), await store.enter_map("office", (), 2.0)
    await store.remember(frames_of([seen("cup", stamp_s=5.0)], home))
    before = (await store.views("cup", 10, home))[0].belief
    look = Frame(Pose2D(x=0.0, y=0.0, yaw=0.0), 50.0, is_look=True, map_number=office)
    await store.remember([look])
    assert (await store.views("cup", 10, home))[0].belief == before
    await store.remember([Frame(look.pose, 50.0, is_look=True, map_number=home)])
    assert (await store.views("cup", 10, home))[0].belief < before


async def test_two_maps_said_to_be_one_home_become_one_and_the_same_count_once(store: Store) -> None:
    home, office = await store.enter_map("home", (), 1.0), await store.enter_map("office", (), 2.0)
    for number in (home, office):
        await remember(store, number, 1.0)
    await remember(store, office, 3.0)
    assert await store.enter_map("home", ("office", "never heard of"), 3.0) == home
    loose = sorted((v.x, v.count) for v in await store.views(None, 10, home) if v.thing_id is None)
    assert loose == [(1.0, 2), (3.0, 1)]
    assert len(await store.views(None, 10)) == len(await store.views(None, 10, home)) == 5
    assert {one.map_number for one in await store.things(None, None, 10)} == {home}
    assert [one.id for one in await store.maps()] == ["home"]
    assert await store.enter_map("home", ("office",), 4.0) == home


async def test_an_area_is_forgotten_in_its_own_map(store: Store) -> None:
    home, office = await store.enter_map("home", (), 1.0), await store.enter_map("office", (), 2.0)
    for number in (home, office):
        await remember(store, number, 1.0)
    everywhere = ForgetRequest(area=Area(x_min=-9.0, y_min=-9.0, x_max=9.0, y_max=9.0))
    assert await store.forget(everywhere, office) == 3
    assert (await store.views(None, 10, office), len(await store.views(None, 10, home))) == ([], 2)
    assert await store.forget(ForgetRequest(label="cup")) == 3


async def test_an_export_keeps_its_maps_apart_where_others_are_known(make: Make) -> None:
    async with aclosing(make("from")) as source, aclosing(make("to")) as target:
        home, office = await source.enter_map("home", (), 1.0), await source.enter_map("office", (), 2.0)
        await remember(source, home, 1.0)
        await remember(source, office, 2.0)
        pages = [page async for page in source.export_batches()]
        hoard = ExportBatch(
            things=tuple(one for page in pages for one in page.things),
            views=tuple(one for page in pages for one in page.views),
            maps=tuple(one for page in pages for one in page.maps),
        )
        here = [await target.enter_map(name, (), 1.0) for name in ("elsewhere", "office", "home")]
        await target.import_batch(hoard)
        await target.import_batch(hoard)
        by_x = {number: sorted(view.x for view in await target.views(None, 10, number)) for number in here}
        assert by_x == {here[0]: [], here[1]: [2.0, 2.0], here[2]: [1.0, 1.0]}


async def test_a_database_from_before_maps_keeps_what_it_holds_for_the_first_map(tmp_path: Path) -> None:
    path = tmp_path / "memory.db"
    async with aclosing(opened(path)) as store:
        await remember(store, 0, 1.0)
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript(BACK_TO_0003)
    await _still_there(opened(path))


async def test_so_does_a_database_on_postgresql(postgres_url: str) -> None:
    url = fresh_database(postgres_url, uuid.uuid4().hex)
    async with aclosing(opened_at(url)) as store:
        await remember(store, 0, 1.0)
    engine = create_engine(url.replace("postgresql://", "postgresql+psycopg://"))
    with engine.begin() as connection:
        for statement in BACK_TO_0003.strip().split(";\n"):
            connection.execute(text(statement.rstrip(";")))
    engine.dispose()
    await _still_there(opened_at(url))


async def _still_there(opened_store: SqlStore) -> None:
    async with aclosing(opened_store) as store:
        first = await store.enter_map("home", (), 1.0)
        assert (len(await store.views(None, 10, first)), len(await store.things(None, None, 10, first))) == (2, 1)
        second = await store.enter_map("office", (), 2.0)
        assert await store.views(None, 10, second) == []


BACK_TO_0003 = """
DROP TABLE rooms;
DROP INDEX things_of_label;
DROP INDEX things_at;
DROP INDEX views_place;
DROP INDEX views_best_first;
DROP INDEX views_of_colour;
ALTER TABLE things DROP COLUMN map_number;
ALTER TABLE views DROP COLUMN map_number;
DROP TABLE maps;
CREATE INDEX things_of_label ON things (label);
CREATE INDEX things_at ON things (x, y);
CREATE UNIQUE INDEX views_place ON views (cell_x, cell_y, sector, label, colour, coalesce(thing_id, 0));
CREATE INDEX views_best_first ON views (label, confidence DESC);
CREATE INDEX views_of_colour ON views (label, colour, confidence DESC) WHERE thing_id IS NULL;
UPDATE alembic_version SET version_num = '0003';
"""


async def test_rooms_belong_to_a_map_and_two_of_one_map_never_bear_one_name(store: Store) -> None:
    home, office = await store.enter_map("home", (), 1.0), await store.enter_map("office", (), 2.0)
    await store.add_rooms(home, [(1.0, 2.0), (3.0, 4.0)])
    await store.add_rooms(office, [(1.0, 2.0)])
    first, second = await store.rooms(home)
    (other,) = await store.rooms(office)
    assert [(one.number, one.x, one.y, one.name) for one in (first, second)] == [(1, 1.0, 2.0, ""), (2, 3.0, 4.0, "")]
    shown = {first.id, second.id}
    assert await store.name_room(home, first.id, "Den", shown) == first.id
    assert await store.name_room(home, second.id, "den", shown) == first.id
    assert await store.name_room(office, other.id, "den", {other.id}) == other.id
    assert [one.name for one in (*await store.rooms(home), *await store.rooms(office))] == ["Den", "", "den"]
    await store.enter_map("home", ("office",), 3.0)
    assert [(one.number, one.name) for one in await store.rooms(home)] == [(1, "Den"), (2, ""), (3, "")]


async def test_a_room_that_is_not_shown_loses_its_name_to_one_that_is(store: Store) -> None:
    home = await store.enter_map("home", (), 1.0)
    await store.add_rooms(home, [(1.0, 2.0), (3.0, 4.0)])
    first, second = await store.rooms(home)
    await store.name_room(home, first.id, "Den", {first.id})
    assert await store.name_room(home, second.id, "den", {second.id}) == second.id
    assert [one.name for one in await store.rooms(home)] == ["", "den"]


async def test_no_room_is_kept_or_named_in_a_map_that_is_none_any_more(store: Store) -> None:
    old = await store.enter_map("old", (), 1.0)
    assert await store.add_rooms(old, [(1.0, 2.0)])
    (kept,) = await store.rooms(old)
    home = await store.enter_map("home", (), 2.0)
    await store.enter_map("home", ("old",), 3.0)
    assert not await store.add_rooms(old, [(5.0, 6.0)])
    assert await store.name_room(old, kept.id, "Den", {kept.id}) is None
    assert await store.rooms(old) == ()
    assert [one.name for one in await store.rooms(home)] == [""]
