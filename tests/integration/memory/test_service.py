"""The whole service over real Redis and a real SQLite file."""

import sqlite3
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import aclosing, asynccontextmanager, closing, contextmanager, suppress
from pathlib import Path

import httpx
import pytest
from asgi_lifespan import LifespanManager

from contracts.geometry import Pose2D
from contracts.memory import LabelCount, ObservationBatch, ObservationsReply, View
from contracts.topics import VISION_DETECTIONS
from contracts.vision import Detection, Detections
from memory.app import create_app
from memory.frames import frames_of
from memory.settings import Settings
from mesh.bus import open_bus
from mesh.errors import UnavailableError
from mesh.http import ServiceClient
from support.memory_database import opened
from support.observations import seen
from support.waiting import until_true


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "data" / "memory.db"


@asynccontextmanager
async def serving(path: Path, redis_url: str, *, busy_timeout_s: float = 10.0) -> AsyncIterator[ServiceClient]:
    """A file that is still being opened is waited for as long as a locked one."""
    settings = Settings(
        database_url=f"sqlite:///{path}",
        redis_url=redis_url,
        robot_bridge_url="",
        flush_period_s=0.02,
        busy_timeout_s=busy_timeout_s,
    )
    async with LifespanManager(create_app(settings)) as manager:
        client = ServiceClient("memory", "http://memory", transport=httpx.ASGITransport(manager.app), timeout_s=30.0)
        try:
            yield client
        finally:
            await client.aclose()


@contextmanager
def locked(path: Path) -> Iterator[None]:
    with closing(sqlite3.connect(path, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        yield
        other.execute("ROLLBACK")


def batch(*xs: float) -> ObservationBatch:
    return ObservationBatch(observations=tuple(seen(x=x) for x in xs))


async def put_once_it_is_open(client: ServiceClient, observations: ObservationBatch) -> None:
    """While the file is still being opened, which a busy machine does slowly, they are refused and nothing is kept."""

    async def taken() -> bool:
        with suppress(UnavailableError):
            await client.post("/observations", observations, ObservationsReply)
            return True
        return False

    await until_true(taken)


async def test_detections_on_redis_become_views_and_survive_a_restart(path: Path, redis_url: str) -> None:
    frame = Detections(
        stamp_s=3.0,
        image_width_px=250,
        image_height_px=250,
        pose=Pose2D(x=1.0, y=2.0, yaw=0.5),
        detections=tuple(
            Detection(label=label, confidence=0.8, bbox_xyxy=(0.0, 0.0, 9.0, 9.0), colour=colour)
            for label, colour in (("bottle", "red"), ("person", None))
        ),
    )
    async with serving(path, redis_url) as client, open_bus(redis_url) as bus:
        found: list[View] = []
        while not found:
            assert await bus.publish(VISION_DETECTIONS, frame)
            found = await client.get_list("/views", View, label="bottle")
        assert (await client.http.get("/ready")).status_code == 200
    async with serving(path, redis_url) as client:
        kept = await client.get_list("/views", View)
        assert [one.model_copy(update={"count": 1}) for one in kept] == [found[0].model_copy(update={"count": 1})]
        assert [one.label for one in await client.get_list("/labels", LabelCount)] == ["bottle"]
    assert not any(b"person" in file.read_bytes() for file in path.parent.iterdir())


async def test_a_locked_file_is_a_503_not_a_hang_and_reading_goes_on(path: Path, redis_url: str) -> None:
    async with serving(path, redis_url, busy_timeout_s=0.3) as client:
        await put_once_it_is_open(client, batch(1.0))
        with locked(path):
            with pytest.raises(UnavailableError, match="database is locked"):
                await client.post("/observations", batch(2.0), ObservationsReply)
            answer = await client.http.get("/ready", timeout=30.0)
            assert "database is locked" in answer.text
            assert len(await client.get_list("/views", View)) == 1
        await client.post("/observations", batch(3.0), ObservationsReply)
        assert len(await client.get_list("/views", View)) == 2


async def test_a_file_that_is_locked_at_the_start_is_opened_once_it_is_free(path: Path, redis_url: str) -> None:
    path.parent.mkdir()
    async with serving(path, redis_url, busy_timeout_s=0.3) as client:
        with locked(path), pytest.raises(UnavailableError, match="database"):
            await client.post("/observations", batch(1.0), ObservationsReply)

        await put_once_it_is_open(client, batch(1.0))
        assert len(await client.get_list("/views", View)) == 1


def all_of_it(whole: bytes) -> bytes:
    return b"this is no database" * 1000


def its_end(whole: bytes) -> bytes:
    return whole[: len(whole) // 2]


def some_pages(whole: bytes) -> bytes:
    return whole[:8192] + bytes(range(256)) * 128 + whole[8192 + 256 * 128 :]


def change(path: Path, damage: Callable[[bytes], bytes]) -> bytes:
    path.write_bytes(damage(path.read_bytes()))
    return path.read_bytes()


def read(path: Path, name: str) -> bytes:
    return path.with_name(name).read_bytes()


@pytest.mark.parametrize("damage", [all_of_it, its_end, some_pages])
async def test_a_corrupt_file_is_set_aside_as_it_was(
    path: Path, redis_url: str, damage: Callable[[bytes], bytes], capfd: pytest.CaptureFixture[str]
) -> None:
    async with aclosing(opened(path)) as store:
        await store.remember(frames_of([seen(x=float(k)) for k in range(1000)]))
    damaged = change(path, damage)
    path.with_name("memory.db.corrupt-1").write_bytes(b"of an earlier time")
    async with serving(path, redis_url) as client:
        await client.post("/observations", batch(1.0), ObservationsReply)
        assert len(await client.get_list("/views", View)) == 1
    assert read(path, "memory.db.corrupt-1") == b"of an earlier time"
    assert read(path, "memory.db.corrupt-2") == damaged
    said = "".join(capfd.readouterr())
    assert "the database was corrupt: set aside" in said
    assert "memory.db.corrupt-2" in said


@pytest.mark.parametrize(
    ("statements", "told"),
    [
        ("CREATE TABLE recipes (id INTEGER)", "another program's tables"),
        ("CREATE TABLE schema_version (version INTEGER); INSERT INTO schema_version VALUES (99)", "schema version 99"),
    ],
)
async def test_a_file_that_is_not_ours_is_left_alone(path: Path, redis_url: str, statements: str, told: str) -> None:
    path.parent.mkdir()
    with closing(sqlite3.connect(path)) as other:
        other.executescript(statements)
    before = read(path, path.name)
    async with serving(path, redis_url) as client:
        with pytest.raises(UnavailableError, match=told):
            await client.post("/observations", batch(1.0), ObservationsReply)
        answer = await client.http.get("/ready")
        assert (answer.status_code, told in answer.text) == (503, True)
    assert read(path, path.name) == before


async def test_a_folder_that_cannot_be_made_is_a_503(tmp_path: Path, redis_url: str) -> None:
    (tmp_path / "data").write_text("a file, not a folder")
    async with serving(tmp_path / "data" / "memory.db", redis_url) as client:
        with pytest.raises(UnavailableError, match="database"):
            await client.post("/observations", batch(1.0), ObservationsReply)
