"""A history of missions made by an earlier version is brought to the newest; one of a newer version is left alone."""

import json
import sqlite3
import zlib
from contextlib import closing
from pathlib import Path

import httpx
import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from asgi_lifespan import LifespanManager
from sqlalchemy import create_engine

from contracts.mission import Outcome
from coordinator.adapters.sqlite_log import SqliteLog
from coordinator.adapters.tables import metadata
from coordinator.app import create_app
from coordinator.settings import Settings
from support.coordinator_world import FakeInference, FakeMemory, FakeRobot, World
from support.described import described_bus
from support.fake_clock import FakeClock

VERSION_1 = """
CREATE TABLE events (id INTEGER NOT NULL, mission_id TEXT NOT NULL, line TEXT NOT NULL, PRIMARY KEY (id));
CREATE TABLE missions (
    number INTEGER NOT NULL, id TEXT NOT NULL, over BOOLEAN NOT NULL, record TEXT NOT NULL,
    PRIMARY KEY (number), UNIQUE (id)
);
CREATE TABLE pictures (
    mission_id TEXT NOT NULL, number INTEGER NOT NULL, jpeg BLOB NOT NULL, PRIMARY KEY (mission_id, number)
);
CREATE TABLE recordings (number INTEGER NOT NULL, mission_id TEXT NOT NULL, lines BLOB NOT NULL, PRIMARY KEY (number));
CREATE TABLE requests ("key" TEXT NOT NULL, digest TEXT NOT NULL, mission_ids TEXT NOT NULL, PRIMARY KEY ("key"));
CREATE TABLE schema_version (version INTEGER NOT NULL);
CREATE INDEX events_of_mission ON events (mission_id, id);
CREATE INDEX ix_recordings_mission_id ON recordings (mission_id);
INSERT INTO schema_version (version) VALUES (1);
"""
"""As the version before migrations made it, to the letter of SQLAlchemy's statements."""


@pytest.fixture
def old(tmp_path: Path) -> Path:
    path = tmp_path / "missions.db"
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.executescript(VERSION_1)
        for name, outcome in (("over", "found"), ("ran", None)):
            record = {"id": name, "command": "find it", "state": "IDLE", "outcome": outcome, "started_s": 1.0}
            row = (name, outcome is not None, json.dumps(record))
            connection.execute("INSERT INTO missions (id, over, record) VALUES (?, ?, ?)", row)
        line = {"id": 7, "mission_id": "over", "stamp_s": 1.0, "state": "IDLE", "kind": "end", "text": "found"}
        connection.execute("INSERT INTO events VALUES (7, 'over', ?)", (json.dumps(line),))
        connection.execute("INSERT INTO recordings VALUES (1, 'over', ?)", (zlib.compress(b"one\ntwo"),))
        connection.execute("INSERT INTO pictures VALUES ('over', 0, ?)", (b"jpeg",))
        connection.execute("INSERT INTO requests VALUES ('key', 'digest', 'over ran')")
    return path


def settings(path: Path) -> Settings:
    return Settings.model_validate({"database_url": f"sqlite:///{path}", "flush_s": 0.01})


async def opened_and_closed(path: Path) -> None:
    log = SqliteLog(settings(path))
    await log.open(1000.0)
    assert (await log.dependency()).ok
    await log.aclose()


async def ready(path: Path) -> httpx.Response:
    """What a coordinator over this history says of itself."""
    clock, bus = FakeClock(), described_bus()
    world = World(clock, bus)
    app = create_app(
        settings(path),
        bus=bus,
        robot=FakeRobot(world),
        inference=FakeInference(world),
        memory=FakeMemory(),
        clock=clock,
    )
    async with (
        LifespanManager(app) as manager,
        httpx.AsyncClient(transport=httpx.ASGITransport(manager.app), base_url="http://coordinator") as client,
    ):
        return await client.get("/ready")


def dump(path: Path) -> list[str]:
    with closing(sqlite3.connect(path)) as connection:
        return list(connection.iterdump())


async def test_a_history_of_the_first_version_is_carried_over_whole(old: Path) -> None:
    await opened_and_closed(old)
    with closing(sqlite3.connect(old)) as connection:
        tables = {name for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
        assert connection.execute("SELECT version_num FROM alembic_version").fetchall() == [("0003",)]
        kept = connection.execute("SELECT mission_id, lines FROM recordings").fetchall()
        assert [(name, zlib.decompress(lines)) for name, lines in kept] == [("over", b"one\ntwo")]
        assert connection.execute("SELECT * FROM pictures").fetchall() == [("over", 0, b"jpeg")]
        assert connection.execute("SELECT * FROM requests").fetchall() == [("key", "digest", "over ran")]
        assert connection.execute("SELECT id FROM events").fetchall() == [(7,), (8,)]
        missions = connection.execute("SELECT id, over, record FROM missions ORDER BY number").fetchall()
    assert "schema_version" not in tables
    found = [(name, over, json.loads(record)["outcome"]) for name, over, record in missions]
    assert found == [("over", 1, Outcome.FOUND.value), ("ran", 1, Outcome.INTERRUPTED.value)]


async def test_opening_it_again_changes_nothing_more(old: Path) -> None:
    await opened_and_closed(old)
    after_the_first = dump(old)
    await opened_and_closed(old)
    assert dump(old) == after_the_first


@pytest.mark.parametrize("made", ["old", "new"])
async def test_migrations_lead_to_the_tables_the_code_knows(made: str, old: Path, tmp_path: Path) -> None:
    path = {"old": old, "new": tmp_path / "new.db"}[made]
    await opened_and_closed(path)
    engine = create_engine(f"sqlite:///{path}")
    with engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), metadata) == []
    engine.dispose()


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ("UPDATE schema_version SET version = 2", "schema version 2, which is not known"),
        ("CREATE TABLE alembic_version (version_num TEXT); INSERT INTO alembic_version VALUES ('9999')",
         "schema 9999 of a newer program"),
        ("DROP TABLE schema_version", "another program's tables"),
    ],
)  # fmt: skip
async def test_a_history_that_is_not_understood_is_left_alone_and_named_in_ready(
    old: Path, change: str, named: str
) -> None:
    with closing(sqlite3.connect(old)) as connection:
        connection.executescript(change)
    before = dump(old)
    answer = await ready(old)
    assert answer.status_code == 503
    (database,) = [one for one in answer.json()["dependencies"] if one["name"] == "database"]
    assert named in database["detail"]
    assert dump(old) == before
