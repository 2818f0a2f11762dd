"""Back-up and restore of an SQLite file in use: snapshots, and candidates that are judged before they replace it.

A snapshot is one read transaction (`VACUUM INTO`): writers go on meanwhile, and what was deleted is not in it. A
restore is one write transaction of SQLite's backup API: readers see the old content or the new one, and a process that
is killed halfway leaves the old one.

Everything here blocks. What is wrong with a candidate is an `UnprocessableError`, what is wrong with the disk or a lock
an `UnavailableError`.
"""

import glob
import re
import sqlite3
import time
from collections import Counter
from collections.abc import Callable, Generator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, Final

import structlog
from alembic.util.exc import CommandError
from sqlalchemy import URL, Connection, create_engine, event
from sqlalchemy.exc import DBAPIError

from mesh.errors import UnavailableError, UnprocessableError
from store.copies import DatabaseCopy, JudgedDatabase
from store.migrations import UnknownSchemaError, current_revision, upgrade
from store.troubles import naming_the_database

log = structlog.get_logger()

KEPT: Final = 3
"""So many of the databases that a restore replaced stay beside it."""
BEFORE_RESTORE: Final = "before-restore"
HALF: Final = ".half"
"""Of a copy that is being made; one that was killed meanwhile leaves it."""
MAGIC: Final = b"SQLite format 3\x00"
LARGEST: Final = 1.7e308
"""A larger number is infinite: no place, no time and no belief is."""
NOT_ITS_FAULT: Final = frozenset(
    {sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR, sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_NOMEM}
)
KINDS: Final = {
    "INTEGER": ("integer",),
    "BOOLEAN": ("integer",),
    "FLOAT": ("real", "integer"),
    "TEXT": ("text",),
    "BLOB": ("blob",),
}
"""What SQLite may hold in a column of ours: it would take anything."""

Reads = Callable[[Connection], None]
"""Reads all that its service has to understand, and raises `ValueError` for what it does not."""
Shape = dict[str, frozenset[tuple[object, ...]]]
"""Of each table its columns, its indexes with all they are over, what it refers to, and how many `RULES` it has."""
RULES: Final = frozenset({"CHECK", "CONFLICT", "COLLATE", "STRICT", "WITHOUT", "DEFERRED", "AUTOINCREMENT"})
"""What a table may demand that no PRAGMA tells of: each could refuse, or drop, what is written to it later."""


def snapshot(path: Path) -> DatabaseCopy:
    """Of the database in use at `path`, as it is at one moment; lies beside it while it is made."""
    with naming_the_database():
        made = place_of_snapshot(path)
        try:
            _vacuum_into(path, made)
            with closing(_opened(made)) as connection:
                revision = str(connection.execute("SELECT version_num FROM alembic_version").fetchone()[0])
            return DatabaseCopy(made.open("rb"), made.stat().st_size, revision)
        finally:
            made.unlink(missing_ok=True)


def place_of_snapshot(path: Path) -> Path:
    """Where it lies until it has no name any more."""
    return path.with_name(f"{path.name}.snapshot")


def half_made(path: Path) -> list[Path]:
    """Of the copies that restores keep of the database at `path`."""
    return [*path.parent.glob(f"{glob.escape(path.name)}.{BEFORE_RESTORE}-*{HALF}")]


def judged(path: Path, migrations: Path, *, page_bytes: int, reads: Reads) -> JudgedDatabase:
    """The file at `path`, checked in every way before it is believed, and migrated. Only that file is written to."""
    with naming_the_database(), path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            raise UnprocessableError("it is no SQLite database")
    with _naming_the_candidate():
        with closing(_opened(path)) as connection:
            _check_sound(connection)
            connection.execute("PRAGMA journal_mode = DELETE")
        rows, revision = _migrated(path, migrations, reads)
        with closing(_opened(path)) as connection:
            if connection.execute("PRAGMA page_size").fetchone()[0] != page_bytes:
                connection.execute(f"PRAGMA page_size = {page_bytes}")
                connection.execute("VACUUM")
    return JudgedDatabase(path, revision, rows)


def page_bytes_of(path: Path) -> int:
    with naming_the_database(), closing(_opened(path)) as connection:
        return int(connection.execute("PRAGMA page_size").fetchone()[0])


