"""Back-up and restore of what explorations know of each home, in a coordinator that goes on working."""

import asyncio
import sqlite3
from collections.abc import AsyncIterator
from contextlib import aclosing, asynccontextmanager, closing
from pathlib import Path

import pytest

from contracts.backup import BackupRefusal, RestoreReply
from contracts.exploration import Discovery, ExplorationMemory
from contracts.mission import MissionState
from coordinator.adapters.exploration_journal import ExplorationJournal
from store.sqlite_file import SqliteFile
from support.coordinator_mesh import Mesh, opened_mesh
from support.coordinator_world import Thing

BOTTLE = Thing("bottle", "red", 3.5, 2.5)


def found(label: str) -> ExplorationMemory:
    return ExplorationMemory(discoveries=(Discovery(label=label, note="", x_m=1.0, y_m=2.0, stamp_s=3.0),))


CUP, BOOK = found("cup"), found("book")


def journal(file: Path) -> ExplorationJournal:
    return ExplorationJournal(file, busy_timeout_s=1.0)


@asynccontextmanager
async def opened(one: ExplorationJournal) -> AsyncIterator[Mesh]:
    async with aclosing(one), opened_mesh(BOTTLE, journal=one) as mesh:
        yield mesh


async def snapshot(mesh: Mesh) -> bytes:
    answer = await mesh.client.get("/exploration/backup")
    assert answer.is_success, answer.text
    return answer.content


async def test_a_restored_memory_of_a_home_is_read_again_and_over_a_restart(tmp_path: Path) -> None:
    file = tmp_path / "exploration.db"
    one = journal(file)
    async with opened(one) as mesh:
        one.write("flat", CUP)
        database = await snapshot(mesh)  # what waits to be written is in it
        one.write("flat", BOOK)
        one.write("garden house", BOOK)
        answer = await mesh.client.post("/exploration/restore", content=database)
        assert answer.is_success, answer.text
        reply = RestoreReply.model_validate_json(answer.content)
        assert (reply.applied, reply.rows) == (True, {"explorations": 1})
        assert (await one.read("flat"), await one.read("garden house")) == (CUP, ExplorationMemory())
    async with aclosing(journal(file)) as again, aclosing(journal(tmp_path / reply.kept_as)) as before:
        assert await again.read("flat") == CUP
        assert (await before.read("flat"), await before.read("garden house")) == (BOOK, BOOK)


async def test_what_is_told_while_it_is_replaced_does_not_follow_into_what_is_restored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = journal(tmp_path / "exploration.db")
    replace = SqliteFile.replace

    async with opened(one) as mesh:
        one.write("flat", CUP)
        database = await snapshot(mesh)
        loop = asyncio.get_running_loop()

        def meanwhile(file: SqliteFile, candidate: object) -> Path:
            loop.call_soon_threadsafe(one.write, "flat", BOOK)
            asyncio.run_coroutine_threadsafe(asyncio.sleep(0), loop).result(30.0)  # it has been told
            return replace(file, candidate)  # type: ignore[arg-type]

        monkeypatch.setattr(SqliteFile, "replace", meanwhile)
        answer = await mesh.client.post("/exploration/restore", content=database)
        assert answer.is_success, answer.text
        await one.flush()
        assert await one.read("flat") == CUP


async def test_it_is_only_checked_where_that_is_asked_and_refused_under_a_mission(tmp_path: Path) -> None:
    one = journal(tmp_path / "exploration.db")
    async with opened(one) as mesh:
        one.write("flat", CUP)
        database = await snapshot(mesh)
        one.write("flat", BOOK)
        checked = await mesh.client.post("/exploration/restore", content=database, params={"dry_run": True})
        assert (checked.status_code, checked.json()["applied"]) == (200, False)
        await mesh.post_mission()
        await mesh.until_state(MissionState.SCANNING)
        refused = await mesh.client.post("/exploration/restore", content=database)
        assert (refused.status_code, refused.json()["code"]) == (409, BackupRefusal.MISSION_ON.value)
        assert await one.read("flat") == BOOK


async def test_what_is_no_journal_of_ours_is_refused_and_a_record_not_understood_is_not_a_reason_to(
    tmp_path: Path,
) -> None:
    place, one = tmp_path / "sent.db", journal(tmp_path / "exploration.db")
    async with opened(one) as mesh:
        one.write("flat", CUP)
        one.write("attic", BOOK)
        place.write_bytes(await snapshot(mesh))
        with closing(sqlite3.connect(place)) as connection, connection:
            connection.execute("UPDATE explorations SET memory = '{\"of\": \"tomorrow\"}' WHERE home = 'attic'")
        answer = await mesh.client.post("/exploration/restore", content=place.read_bytes())
        assert answer.is_success, answer.text
        assert (await one.read("attic"), await one.read("flat")) == (ExplorationMemory(), CUP)
        with closing(sqlite3.connect(place)) as connection, connection:
            connection.execute("ALTER TABLE explorations RENAME TO missions")
        for sent in (place.read_bytes(), b"no database at all"):
            answer = await mesh.client.post("/exploration/restore", content=sent)
            assert answer.status_code == 422, answer.text
        assert await one.read("flat") == CUP
