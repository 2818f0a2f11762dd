"""An SQLite file: made ours when new, set aside when corrupt, left alone when it is somebody else's.

Everything here blocks. Every failure is an `UnavailableError` that names the database.
"""

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any, BinaryIO

import structlog
from sqlalchemy import URL, Engine, create_engine, event

from mesh.errors import UnavailableError
from store import backup
from store.backup import Reads
from store.copies import DatabaseCopy, JudgedDatabase
from store.database import CHECK_S
from store.migrations import upgrade
from store.troubles import naming_the_database

log = structlog.get_logger()

CORRUPT = frozenset({sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB})
SIDE_FILES = ("-wal", "-shm", "-journal")


class SqliteFile:
    """A `store.database.Database`. `migrations` is the folder of its scripts; `pragmas` hold for every connection."""

    name = "sqlite"

    def __init__(self, path: Path, migrations: Path, *, pragmas: tuple[str, ...], busy_timeout_s: float) -> None:
        self._path = path
        self._migrations = migrations
        self._pragmas = pragmas
        self._busy_timeout_s = busy_timeout_s

    def prepare(self, *, patience_s: float) -> None:
        """Afterwards the file is there, sound, in WAL mode and has our tables; what copies a process left that was
        killed while it made them is gone."""
        with naming_the_database():
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._sweep()
            trouble = self._trouble(patience_s)
            if trouble:
                aside = set_aside(self._path)
                log.error(
                    "the database was corrupt: set aside, an empty one begins", reason=trouble, kept_as=aside.name
                )
            self._make_ours(patience_s)

    def writer(self) -> Engine:
        return self._engine("BEGIN IMMEDIATE", self._pragmas, connections=1, patience_s=self._busy_timeout_s)

    def reader(self, connections: int) -> Engine:
        read_only = (*self._pragmas, "PRAGMA query_only = ON")
        return self._engine("BEGIN", read_only, connections=connections, patience_s=self._busy_timeout_s)

    def check_writable(self) -> None:
        """Takes the write lock, touches a row, and lets go without a trace."""
        if not self._path.exists():
            raise UnavailableError("database", "the file is gone")
        with (
            naming_the_database(),
            closing(sqlite3.connect(self._path, timeout=CHECK_S, isolation_level=None)) as connection,
        ):
            connection.execute("BEGIN IMMEDIATE")
            connection.execute("UPDATE alembic_version SET version_num = version_num")
            connection.execute("ROLLBACK")

    def after_forgetting(self, writer: Engine) -> None:
        """Empties the log, which still holds what was there before; a reader may delay that to the next time."""
        with naming_the_database():
            connection = writer.raw_connection()
            try:
                connection.cursor().execute("PRAGMA wal_checkpoint(TRUNCATE)")
            finally:
                connection.close()

    def size_bytes(self, reader: Engine) -> int | None:
        return sum(file.stat().st_size for file in self._files() if file.exists())

    def snapshot(self) -> DatabaseCopy:
        return backup.snapshot(self._path)

    def place_for_candidate(self) -> Path:
        place = self._candidate
        with naming_the_database():
            remove(place)
        return place

    def judged(self, path: Path, reads: Reads) -> JudgedDatabase:
        return backup.judged(path, self._migrations, page_bytes=backup.page_bytes_of(self._path), reads=reads)

    def replace(self, candidate: JudgedDatabase) -> Path:
        return backup.replace(self._path, candidate.path, patience_s=self._busy_timeout_s)

    @property
    def _candidate(self) -> Path:
        return self._path.with_name(f"{self._path.name}.candidate")

    def _sweep(self) -> None:
        for left in (self._candidate, backup.place_of_snapshot(self._path), *backup.half_made(self._path)):
            if left.exists():
                log.warning("a copy was left half made by a process that was killed: removed", file=left.name)
            remove(left)

    def _files(self) -> list[Path]:
        return _with_side_files(self._path)

    def _trouble(self, patience_s: float) -> str:
        """What is wrong with the file; empty when it is sound or not there. `sqlite3.Error` when it is locked."""
        if not self._path.exists():
            return ""
        try:
            with closing(sqlite3.connect(self._path, timeout=patience_s)) as connection:
                verdict = str(connection.execute("PRAGMA quick_check(1)").fetchone()[0])
        except sqlite3.DatabaseError as error:
            if error.sqlite_errorcode & 0xFF not in CORRUPT:
                raise
            return str(error)
        return "" if verdict == "ok" else verdict

    def _make_ours(self, patience_s: float) -> None:
        """The log mode only after the tables: a file that is not ours is not touched."""
        engine = self._engine("BEGIN IMMEDIATE", (), connections=1, patience_s=patience_s)
        try:
            with engine.begin() as connection:
                upgrade(connection, self._migrations)
            with closing(sqlite3.connect(self._path, timeout=patience_s, isolation_level=None)) as connection:
                connection.execute("PRAGMA journal_mode = WAL")
        finally:
            engine.dispose()

    def _engine(self, begin: str, pragmas: tuple[str, ...], *, connections: int, patience_s: float) -> Engine:
        engine = create_engine(
            URL.create("sqlite", database=str(self._path)),
            hide_parameters=True,  # an error's text, and so a log, never holds what was to be written
            pool_size=connections,
            max_overflow=0,
            pool_timeout=self._busy_timeout_s,
            connect_args={"timeout": patience_s, "check_same_thread": False},
        )

        def set_up(connection: Any, record: object) -> None:
            connection.isolation_level = None  # BEGIN is ours to say: Python's sqlite3 would say it too late
            cursor = connection.cursor()
            for pragma in pragmas:
                cursor.execute(pragma)
            cursor.close()

        def on_begin(connection: Any) -> None:
            connection.exec_driver_sql(begin)

        event.listen(engine, "connect", set_up)
        event.listen(engine, "begin", on_begin)
        return engine


def owners_alone(path: Path) -> BinaryIO:
    """A new file that nobody else may read: it holds what a home looks like."""
    path.touch(mode=0o600, exist_ok=False)
    return path.open("wb")


def remove(path: Path) -> None:
    """The file and its side files, where they are."""
    for file in _with_side_files(path):
        file.unlink(missing_ok=True)


def _with_side_files(path: Path) -> list[Path]:
    return [path.with_name(path.name + end) for end in ("", *SIDE_FILES)]


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
