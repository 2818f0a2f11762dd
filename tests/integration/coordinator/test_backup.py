"""Back-up and restore of the history of missions, in a coordinator that goes on working."""

import asyncio
import sqlite3
import threading
import zlib
from collections.abc import AsyncGenerator, AsyncIterator, Callable
from contextlib import asynccontextmanager, closing
from pathlib import Path

import pytest

from contracts.backup import BackupRefusal, RestoreReply
from contracts.mission import Mission, MissionState, Outcome
from contracts.vision import ParsedTask, ParseTaskRequest
from coordinator.adapters.sqlite_log import SqliteLog
from coordinator.settings import Settings
from mesh.errors import UnavailableError
from store.copies import JudgedDatabase
from store.sqlite_file import SqliteFile
from support.coordinator_mesh import Mesh, opened_mesh
from support.coordinator_world import Thing

RED = Thing("bottle", "red", 3.5, 2.5)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "coordinator.db"


@asynccontextmanager
async def opened(path: Path) -> AsyncIterator[Mesh]:
    log = SqliteLog(Settings.model_validate({"database_url": f"sqlite:///{path}", "flush_s": 0.01}))
    await log.open(0.0)
    writing = asyncio.create_task(log.write_forever())
    async with opened_mesh(RED, log=log) as mesh:
        yield mesh
    writing.cancel()
    await asyncio.gather(writing, return_exceptions=True)
    await log.aclose()


async def snapshot(mesh: Mesh) -> bytes:
    answer = await mesh.client.get("/backup")
    assert answer.is_success, answer.text
    return answer.content


async def restored(mesh: Mesh, database: bytes) -> RestoreReply:
    """At rest: after a find the robot celebrates."""
    await mesh.until_state(MissionState.IDLE)
    answer = await mesh.client.post("/restore", content=database)
    assert answer.is_success, answer.text
    return RestoreReply.model_validate_json(answer.content)


async def history(mesh: Mesh) -> list[object]:
    missions = (await mesh.client.get("/missions")).json()
    return [
        (
            one,
            (await mesh.client.get(f"/missions/{one['id']}/events")).json(),
            (await mesh.client.get(f"/missions/{one['id']}/recording")).text,
        )
        for one in missions
    ]


async def test_a_restore_gives_the_history_that_was_backed_up_and_the_next_mission_goes_on_from_there(
    path: Path,
) -> None:
    async with opened(path) as mesh:
        first = await mesh.until_over((await mesh.post_mission()).id)
        database, before = await snapshot(mesh), await history(mesh)
        second = await mesh.until_over((await mesh.post_mission()).id)
        newest = max(event.id for event in await mesh.timeline(second.id))
        reply = await restored(mesh, database)
        assert reply.rows["missions"] == 1
        assert await history(mesh) == before
        assert (await mesh.client.get(f"/missions/{second.id}")).status_code == 404
        assert path.with_name(reply.kept_as).exists()
        third = await mesh.until_over((await mesh.post_mission()).id)
        assert (first.outcome, third.outcome) == (Outcome.FOUND, Outcome.FOUND)
        assert min(event.id for event in await mesh.timeline(third.id)) > newest
    async with opened(path) as mesh:
        assert [one["id"] for one in (await mesh.client.get("/missions")).json()] == [third.id, first.id]


async def test_ids_of_events_go_on_rising_over_a_restore_and_a_restart(path: Path) -> None:
    """Else whoever asks for what came `after` the last one he saw would miss as many as were restored away."""
    async with opened(path) as mesh:
        await mesh.until_over((await mesh.post_mission()).id)
        database = await snapshot(mesh)
        second = await mesh.until_over((await mesh.post_mission()).id)
        newest = max(event.id for event in await mesh.timeline(second.id))
        await restored(mesh, database)
    async with opened(path) as mesh:
        third = await mesh.until_over((await mesh.post_mission()).id)
        assert min(event.id for event in await mesh.timeline(third.id)) > newest
        database = await snapshot(mesh)
        newest = max(event.id for event in await mesh.timeline(third.id))
        await restored(mesh, database)
    async with opened(path) as mesh:
        fourth = await mesh.until_over((await mesh.post_mission()).id)
        assert min(event.id for event in await mesh.timeline(fourth.id)) > newest


async def test_a_running_mission_refuses_a_restore_and_goes_on(path: Path) -> None:
    async with opened(path) as mesh:
        database = await snapshot(mesh)
        mission = await mesh.post_mission()
        await mesh.until_state(MissionState.SCANNING)
        for dry_run in (True, False):
            answer = await mesh.client.post("/restore", content=database, params={"dry_run": dry_run})
            assert (answer.status_code, answer.json()["code"]) == (409, BackupRefusal.MISSION_ON.value)
        assert (await mesh.until_over(mission.id)).outcome is Outcome.FOUND


