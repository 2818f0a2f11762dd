"""The file under the store: made ours when new, set aside when corrupt, left alone when it is somebody else's.

Everything here blocks; the store calls it in a thread. Every failure is an `UnavailableError` that names the database.
"""

import sqlite3
from collections.abc import Callable, Generator
from contextlib import closing, contextmanager
from pathlib import Path

import structlog
from sqlalchemy.exc import DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeoutError

from memory.adapters.tables import SCHEMA_VERSION, definitions
from mesh.errors import UnavailableError

log = structlog.get_logger()

CORRUPT = frozenset({sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB})
SIDE_FILES = ("-wal", "-shm", "-journal")


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


def prepare(path: Path, *, busy_timeout_s: float) -> None:
    """Afterwards the file is there, sound, in WAL mode and has our tables."""
    with naming_the_database():
        path.parent.mkdir(parents=True, exist_ok=True)
        trouble = _trouble(path, busy_timeout_s)
        if trouble:
            aside = set_aside(path)
            log.error(
                "the memory was corrupt: set aside, starting with an empty one", reason=trouble, kept_as=aside.name
            )
        with closing(sqlite3.connect(path, timeout=busy_timeout_s, isolation_level=None)) as connection:
            _make_ours(connection)


def check_writable(path: Path, *, busy_timeout_s: float) -> None:
    """Takes the write lock, touches a row, and lets go without a trace."""
    if not path.exists():
        raise UnavailableError("database", "the file is gone")
    with (
        naming_the_database(),
        closing(sqlite3.connect(path, timeout=busy_timeout_s, isolation_level=None)) as connection,
    ):
        connection.execute("BEGIN IMMEDIATE")
        connection.execute("UPDATE schema_version SET version = version")
        connection.execute("ROLLBACK")


def set_aside(path: Path) -> Path:
    """Moves the file and its side files to a name nobody has; the side files first, so that a new database never
    finds an old one's log beside it."""
    number = 1
    while any(_named(path, number, end).exists() for end in ("", *SIDE_FILES)):
        number += 1
    for end in (*SIDE_FILES, ""):
        file = path.with_name(path.name + end)
        if file.exists():
            file.rename(_named(path, number, end))
    return _named(path, number, "")


def _named(path: Path, number: int, end: str) -> Path:
    return path.with_name(f"{path.name}.corrupt-{number}{end}")


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


def _make_ours(connection: sqlite3.Connection) -> None:
    tables = {str(row[0]) for row in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if not tables:
        connection.execute("PRAGMA journal_mode = WAL")
        _in_one_transaction(connection, _define)
        return
    if "schema_version" not in tables:
        raise UnavailableError("database", "the file holds another program's tables; it was left alone")
    found = connection.execute("SELECT max(version) FROM schema_version").fetchone()[0]
    if found != SCHEMA_VERSION:
        told = f"the file has schema version {found}, this program knows {SCHEMA_VERSION}; it was left alone"
        raise UnavailableError("database", told)
    connection.execute("PRAGMA journal_mode = WAL")


def _define(connection: sqlite3.Connection) -> None:
    if connection.execute("SELECT count(*) FROM sqlite_master WHERE name = 'schema_version'").fetchone()[0]:
        return  # another process was quicker
    for statement in definitions():
        connection.execute(statement)


def _in_one_transaction(connection: sqlite3.Connection, work: Callable[[sqlite3.Connection], None]) -> None:
    connection.execute("BEGIN IMMEDIATE")
    try:
        work(connection)
    except sqlite3.Error:
        connection.execute("ROLLBACK")
        raise
    connection.execute("COMMIT")
