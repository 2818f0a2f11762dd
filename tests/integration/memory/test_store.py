"""One behaviour for three stores: the dict that tests use, SQLite, and a real PostgreSQL."""

import uuid
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import aclosing
from dataclasses import asdict, replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from contracts.geometry import Pose2D
from contracts.memory import Area, ForgetRequest, Observation
from memory.frames import Frame, Miss, frames_of
from memory.ports import ExportBatch, Store, StoredView
from support.memory_database import opened, opened_at
from support.memory_store import FakeStore
from support.observations import labels, observations, poses, seen
from support.postgres_server import fresh_database

Make = Callable[[Path, int], Store]


@pytest.fixture(params=["dict", "sqlite", "postgresql"])
def make(request: pytest.FixtureRequest) -> Make:
    if request.param == "dict":
        return lambda path, views_max: FakeStore(views_max=views_max)
    if request.param == "sqlite":
        return lambda path, views_max: opened(path, views_max=views_max)
    server = request.getfixturevalue("postgres_url")
    return lambda path, views_max: opened_at(fresh_database(server, uuid.uuid4().hex), views_max=views_max)


@pytest.fixture
async def store(make: Make, tmp_path: Path) -> AsyncIterator[Store]:
    async with aclosing(make(tmp_path / "memory.db", 1_000_000)) as opened:
        yield opened


async def add(store: Store, batch: Sequence[Observation]) -> None:
    await store.remember(frames_of(batch))


async def test_an_empty_store_knows_nothing_and_can_be_written(store: Store) -> None:
    await store.check()
    assert await store.views(None, 10) == []
    assert await store.views("bottle", 10) == []
    assert await store.labels(10) == []
    assert await store.forget(ForgetRequest(label="bottle")) == 0


async def test_views_come_by_confidence_descending_and_no_more_than_asked_for(store: Store) -> None:
    await add(store, [seen(x=float(k), confidence=c) for k, c in enumerate((0.3, 0.9, 0.5, 0.9))])
    assert [(one.x, one.confidence) for one in await store.views("bottle", 3)] == [
        (1.0, 0.9),
        (3.0, 0.9),
        (2.0, 0.5),
    ]


async def test_sightings_of_one_view_merge_within_a_batch_and_across_batches(store: Store) -> None:
    await add(store, [seen(x=0.01, confidence=0.4, stamp_s=1.0), seen(x=0.02, confidence=0.6, stamp_s=2.0)])
    await add(store, [seen(x=0.03, confidence=0.5, stamp_s=9.0)])
    await add(store, [seen(x=0.04, confidence=0.6, stamp_s=3.0)])
    (kept,) = await store.views(None, 10)
    assert (kept.x, kept.confidence, kept.last_seen_s, kept.count) == (0.02, 0.6, 9.0, 4)


async def test_a_colour_not_known_is_none_and_apart_from_known_ones(store: Store) -> None:
    await add(store, [seen(colour="red"), seen(colour=None, confidence=0.4), seen(colour="blue", confidence=0.3)])
    assert [one.colour for one in await store.views("bottle", 10)] == ["red", "", "blue"]


async def test_labels_are_counted_most_views_first_then_by_name(store: Store) -> None:
    await add(
        store, [seen("cup", confidence=0.8), seen("vase"), *(seen("bottle", x=float(k), stamp_s=k) for k in range(3))]
    )
    assert [(one.label, one.views, one.best_confidence, one.last_seen_s) for one in await store.labels(10)] == [
        ("bottle", 3, 0.5, 2.0),
        ("cup", 1, 0.8, 1.0),
        ("vase", 1, 0.5, 1.0),
    ]
    assert [one.label for one in await store.labels(1)] == ["bottle"]


async def test_forgetting_a_label_leaves_the_others(store: Store) -> None:
    await add(store, [seen("cup"), seen("bottle"), seen("bottle", x=1.0)])
    assert await store.forget(ForgetRequest(label="bottle")) == 2
    assert [one.label for one in await store.views(None, 10)] == ["cup"]


@pytest.mark.parametrize("label", ["'; DROP TABLE views; --", '"', "%", "_", "100% käse 🧀", "a/b", "NULL", " "])
async def test_a_label_is_only_data(store: Store, label: str) -> None:
    await add(store, [seen(label), seen("bottle")])
    assert [one.label for one in await store.views(label, 10)] == [label]
    assert await store.forget(ForgetRequest(label=label)) == 1
    assert [one.label for one in await store.views(None, 10)] == ["bottle"]


