"""Databases of earlier versions are brought to the newest, whole."""

import sqlite3
from collections.abc import AsyncIterator
from contextlib import aclosing, closing
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import Engine, create_engine, make_url

from memory.adapters.store import SqlStore
from memory.adapters.tables import metadata
from memory.frames import frames_of
from mesh.errors import UnavailableError
from support.memory_database import opened, opened_at
from support.observations import seen
from support.postgres_server import fresh_database

FIRST_VERSION = """
CREATE TABLE schema_version (version INTEGER NOT NULL);
CREATE TABLE views (
    id INTEGER NOT NULL, label TEXT NOT NULL, colour TEXT NOT NULL, cell_x INTEGER NOT NULL, cell_y INTEGER NOT NULL,
    sector INTEGER NOT NULL, x FLOAT NOT NULL, y FLOAT NOT NULL, yaw FLOAT NOT NULL, confidence FLOAT NOT NULL,
    last_seen_s FLOAT NOT NULL, count INTEGER NOT NULL,
    PRIMARY KEY (id), UNIQUE (label, colour, cell_x, cell_y, sector)
);
CREATE INDEX views_best_first ON views (label, confidence DESC);
INSERT INTO schema_version (version) VALUES (1);
INSERT INTO views VALUES (1, 'bottle', 'red', 4, -4, 0, 1.1, -0.9, 0.1, 0.8, 1700000000.0, 7);
INSERT INTO views VALUES (5, 'cup', '', 0, 0, 3, 0.1, 0.1, 1.6, 0.5, 1700000001.0, 1);
"""
"""As the first release made it, with two views in it."""


@pytest.fixture
def old(tmp_path: Path) -> Path:
    path = tmp_path / "memory.db"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.executescript(FIRST_VERSION)
    return path


@pytest.fixture
async def store(old: Path) -> AsyncIterator[SqlStore]:
    async with aclosing(opened(old)) as opened_store:
        yield opened_store


async def test_views_of_the_first_version_are_still_there_and_go_on_being_merged(store: SqlStore) -> None:
    await store.remember(frames_of([seen("cup", 0.2, 0.2, 1.6, confidence=0.9, stamp_s=1.7e9 + 2)]))
    told = [(one.label, one.colour, one.x, one.confidence, one.count) for one in await store.views(None, 10)]
    assert told == [("cup", "", 0.2, 0.9, 2), ("bottle", "red", 1.1, 0.8, 7)]
    (bottle,) = await store.views("bottle", 10)
    assert bottle.belief == pytest.approx(0.93, abs=0.01)
    assert bottle.thing_id is None


def differences(engine: Engine) -> list[object]:
    with engine.connect() as connection:
        return [
            one
            for one in compare_metadata(MigrationContext.configure(connection), metadata)
            if "index" not in str(one[0])  # neither database tells Alembic enough of indices over expressions
        ]


@pytest.mark.filterwarnings("ignore:Skipped unsupported reflection:sqlalchemy.exc.SAWarning")
@pytest.mark.filterwarnings("ignore:autogenerate skipping metadata-specified expression-based index:UserWarning")
async def test_migrations_lead_to_the_tables_the_code_knows_on_sqlite(old: Path, store: SqlStore) -> None:
    await store.check()
    engine = create_engine(f"sqlite:///{old}")
    assert differences(engine) == []
    engine.dispose()


async def test_migrations_lead_to_the_tables_the_code_knows_on_postgresql(postgres_url: str) -> None:
    url = fresh_database(postgres_url, "migrated")
    async with aclosing(opened_at(url)) as store:
        await store.check()
    engine = create_engine(make_url(url).set(drivername="postgresql+psycopg"))
    assert differences(engine) == []
    engine.dispose()


async def test_a_database_of_a_newer_program_is_left_alone(old: Path, store: SqlStore) -> None:
    await store.check()
    with closing(sqlite3.connect(old)) as other:
        other.execute("UPDATE alembic_version SET version_num = '9999'")
        other.commit()
    async with aclosing(opened(old)) as later:
        with pytest.raises(UnavailableError, match="9999 of a newer program"):
            await later.views(None, 10)