def replace(path: Path, candidate: Path, *, patience_s: float) -> Path:
    """The database in use at `path` becomes what `candidate` is; returns where its content from before is kept.

    Only while no other thread of this process writes; another process that does for `patience_s` is an
    `UnavailableError`, and nothing has changed.
    """
    with naming_the_database():
        older = _kept_of(path)
        kept = path.with_name(f"{path.name}.{BEFORE_RESTORE}-{older[-1][0] + 1 if older else 1}")
        half = kept.with_name(kept.name + HALF)
        _vacuum_into(path, half)
        half.replace(kept)
        try:
            _copy(candidate, path, patience_s)
        except BaseException:
            kept.unlink(missing_ok=True)
            raise
        for _, old in older[: len(older) + 1 - KEPT]:
            old.unlink(missing_ok=True)
    return kept


def _copy(candidate: Path, path: Path, patience_s: float) -> None:
    until_s = time.monotonic() + patience_s

    def waited(status: int, _remaining: int, _total: int) -> None:
        if status in {sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED} and time.monotonic() > until_s:
            raise UnavailableError("database", "another program writes it")

    with closing(_opened(candidate, read_only=True)) as source, closing(_opened(path)) as live:
        live.execute("PRAGMA synchronous = FULL")
        source.backup(live, progress=waited, sleep=0.05)
        try:
            live.execute("PRAGMA wal_checkpoint(TRUNCATE)")  # what was there before leaves the log
        except sqlite3.Error as error:  # e.g. a full disk: the database is the new one all the same
            log.warning("restored; what was there before is still in the log beside the database", error=str(error))


def _kept_of(path: Path) -> list[tuple[int, Path]]:
    """What earlier restores replaced, oldest first."""
    found = path.parent.glob(f"{path.name}.{BEFORE_RESTORE}-*")
    numbered = ((one.name.rpartition("-")[2], one) for one in found)
    return sorted((int(number), one) for number, one in numbered if number.isdecimal())


def _vacuum_into(path: Path, made: Path) -> None:
    """The file is its owner's alone: it holds what a home looks like."""
    made.unlink(missing_ok=True)
    made.touch(mode=0o600)
    try:
        with closing(_opened(path)) as connection:
            connection.execute("VACUUM INTO ?", (str(made),))
    except BaseException:
        made.unlink(missing_ok=True)
        raise


def _opened(path: Path, *, read_only: bool = False) -> sqlite3.Connection:
    """`read_only`: it must be there; else SQLite makes an empty one."""
    place = f"{path.absolute().as_uri()}?mode={'ro' if read_only else 'rwc'}"
    connection = sqlite3.connect(place, uri=True, isolation_level=None, timeout=2.0)
    connection.execute("PRAGMA trusted_schema = OFF")
    connection.execute("PRAGMA cell_size_check = ON")
    return connection


def _check_sound(connection: sqlite3.Connection) -> None:
    """Its schema first: what checks the rest would run what a hostile one holds."""
    schema = connection.execute("SELECT type, name, sql FROM sqlite_master").fetchall()
    for kind, name, sql in schema:
        if kind not in {"table", "index"} or "VIRTUAL" in str(sql).upper().split("(")[0].split():
            raise UnprocessableError(f"it holds what no database of ours does: {kind} {str(name)[:60]!r}")
    if not schema:
        raise UnprocessableError("it is empty")
    verdict = str(connection.execute("PRAGMA integrity_check(1)").fetchone()[0])
    if verdict != "ok":
        raise UnprocessableError(f"it is damaged: {verdict[:200]}")
    if connection.execute("PRAGMA foreign_key_check").fetchone() is not None:
        raise UnprocessableError("it is damaged: a row names another one that is not there")


def _migrated(path: Path, migrations: Path, reads: Reads) -> tuple[dict[str, int], str]:
    with _in_transaction(str(path)) as connection, _in_transaction(":memory:") as fresh:
        upgrade(fresh, migrations)
        revision = current_revision(connection)
        upgrade(connection, migrations)
        expected, found = _shape(fresh), _shape(connection)
        if found != expected:
            differing = sorted(one for one in {*found, *expected} if found.get(one) != expected.get(one))
            raise UnprocessableError(f"its tables are not ours: {', '.join(differing)[:200]}")
        for table in expected:
            _check_values(connection, table)
        reads(connection)
        rows = {
            table: int(connection.exec_driver_sql(f'SELECT count(*) FROM "{table}"').scalar_one())
            for table in sorted(expected)
            if table != "alembic_version"
        }
        return rows, revision


