"""One behaviour for both stores: the dict that tests use, and SQLite."""

from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import aclosing
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from contracts.memory import Observation
from memory.adapters.sqlite import SqliteStore
from memory.ports import Store
from support.memory_store import FakeStore
from support.observations import labels, observations, seen

Make = Callable[[Path, int], Store]


def fake(path: Path, views_max: int) -> Store:
    return FakeStore(views_max=views_max)


def real(path: Path, views_max: int) -> Store:
    return SqliteStore(path, views_max=views_max)


@pytest.fixture(params=[fake, real])
def make(request: pytest.FixtureRequest) -> Make:
    return request.param


@pytest.fixture
async def store(make: Make, tmp_path: Path) -> AsyncIterator[Store]:
    async with aclosing(make(tmp_path / "memory.db", 1_000_000)) as opened:
        yield opened


async def test_an_empty_store_knows_nothing_and_can_be_written(store: Store) -> None:
    await store.check()
    assert await store.views(None, 10) == []
    assert await store.views("bottle", 10) == []
    assert await store.labels(10) == []
    assert await store.forget("bottle") == 0


async def test_views_come_by_confidence_descending_and_no_more_than_asked_for(store: Store) -> None:
    await store.add([seen(x=float(k), confidence=c) for k, c in enumerate((0.3, 0.9, 0.5, 0.9))])
    assert [(one.pose.x, one.confidence) for one in await store.views("bottle", 3)] == [
        (1.0, 0.9),
        (3.0, 0.9),
        (2.0, 0.5),
    ]


async def test_sightings_of_one_view_merge_within_a_batch_and_across_batches(store: Store) -> None:
    await store.add([seen(x=0.01, confidence=0.4, stamp_s=1.0), seen(x=0.02, confidence=0.6, stamp_s=2.0)])
    await store.add([seen(x=0.03, confidence=0.5, stamp_s=9.0)])
    await store.add([seen(x=0.04, confidence=0.6, stamp_s=3.0)])
    (kept,) = await store.views(None, 10)
    assert (kept.pose.x, kept.confidence, kept.stamp_s) == (0.02, 0.6, 9.0)


async def test_a_colour_not_known_is_none_and_apart_from_known_ones(store: Store) -> None:
    await store.add([seen(colour="red"), seen(colour=None, confidence=0.4), seen(colour="blue", confidence=0.3)])
    assert [one.colour for one in await store.views("bottle", 10)] == ["red", None, "blue"]


async def test_labels_are_counted_most_views_first_then_by_name(store: Store) -> None:
    await store.add(
        [seen("cup", confidence=0.8), seen("vase"), *(seen("bottle", x=float(k), stamp_s=k) for k in range(3))]
    )
    assert [(one.label, one.views, one.best_confidence, one.last_seen_s) for one in await store.labels(10)] == [
        ("bottle", 3, 0.5, 2.0),
        ("cup", 1, 0.8, 1.0),
        ("vase", 1, 0.5, 1.0),
    ]
    assert [one.label for one in await store.labels(1)] == ["bottle"]


async def test_forgetting_a_label_leaves_the_others(store: Store) -> None:
    await store.add([seen("cup"), seen("bottle"), seen("bottle", x=1.0)])
    assert await store.forget("bottle") == 2
    assert [one.label for one in await store.views(None, 10)] == ["cup"]


@pytest.mark.parametrize("label", ["'; DROP TABLE views; --", '"', "%", "_", "100% käse 🧀", "a/b", "NULL", " "])
async def test_a_label_is_only_data(store: Store, label: str) -> None:
    await store.add([seen(label), seen("bottle")])
    assert [one.label for one in await store.views(label, 10)] == [label]
    assert await store.forget(label) == 1
    assert [one.label for one in await store.views(None, 10)] == ["bottle"]


async def test_a_full_store_forgets_what_was_longest_not_seen(make: Make, tmp_path: Path) -> None:
    async with aclosing(make(tmp_path / "memory.db", 100)) as store:
        await store.add([seen(x=float(k), stamp_s=float(k)) for k in range(100)])
        assert len(await store.views(None, 1000)) == 100
        await store.add([seen("cup", stamp_s=50.5)])
        kept = await store.views(None, 1000)
        assert len(kept) == 95
        assert min(one.stamp_s for one in kept) == 6.0
        assert {one.label for one in kept} == {"bottle", "cup"}


Step = Callable[[Store], Awaitable[object]]


def adding(batch: list[Observation]) -> Step:
    return lambda store: store.add(batch)


def forgetting(label: str) -> Step:
    return lambda store: store.forget(label)


steps = st.lists(
    st.one_of(st.lists(observations, min_size=1, max_size=8).map(adding), labels.map(forgetting)), max_size=8
)


@given(steps=steps)
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
async def test_sqlite_and_the_dict_agree_after_any_story(
    steps: list[Step], tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("story") / "memory.db"
    async with aclosing(FakeStore()) as model, aclosing(SqliteStore(path)) as store:
        for step in steps:
            assert await step(store) == await step(model)
        told = [one.model_copy(update={"id": 0}) for one in await store.views(None, 1000)]
        assert told == [one.model_copy(update={"id": 0}) for one in await model.views(None, 1000)]
        assert await store.labels(1000) == await model.labels(1000)