async def test_while_it_is_held_nothing_begins_and_a_stop_is_obeyed(path: Path) -> None:
    async with opened(path) as mesh:
        held = await mesh.client.post("/restore/hold", json={"seconds": 60.0})
        assert held.is_success, held.text
        for command in ("find the red bottle", "go to the dock"):
            refused = await mesh.client.post("/missions", json={"command": command})
            assert (refused.status_code, refused.json().get("code")) == (409, BackupRefusal.RESTORING.value)
        stopped = await mesh.client.post("/missions", json={"command": "stop"})
        assert stopped.status_code == 200, stopped.text
        await mesh.client.post("/restore/hold", json={"seconds": 0.0})
        mission = await mesh.post_mission()
        refused = await mesh.client.post("/restore/hold", json={"seconds": 60.0})
        assert (refused.status_code, refused.json()["code"]) == (409, BackupRefusal.MISSION_ON.value)
        assert (await mesh.until_over(mission.id)).outcome is Outcome.FOUND


async def test_a_hold_that_is_let_go_while_it_waits_does_not_come_later(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A command is being read meanwhile: whoever asked for the hold had no answer, gave up, and let go."""
    async with opened(path) as mesh:
        read, reads, may = mesh.inference.parse_task, asyncio.Event(), asyncio.Event()

        async def slowly(request: ParseTaskRequest) -> ParsedTask:
            reads.set()
            await may.wait()
            raise UnavailableError("inference", "not reachable")

        monkeypatch.setattr(mesh.inference, "parse_task", slowly)
        asked = asyncio.create_task(mesh.client.post("/missions", json={"command": "find the red bottle"}))
        await reads.wait()
        hold = asyncio.create_task(mesh.client.post("/restore/hold", json={"seconds": 600.0}))
        for _ in range(200):  # it comes to where it waits
            await asyncio.sleep(0)
        assert (await mesh.client.post("/restore/hold", json={"seconds": 0.0})).is_success
        may.set()
        assert (await hold).status_code == 409
        await asked
        monkeypatch.setattr(mesh.inference, "parse_task", read)
        await mesh.post_mission()


async def test_a_hold_of_somebody_who_died_ends_by_itself(path: Path) -> None:
    async with opened(path) as mesh:
        await mesh.client.post("/restore/hold", json={"seconds": 1.0})
        until_s = mesh.clock.now_s() + 1.0

        async def over() -> bool:
            return mesh.clock.now_s() > until_s

        await mesh.advance_until(over, within_s=5.0)
        await mesh.post_mission()


async def test_a_back_up_of_a_running_mission_ends_it_as_interrupted_where_it_is_restored(path: Path) -> None:
    async with opened(path) as mesh:
        mission = await mesh.post_mission()
        await mesh.until_state(MissionState.SCANNING)
        database = await snapshot(mesh)
        assert (await mesh.until_over(mission.id)).outcome is Outcome.FOUND
        await restored(mesh, database)
        told = await mesh.mission(mission.id)
        assert told.outcome is Outcome.INTERRUPTED
        assert (await mesh.timeline(mission.id))[-1].data.outcome is Outcome.INTERRUPTED
        assert (await mesh.client.get("/state")).json()["state"] == "IDLE"


async def test_a_mission_that_begins_while_a_back_up_is_being_sent_goes_on(path: Path) -> None:
    async with opened(path) as mesh:
        database, begun = await snapshot(mesh), asyncio.Event()

        async def slow() -> AsyncIterator[bytes]:
            yield database[:5000]
            mission = await mesh.post_mission()
            begun.set()
            assert mission.outcome is None
            yield database[5000:]

        answer = await mesh.client.post("/restore", content=slow())
        assert begun.is_set()
        assert (answer.status_code, answer.json()["code"]) == (409, BackupRefusal.MISSION_ON.value)
        (mission,) = (await mesh.client.get("/missions")).json()
        assert (await mesh.until_over(mission["id"])).outcome is Outcome.FOUND


def files(folder: Path) -> set[str]:
    return {one.name for one in folder.iterdir()}


def statements(*some: str) -> Callable[[Path], None]:
    def change(place: Path) -> None:
        with closing(sqlite3.connect(place)) as connection:
            connection.executescript(";".join(some))

    return change


def recorded(part: bytes) -> Callable[[Path], None]:
    def change(place: Path) -> None:
        with closing(sqlite3.connect(place)) as connection, connection:
            connection.execute("UPDATE recordings SET lines = ?", (zlib.compress(part, 9),))

    return change


HOSTILE: dict[str, tuple[Callable[[Path], None], str]] = {
    "memory's tables": (
        statements("DROP TABLE missions", "CREATE TABLE views (id INTEGER)"),
        "tables are not ours: missions, views",
    ),
    "no JSON": (statements("UPDATE missions SET record = 'x'"), "does not understand"),
    "a state nobody knows": (
        statements('UPDATE missions SET record = replace(record, \'"state":"\', \'"state":"FLYING_\')'),
        "does not understand",
    ),
    "another's record": (statements("UPDATE missions SET id = 'other'"), "under another name"),
    "an event of another number": (statements("UPDATE events SET id = id + 1000000"), "under another number"),
    "a recording that cannot be unpacked": (statements("UPDATE recordings SET lines = x'00'"), "cannot be unpacked"),
    "a recording that unpacks to more than any": (recorded(bytes(300_000_000)), "larger than any of ours"),
    "a recording of more lines than any": (recorded(b"x\n" * 6_000_000), "larger than any of ours"),
    "a recording that is no text": (recorded(b"\xff\xfe"), "does not understand"),
    "a number that no event can have": (
        statements("INSERT INTO numbering (name, next) VALUES ('events', 9007199254740000)"),
        "numbered higher than any of ours",
    ),
    "a newer schema": (statements("UPDATE alembic_version SET version_num = '7777'"), "7777 of a newer program"),
}


@pytest.mark.parametrize("kind", HOSTILE)
async def test_what_is_no_sound_history_is_refused_and_changes_nothing(path: Path, tmp_path: Path, kind: str) -> None:
    async with opened(path) as mesh:
        await mesh.until_over((await mesh.post_mission()).id)
        await mesh.until_state(MissionState.IDLE)
        before = await history(mesh)
        place = tmp_path / "sent.db"
        place.write_bytes(await snapshot(mesh))
        change, said = HOSTILE[kind]
        change(place)
        answer = await mesh.client.post("/restore", content=place.read_bytes())
        assert answer.status_code == 422, answer.text
        assert said in answer.json()["detail"]
        assert await history(mesh) == before
        assert files(tmp_path) <= {"sent.db", *(f"coordinator.db{end}" for end in ("", "-wal", "-shm"))}


class HeldUp:
    """Stands in for `SqliteFile.replace`: copies only when it is let."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.begun, self.go_on = threading.Event(), threading.Event()
        replace = SqliteFile.replace

        def held_up(file: SqliteFile, candidate: JudgedDatabase) -> Path:
            self.begun.set()
            assert self.go_on.wait(30.0)
            return replace(file, candidate)

        monkeypatch.setattr(SqliteFile, "replace", held_up)


def mission(name: str) -> Mission:
    return Mission(id=name, command="find it", state=MissionState.IDLE, outcome=Outcome.FOUND, started_s=1.0)


async def missions_in(path: Path) -> list[str]:
    log = SqliteLog(Settings.model_validate({"database_url": f"sqlite:///{path}"}))
    async with writing(log):
        return [one.id for one in await log.newest(10)]


@asynccontextmanager
async def writing(log: SqliteLog) -> AsyncGenerator[None]:
    await log.open(0.0)
    task = asyncio.create_task(log.write_forever())
    try:
        yield
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        await log.aclose()


@pytest.mark.parametrize("cancelled", [True, False])
async def test_what_comes_during_a_restore_does_not_follow_into_what_is_restored(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, cancelled: bool
) -> None:
    """Also when the server that was asked is told to stop."""
    other = SqliteLog(Settings.model_validate({"database_url": f"sqlite:///{tmp_path / 'other.db'}", "flush_s": 0.0}))
    async with writing(other):
        other.upsert(mission("restored"))
        with (await other.snapshot()).file as file:
            database = file.read()
    held_up = HeldUp(monkeypatch)
    log = SqliteLog(Settings.model_validate({"database_url": f"sqlite:///{path}", "flush_s": 0.0}))

    async def body() -> AsyncIterator[bytes]:
        yield database

    async def restore() -> None:
        async with log.candidate(body(), bytes_max=10**8) as candidate:
            await log.replace(candidate, 1.0)

    async with writing(log):
        log.upsert(mission("before"))
        restoring = asyncio.create_task(restore())
        await asyncio.to_thread(held_up.begun.wait, 30.0)
        if cancelled:
            restoring.cancel()
            await asyncio.wait({restoring}, timeout=0.02)
        log.upsert(mission("late"))
        asyncio.get_running_loop().call_later(0.05, held_up.go_on.set)
        if not cancelled:
            await restoring
    await asyncio.gather(restoring, return_exceptions=True)
    assert restoring.cancelled() is cancelled
    assert await missions_in(path) == ["restored"]