def _shape(connection: Connection) -> Shape:
    names = connection.exec_driver_sql("SELECT name FROM sqlite_master WHERE type = 'table'").scalars()
    return {name: _shape_of(connection, name) for name in [*names] if not name.startswith("sqlite_")}


def _shape_of(connection: Connection, table: str) -> frozenset[tuple[object, ...]]:
    def told(pragma: str, name: str) -> list[tuple[Any, ...]]:
        return [tuple(row) for row in connection.exec_driver_sql(f'PRAGMA {pragma}("{name}")')]

    found: list[tuple[object, ...]] = []
    for _, name, kind, required, _, key, hidden in told("table_xinfo", table):
        found.append(("column", name, kind, required, key, hidden))
    for _, name, *of in told("index_list", table):
        found.append(("index", name, *of))
        for place, _, column, *how in told("index_xinfo", name):
            found.append(("indexed", name, place, column, *how))
    for _, place, *refers in told("foreign_key_list", table):
        found.append(("refers", place, *refers))
    statements = connection.exec_driver_sql(
        "SELECT type, name, sql FROM sqlite_master WHERE tbl_name = ? AND sql IS NOT NULL", (table,)
    )
    for kind, name, sql in statements:
        if kind == "index":  # its expressions, and WHERE
            found.append(("index", name, "".join(sql.replace('"', "").split())))
        else:
            rules = Counter(one for one in re.findall(r"[A-Z]+", sql.upper()) if one in RULES)
            found += [("rule", *one) for one in rules.items()]
    return frozenset(found)


def _check_values(connection: Connection, table: str) -> None:
    """Raises `UnprocessableError` unless every value is of its column's kind, and finite."""
    wrong: list[str] = []
    for row in connection.exec_driver_sql(f'PRAGMA table_info("{table}")'):
        name, kind = str(row[1]), str(row[2]).partition("(")[0].replace("VARCHAR", "TEXT")
        allowed = ", ".join(f"'{one}'" for one in (*KINDS[kind], "null"))
        wrong.append(f'typeof("{name}") NOT IN ({allowed})')
        if kind == "FLOAT":
            wrong.append(f'abs("{name}") > {LARGEST}')
    if connection.exec_driver_sql(f'SELECT 1 FROM "{table}" WHERE {" OR ".join(wrong)} LIMIT 1').first():
        raise UnprocessableError(f"the table {table} holds values of another kind than its columns")


@contextmanager
def _in_transaction(database: str) -> Generator[Connection]:
    engine = create_engine(URL.create("sqlite", database=database), hide_parameters=True)

    def set_up(connection: sqlite3.Connection, record: object) -> None:
        connection.isolation_level = None
        connection.execute("PRAGMA trusted_schema = OFF")

    def on_begin(connection: Connection) -> None:
        connection.exec_driver_sql("BEGIN IMMEDIATE")

    event.listen(engine, "connect", set_up)
    event.listen(engine, "begin", on_begin)
    try:
        with engine.begin() as connection:
            yield connection
    finally:
        engine.dispose()


@contextmanager
def _naming_the_candidate() -> Generator[None]:
    """What SQLite, a migration or the service says of the file; a full disk is not its fault."""
    try:
        yield
    except UnknownSchemaError as error:
        raise UnprocessableError(error.said) from error
    except DBAPIError as error:
        raise _of(error.orig) from error
    except sqlite3.Error as error:
        raise _of(error) from error
    except CommandError as error:
        raise UnprocessableError(f"its schema's version is not readable: {str(error)[:200]}") from error
    except ValueError as error:
        raise UnprocessableError(f"it holds what this program does not understand: {str(error)[:200]}") from error
    except OSError as error:
        raise UnavailableError("database", str(error)) from error


def _of(error: BaseException | None) -> UnavailableError | UnprocessableError:
    if getattr(error, "sqlite_errorcode", 0) & 0xFF in NOT_ITS_FAULT:
        return UnavailableError("database", str(error))
    return UnprocessableError(f"it is damaged: {str(error)[:200]}")