async def test_a_full_store_forgets_what_was_longest_not_seen(make: Make, tmp_path: Path) -> None:
    async with aclosing(make(tmp_path / "memory.db", 100)) as store:
        await add(store, [seen(x=float(k), stamp_s=float(k)) for k in range(100)])
        assert len(await store.views(None, 1000)) == 100
        await add(store, [seen("cup", stamp_s=50.5)])
        kept = await store.views(None, 1000)
        assert len(kept) == 95
        assert min(one.last_seen_s for one in kept) == 6.0
        assert {one.label for one in kept} == {"bottle", "cup"}


async def test_boxes_of_one_frame_are_two_things_and_a_near_one_of_the_next_frame_is_one_of_them(store: Store) -> None:
    await add(store, [seen(at=(1.0, 0.0)), seen(at=(1.2, 0.0))])
    await add(store, [seen(at=(1.21, 0.0), stamp_s=2.0)])
    things = await store.things("bottle", None, 10)
    assert [(one.times_seen, round(one.x, 1)) for one in things] == [(2, 1.2), (1, 1.0)]
    assert await store.thing(things[0].id) == things[0]


async def test_a_view_of_a_thing_goes_with_it_and_has_its_colour(store: Store) -> None:
    await add(store, [seen(at=(1.0, 0.0), colour="red"), seen("cup", at=(1.0, 0.5))])
    (bottle,) = await store.things("bottle", None, 10)
    (kept,) = await store.views("bottle", 10)
    assert (kept.thing_id, kept.colour) == (bottle.id, "red")
    assert await store.forget_thing(bottle.id) == 2
    assert await store.forget_thing(bottle.id) == 0
    assert [one.label for one in await store.views(None, 10)] == ["cup"]


async def test_forgetting_takes_what_meets_every_condition(store: Store) -> None:
    await add(store, [seen(at=(1.0, 0.0)), seen("cup", at=(1.0, 0.3))])
    await add(store, [seen(x=5.0, stamp_s=9.0), seen(x=5.0, at=(6.0, 0.0), stamp_s=9.0)])
    around = Area(x_min=4.0, y_min=-1.0, x_max=7.0, y_max=1.0)
    assert await store.forget(ForgetRequest(label="cup", area=around)) == 0
    assert await store.forget(ForgetRequest(area=around, seen_after_s=9.0)) == 3
    assert await store.forget(ForgetRequest(seen_before_s=9.0)) == 4
    assert await store.views(None, 10) == []


async def test_what_one_store_gives_away_another_takes_in_once(make: Make, store: Store, tmp_path: Path) -> None:
    await add(store, [seen(at=(1.0, 0.0), colour="red"), seen(x=3.0), seen("cup", at=(1.0, 0.5))])
    given_away = [page async for page in store.export_batches()]
    whole = ExportBatch(
        tuple(t for page in given_away for t in page.things), tuple(v for p in given_away for v in p.views)
    )
    async with aclosing(make(tmp_path / "other.db", 1_000_000)) as other:
        await add(other, [seen("vase", at=(0.0, 0.0))])
        for _ in range(2):
            await other.import_batch(whole)
            assert without_ids(await other.views("bottle", 10)) == without_ids(await store.views("bottle", 10))
            assert len(await other.things(None, None, 10)) == 3


async def test_what_is_of_the_colour_asked_for_is_a_candidate_among_however_many_others(store: Store) -> None:
    """Less sure than all others, so that no limit would let it in; and one that is only a view."""
    await add(store, [seen(x=k, at=(k, 2.0), confidence=0.9, colour="blue") for k in map(float, range(60))])
    await add(store, [seen(x=k, y=9.0, confidence=0.9, colour="blue") for k in map(float, range(20))])
    await add(store, [seen(x=90.0, at=(90.0, 2.0), confidence=0.3, colour="red")])
    await add(store, [seen(x=95.0, y=9.0, confidence=0.3, colour="red"), seen("cup", x=1.0, colour="red")])
    found = await store.candidates({"bottle": {"red"}, "cup": set()}, views_a_thing=4, views_max=10)
    assert {view.x for view in found["bottle"].views if view.colour == "red"} == {90.0, 95.0}
    assert "red" in {thing.colour for thing in found["bottle"].things.values()}
    assert [view.label for view in found["cup"].views] == ["cup"]


