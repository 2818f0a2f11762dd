"""A database that is replaced while whoever asked for it goes away, or the disk is full: never emptied, never lost."""

import asyncio
import sqlite3
import threading
from collections.abc import AsyncIterator
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from memory.adapters.tables import MIGRATIONS
from mesh.errors import ConflictError
from store import backup
from store.connections import SNAPSHOTS_HELD_MAX, Connections
from store.copies import JudgedDatabase
from store.finishing import finished
from store.sqlite_file import SqliteFile

PAGE_BYTES = 4096


class HeldUp(SqliteFile):
    """Begins to replace only when it is let."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, MIGRATIONS, pragmas=(), busy_timeout_s=2.0)
        self.begun, self.go_on = threading.Event(), threading.Event()

    def replace(self, candidate: JudgedDatabase) -> Path:
        self.begun.set()
        assert self.go_on.wait(30.0)
        return super().replace(candidate)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "memory.db"


def ids_in(path: Path) -> list[str]:
    with closing(sqlite3.connect(path)) as connection:
        return [str(row[0]) for row in connection.execute("SELECT id FROM maps")]


def named(path: Path, name: str) -> None:
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("UPDATE maps SET id = ?", (name,))


def database_of(path: Path, name: str) -> SqliteFile:
    file = SqliteFile(path, MIGRATIONS, pragmas=(), busy_timeout_s=2.0)
    file.prepare(patience_s=2.0)
    named(path, name)
    return file


async def test_a_restore_whose_asker_is_cancelled_is_finished_first(path: Path, tmp_path: Path) -> None:
    database_of(path, "before")
    database_of(tmp_path / "other.db", "restored")
    with backup.snapshot(tmp_path / "other.db").file as file:
        sent = file.read()
    held_up = HeldUp(path)
    connections = Connections(held_up, readers=1, busy_timeout_s=2.0)

    async def body() -> AsyncIterator[bytes]:
        yield sent

    async def restore() -> None:
        async with connections.candidate(body(), bytes_max=10**8, reads=lambda connection: None) as candidate:
            await connections.replace(candidate)

    restoring = asyncio.create_task(restore())
    await asyncio.to_thread(held_up.begun.wait, 30.0)
    for _ in range(3):  # more than once, as a server that closes does
        restoring.cancel()
        await asyncio.wait({restoring}, timeout=0.02)
    held_up.go_on.set()
    with pytest.raises(asyncio.CancelledError):
        await restoring
    await connections.aclose()
    assert ids_in(path) == ["restored"]
    assert not path.with_name("memory.db.candidate").exists()


def test_what_a_killed_process_left_half_made_is_gone_when_the_next_one_has_started(path: Path) -> None:
    database_of(path, "mine")
    whole = ("memory.db", "memory.db.before-restore-1", "memory.db.corrupt-1", "another.db.candidate")
    half = ("candidate", "candidate-journal", "snapshot", "snapshot-journal", "before-restore-2.half")
    for name in (*whole[1:], *(f"memory.db.{one}" for one in half)):
        path.with_name(name).touch()
    SqliteFile(path, MIGRATIONS, pragmas=(), busy_timeout_s=2.0).prepare(patience_s=2.0)
    assert {one.name for one in path.parent.iterdir()} - {"memory.db-wal", "memory.db-shm"} == set(whole)
    assert ids_in(path) == ["mine"]


def test_a_copy_has_its_name_only_once_it_is_whole(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    database_of(path, "before")
    database_of(path.with_name("other.db"), "restored")
    seen: list[str] = []
    vacuum = backup._vacuum_into

    def watched(source: Path, made: Path) -> None:
        vacuum(source, made)
        seen.append(made.name)

    monkeypatch.setattr(backup, "_vacuum_into", watched)
    kept = backup.replace(path, path.with_name("other.db"), patience_s=2.0)
    assert (kept.name, seen) == ("memory.db.before-restore-1", ["memory.db.before-restore-1.half"])
    assert ids_in(kept) == ["before"]


async def test_so_many_back_ups_are_held_for_their_readers_and_no_more(path: Path) -> None:
    database_of(path, "mine")
    file = SqliteFile(path, MIGRATIONS, pragmas=(), busy_timeout_s=2.0)
    connections = Connections(file, readers=1, busy_timeout_s=2.0)
    held = [await connections.snapshot() for _ in range(SNAPSHOTS_HELD_MAX)]
    with pytest.raises(ConflictError):
        await connections.snapshot()
    held[0].file.close()
    held.append(await connections.snapshot())
    with pytest.raises(ConflictError):
        await connections.snapshot()
    for one in held:
        one.file.close()
    await connections.aclose()


def test_a_candidate_that_is_gone_replaces_nothing(path: Path, tmp_path: Path) -> None:
    database_of(path, "before")
    with pytest.raises(backup.UnavailableError):
        backup.replace(path, tmp_path / "gone.db", patience_s=0.1)
    assert ids_in(path) == ["before"]
    assert not (tmp_path / "gone.db").exists()
    assert not list(tmp_path.glob("*before-restore*"))


class FullDisk(sqlite3.Connection):
    """What was committed stays in the log: there is no room to bring it into the file."""

    def execute(self, sql: str, *arguments: Any) -> sqlite3.Cursor:
        if "wal_checkpoint" in sql:
            raise sqlite3.OperationalError("database or disk is full")
        return super().execute(sql, *arguments)


def test_a_disk_that_is_full_afterwards_does_not_cost_what_was_there_before(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    database_of(path, "before")
    database_of(tmp_path / "other.db", "restored")
    backup.judged(tmp_path / "other.db", MIGRATIONS, page_bytes=PAGE_BYTES, reads=lambda connection: None)
    with monkeypatch.context() as patched, closing(sqlite3.connect(path)) as other:
        other.execute("PRAGMA schema_version")  # somebody else has it open: closing does not empty the log either
        patched.setattr(sqlite3, "connect", partial(sqlite3.connect, factory=FullDisk))
        kept = backup.replace(path, tmp_path / "other.db", patience_s=0.1)
    assert ids_in(path) == ["restored"]
    assert ids_in(kept) == ["before"]


async def test_what_fails_while_its_asker_is_cancelled_is_said_behind_the_cancel() -> None:
    go_on = asyncio.Event()

    async def fails() -> None:
        await go_on.wait()
        raise OSError("full")

    asking = asyncio.create_task(finished(fails()))
    await asyncio.wait({asking}, timeout=0.01)
    asking.cancel()
    go_on.set()
    with pytest.raises(asyncio.CancelledError) as caught:
        await asking
    assert isinstance(caught.value.__cause__, OSError)
