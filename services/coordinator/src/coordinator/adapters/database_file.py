"""The file under the log: made ours when new, set aside when corrupt, left alone when it is somebody else's.

Everything here blocks; the log calls it in a thread.
"""

import sqlite3
from collections.abc import Generator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import structlog
from sqlalchemy import URL, event
from sqlalchemy.dialects import sqlite
from sqlalchemy.exc import DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeoutError
from sqlalchemy.ext.asyncio import AsyncEngine, create_async_engine
from sqlalchemy.schema import CreateIndex, CreateTable

from coordinator.adapters.tables import SCHEMA_VERSION, metadata
from mesh.errors import UnavailableError

log = structlog.get_logger()

CORRUPT = frozenset({sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB})
SIDE_FILES = ("-wal", "-shm", "-journal")
POOL_TIMEOUT_S = 10.0
"""One reader or writer waits for the other no longer than this."""


@contextmanager
def naming_the_database() -> Generator[None]:
    """Translates whatever the file system or SQLite says into `UnavailableError`."""
    try:
        yield
    except DBAPIError as error:
        raise UnavailableError("database", str(error.orig)) from error
    except PoolTimeoutError as error:
        raise UnavailableError("database", "busy: too many wait for it") from error
    except (sqlite3.Error, OSError) as error:
        raise UnavailableError("database", str(error)) from error


def engine(path: Path, *, busy_timeout_s: float) -> AsyncEngine:
    """One connection, in a thread of its own beside the event loop. WAL with NORMAL: safe against a killed process;
    a power cut may take the last second, which a history can bear."""
    made = create_async_engine(
        URL.create("sqlite+aiosqlite", database=str(path)),
        hide_parameters=True,
        pool_size=1,
        max_overflow=0,
        pool_timeout=POOL_TIMEOUT_S,
        connect_args={"timeout": busy_timeout_s},
    )

    def set_up(connection: Any, record: object) -> None:
        cursor = connection.cursor()
        cursor.execute("PRAGMA synchronous = NORMAL")
        cursor.close()

    event.listen(made.sync_engine, "connect", set_up)
    return made


def prepare(path: Path, *, busy_timeout_s: float) -> None:
    """Afterwards the file is there, sound, in WAL mode and has our tables. Raises `UnavailableError`."""
    with naming_the_database():
        path.parent.mkdir(parents=True, exist_ok=True)
        trouble = _trouble(path, busy_timeout_s)
        if trouble:
            aside = _set_aside(path)
            log.error("the missions' history was corrupt: set aside, a new one begins", reason=trouble, kept_as=aside)
        with closing(sqlite3.connect(path, timeout=busy_timeout_s, isolation_level=None)) as connection:
            _make_ours(connection)


def _trouble(path: Path, busy_timeout_s: float) -> str:
    """What is wrong with the file; empty when it is sound or not there. Raises `sqlite3.Error` when it is locked."""
    if not path.exists():
        return ""
    try:
        with closing(sqlite3.connect(path, timeout=busy_timeout_s)) as connection:
            verdict = str(connection.execute("PRAGMA quick_check(1)").fetchone()[0])
    except sqlite3.DatabaseError as error:
        if error.sqlite_errorcode & 0xFF not in CORRUPT:
            raise
        return str(error)
    return "" if verdict == "ok" else verdict


def _set_aside(path: Path) -> str:
    """Moves the file and its side files to a name nobody has; the side files first."""
    number = 1
    while any(path.with_name(f"{path.name}.corrupt-{number}{end}").exists() for end in ("", *SIDE_FILES)):
        number += 1
    kept = f"{path.name}.corrupt-{number}"
    for end in (*SIDE_FILES, ""):
        file = path.with_name(path.name + end)
        if file.exists():
            file.rename(path.with_name(kept + end))
    return kept


def _make_ours(connection: sqlite3.Connection) -> None:
    tables = {str(row[0]) for row in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if tables and "schema_version" not in tables:
        raise UnavailableError("database", "the file holds another program's tables; it was left alone")
    if tables:
        found = connection.execute("SELECT max(version) FROM schema_version").fetchone()[0]
        if found != SCHEMA_VERSION:
            told = f"the file has schema version {found}, this program knows {SCHEMA_VERSION}; it was left alone"
            raise UnavailableError("database", told)
    connection.execute("PRAGMA journal_mode = WAL")
    if not tables:
        connection.execute("BEGIN IMMEDIATE")
        for statement in _definitions():
            connection.execute(statement)
        connection.execute("COMMIT")


def _definitions() -> list[str]:
    """The statements that make an empty database ours."""
    made = [CreateTable(table) for table in metadata.sorted_tables]
    made += [CreateIndex(index) for table in metadata.sorted_tables for index in sorted(table.indexes, key=str)]
    statements = [str(one.compile(dialect=sqlite.dialect())) for one in made]
    return [*statements, f"INSERT INTO schema_version (version) VALUES ({SCHEMA_VERSION})"]