async def test_ghosts_and_what_is_too_old_are_tidied_away(store: Store) -> None:
    await add(store, [seen(at=(1.0, 0.0), confidence=0.3), seen("cup", at=(1.0, 0.5)), seen("vase", x=2.0)])
    await add(store, [seen("clock", at=(1.0, 0.0), stamp_s=50.0)])
    (ghost,) = await store.things("bottle", None, 10)
    for x in (0.0, 1.0):
        pose = Pose2D(x=x, y=0.0, yaw=0.0)
        await store.remember([Frame(pose, 5.0, misses=(Miss(ghost.id, "bottle", 0.9),), is_look=True)])
    assert await store.tidy(lost_before_s=0.0, seen_before_s=0.5) == 2
    assert await store.tidy(lost_before_s=0.0, seen_before_s=10.0) == 3
    assert [one.label for one in await store.views(None, 10)] == ["clock"]


def without_ids(views: Sequence[StoredView]) -> list[StoredView]:
    return [replace(one, id=0, thing_id=one.thing_id and 1) for one in views]


Step = Callable[[Store], Awaitable[object]]


def remembering(frames: list[Frame]) -> Step:
    return lambda store: store.remember(frames)


def forgetting(what: ForgetRequest) -> Step:
    return lambda store: store.forget(what)


def forgetting_one(number: int) -> Step:
    return lambda store: store.forget_thing(number)


def tidying(seen_before_s: float) -> Step:
    return lambda store: store.tidy(lost_before_s=seen_before_s * 2.0, seen_before_s=seen_before_s)


misses = st.builds(Miss, st.integers(1, 12), labels, st.floats(0.1, 0.9))
frames = st.builds(
    Frame,
    pose=poses,
    stamp_s=st.floats(0.0, 1e6),
    seen=st.lists(observations, max_size=5).map(tuple),
    misses=st.lists(misses, max_size=4).map(tuple),
    is_look=st.booleans(),
    seen_labels=st.frozensets(labels, max_size=3),
)
areas = st.builds(
    lambda x, y, side: Area(x_min=x, y_min=y, x_max=x + side, y_max=y + side),
    st.floats(-2.0, 2.0),
    st.floats(-2.0, 2.0),
    st.floats(0.1, 2.0),
)
requests = st.one_of(
    st.builds(ForgetRequest, label=labels, seen_after_s=st.one_of(st.none(), st.floats(0.0, 1e6))),
    st.builds(ForgetRequest, area=areas, seen_before_s=st.one_of(st.none(), st.floats(0.0, 1e6))),
)
steps = st.lists(
    st.one_of(
        st.lists(frames, min_size=1, max_size=4).map(remembering),
        st.lists(frames, min_size=1, max_size=4).map(remembering),
        requests.map(forgetting),
        st.integers(1, 12).map(forgetting_one),
        st.floats(0.0, 1e5).map(tidying),
    ),
    max_size=8,
)


@given(steps=steps)
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
async def test_sqlite_and_the_dict_agree_after_any_story(
    steps: list[Step], tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("story") / "memory.db"
    async with aclosing(FakeStore()) as model, aclosing(opened(path)) as store:
        for step in steps:
            assert await step(store) == await step(model)
        assert await store.things(None, None, 1000) == await model.things(None, None, 1000)
        assert sorted(map(told, await store.views(None, 1000))) == sorted(map(told, await model.views(None, 1000)))
        assert await store.labels(1000) == await model.labels(1000)
        for label in ("bottle", "cup"):
            one = (await store.candidates({label: {"red"}}, views_a_thing=3, views_max=5))[label]
            other = (await model.candidates({label: {"red"}}, views_a_thing=3, views_max=5))[label]
            assert one.things == other.things
            assert sorted(one.confidence for one in one.views) == sorted(one.confidence for one in other.views)


def told(view: StoredView) -> tuple[object, ...]:
    """For sorting; SQLite does not tell -0.0 from 0.0."""
    known = asdict(replace(view, id=0)).values()
    return tuple(str(value + 0.0 if isinstance(value, float) else value) for value in known)
