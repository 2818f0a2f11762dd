"""The history of missions: one suite over the log in memory and the one in SQLite, and what only a file can do."""

import asyncio
import contextlib
import json
import sqlite3
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from pathlib import Path

import pytest

from contracts.mission import EventFacts, EventKind, Mission, MissionEvent, MissionState, Outcome
from contracts.vision import Target, Verdict, Vote
from coordinator.adapters import history_records
from coordinator.adapters import sqlite_log as sqlite_log_module
from coordinator.adapters.sqlite_log import SqliteLog
from coordinator.ports import KnownRequest, MissionLog
from coordinator.settings import Settings
from mesh.errors import NotFoundError, UnavailableError
from support.memory_log import MemoryLog
from support.waiting import until_true

NOW_S = 1000.0
Opened = Callable[[], AbstractAsyncContextManager[MissionLog]]


@asynccontextmanager
async def sqlite_log(path: Path, **settings: object) -> AsyncIterator[SqliteLog]:
    log = SqliteLog(Settings.model_validate({"database_url": f"sqlite:///{path}", "flush_s": 0.01, **settings}))
    await log.open(NOW_S)
    writing = asyncio.create_task(log.write_forever())
    try:
        yield log
    finally:
        writing.cancel()
        await asyncio.gather(writing, return_exceptions=True)
        await log.aclose()


@asynccontextmanager
async def memory_log() -> AsyncIterator[MemoryLog]:
    yield MemoryLog()


@pytest.fixture(params=["memory", "sqlite"])
def opened(request: pytest.FixtureRequest, tmp_path: Path) -> Opened:
    return memory_log if request.param == "memory" else lambda: sqlite_log(tmp_path / "missions.db")


def mission(name: str, outcome: Outcome | None = None, **changes: object) -> Mission:
    return Mission.model_validate(
        {"id": name, "command": "find it", "state": MissionState.IDLE, "outcome": outcome, "started_s": 1.0, **changes}
    )


def event(number: int, name: str = "a") -> MissionEvent:
    return MissionEvent(
        id=number, mission_id=name, stamp_s=1.0, state=MissionState.IDLE, kind=EventKind.STATE, text=f"line {number}"
    )


async def take(log: MissionLog, after: int | None, count: int) -> list[int]:
    following = log.follow(after=after)
    return [(await anext(following)).id for _ in range(count)]


async def test_what_was_put_is_read_back_and_replaced_by_its_id(opened: Opened) -> None:
    async with opened() as log:
        log.upsert(mission("a"))
        log.upsert(mission("a", Outcome.FOUND))
        found = await log.get("a")
        assert found is not None
        assert found.outcome is Outcome.FOUND
        assert await log.get("b") is None
        assert [one.id for one in await log.newest(10)] == ["a"]


async def test_missions_come_newest_first_and_a_change_does_not_reorder_them(opened: Opened) -> None:
    async with opened() as log:
        for name in "abcd":
            log.upsert(mission(name))
        log.upsert(mission("a", Outcome.FOUND))
        assert [one.id for one in await log.newest(2)] == ["d", "c"]
        assert [one.id for one in await log.newest(2, before="c")] == ["b", "a"]
        with pytest.raises(NotFoundError):
            await log.newest(2, before="nobody")


async def test_events_come_by_mission_after_an_id_and_at_most_so_many(opened: Opened) -> None:
    async with opened() as log:
        for number in range(6):
            log.append(event(number, "ab"[number % 2]))
        assert [one.id for one in await log.events("b", after=-1, limit=10)] == [1, 3, 5]
        assert [one.id for one in await log.events("b", after=1, limit=1)] == [3]
        assert log.next_event_id == 6


async def test_a_follower_gets_what_it_missed_and_then_what_comes(opened: Opened) -> None:
    async with opened() as log:
        for number in range(3):
            log.append(event(number))
        following = asyncio.create_task(take(log, 0, 3))
        only_new = asyncio.create_task(take(log, None, 1))
        await asyncio.sleep(0)
        log.append(event(3))
        assert await asyncio.wait_for(following, 30.0) == [1, 2, 3]
        assert await asyncio.wait_for(only_new, 30.0) == [3]


async def test_recordings_pictures_and_requests_are_kept(opened: Opened) -> None:
    async with opened() as log:
        log.upsert(mission("a"))
        for k in range(3):
            log.record("a", f'{{"line": {k}}}')
        log.keep_picture("a", 0, b"jpeg")
        log.keep_request("key", KnownRequest("digest", ("a", "b")))
        assert await log.recording("a") == ('{"line": 0}', '{"line": 1}', '{"line": 2}')
        assert await log.recording("b") == ()
        assert (await log.picture("a", 0), await log.picture("a", 1)) == (b"jpeg", None)
        assert await log.request("key") == KnownRequest("digest", ("a", "b"))
        assert await log.request("other") is None
        assert (await log.dependency()).ok


async def test_after_a_restart_what_ran_or_waited_is_interrupted_and_what_was_over_is_not(tmp_path: Path) -> None:
    async with sqlite_log(tmp_path / "missions.db") as log:
        log.upsert(mission("over", Outcome.FOUND))
        log.upsert(mission("ran", state=MissionState.SCANNING, paused=True))
        log.upsert(mission("waited", queue_position=0))
        log.append(event(0, "ran"))
        log.append(event(1, "ran"))
        await log.flushed()
    async with sqlite_log(tmp_path / "missions.db") as log:
        found = {one.id: one for one in await log.newest(10)}
        assert [found[name].outcome for name in ("over", "ran", "waited")] == [
            Outcome.FOUND, Outcome.INTERRUPTED, Outcome.INTERRUPTED,
        ]  # fmt: skip
        assert (found["ran"].paused, found["waited"].queue_position) == (False, None)
        assert found["ran"].report is not None
        assert "while it was SCANNING" in found["ran"].report.cause
        last = (await log.events("ran", after=1, limit=10))[-1]
        assert (last.id, last.data.outcome) == (2, Outcome.INTERRUPTED)
        assert log.next_event_id == 4
        assert await asyncio.wait_for(take(log, -1, 4), 30.0) == [0, 1, 2, 3]


WRITTEN_BEFORE = (
    "queued", "start", "state", "navigation", "motion", "sighting", "depth", "votes", "failure", "dock", "undock",
    "pause", "resume", "stop", "found", "end",
)  # fmt: skip
"""Kinds of a timeline's lines when they were bare strings."""


async def test_a_history_written_before_ends_were_types_still_opens(tmp_path: Path) -> None:
    async with sqlite_log(tmp_path / "missions.db") as log:
        await log.flushed()
    report = {"text": "aborted", "cause": "emergency stop: smoke", "found": None, "candidates": []}
    record = {"id": "old", "command": "find it", "state": "IDLE", "outcome": "aborted", "reason": "aborted",
              "started_s": 1.0, "ended_s": 2.0, "report": report}  # fmt: skip
    with contextlib.closing(sqlite3.connect(tmp_path / "missions.db")) as file, file:
        file.execute("INSERT INTO missions (id, over, record) VALUES ('old', 1, ?)", (json.dumps(record),))
        for number, kind in enumerate(WRITTEN_BEFORE):
            line = {"id": number, "mission_id": "old", "stamp_s": 1.0, "state": "IDLE", "kind": kind, "text": "so"}
            file.execute("INSERT INTO events (id, mission_id, line) VALUES (?, 'old', ?)", (number, json.dumps(line)))
    async with sqlite_log(tmp_path / "missions.db") as log:
        old = await log.get("old")
        assert old is not None
        assert old.report is not None
        assert (old.outcome, old.report.ended_by, old.report.cause) == (Outcome.ABORTED, None, "emergency stop: smoke")
        assert [one.kind.value for one in await log.events("old", after=-1, limit=99)] == list(WRITTEN_BEFORE)


async def test_a_second_restart_changes_nothing_more(tmp_path: Path) -> None:
    async with sqlite_log(tmp_path / "missions.db") as log:
        log.upsert(mission("ran"))
    for _ in range(2):
        async with sqlite_log(tmp_path / "missions.db") as log:
            assert len(await log.events("ran", after=-1, limit=10)) == 1


async def test_a_follower_reads_from_the_file_what_has_left_the_memory(tmp_path: Path) -> None:
    async with sqlite_log(tmp_path / "missions.db") as log:
        for number in range(5000):
            log.append(event(number))
        assert await asyncio.wait_for(take(log, 9, 4990), 30.0) == list(range(10, 5000))


async def test_the_oldest_are_forgotten(tmp_path: Path) -> None:
    async with sqlite_log(tmp_path / "missions.db", missions_kept=3, recordings_kept=1, events_kept=100) as log:
        for k, name in enumerate("abcde"):
            log.upsert(mission(name))
            log.record(name, "{}")
            for number in range(40):
                log.append(event(k * 40 + number, name))
            await log.flushed()
            log.upsert(mission(name, Outcome.FOUND))
        assert [one.id for one in await log.newest(10)] == ["e", "d", "c"]
        assert (await log.recording("c"), await log.recording("e")) == ((), ("{}",))
        assert await log.events("a", after=-1, limit=10) == ()


async def test_a_mission_of_before_in_which_the_target_has_no_colour_gets_it_when_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "missions.db"
    target = Target(label="cup", description="gray cup")
    async with sqlite_log(path) as log:
        log.upsert(mission("a", Outcome.FOUND, target=target))
        await log.flushed()
    with contextlib.closing(sqlite3.connect(path)) as before:
        before.execute("""UPDATE missions SET record = replace(record, '"colour":"grey",', '')""")
        before.commit()
    async with sqlite_log(path) as log:
        read = await log.get("a")
    assert read is not None
    assert read.target == target


BEFORE = {
    "before": "DEPTH_CHECK", "after": "DONE", "outcome": "found", "distance_m": 0.812, "map_xy": [1.5, 2.0], "note": "",
    "votes": [{"voter": "clip", "verdict": "yes", "score": 0.3, "threshold": 0.24, "reason": ""}], "picture": 2,
    "rejected": [{"map_xy": None, "narrow": True, "text": "a cup", "votes": []}], "samples": 3,
}  # fmt: skip
"""What a line of the timeline held beside its words before these facts had a type."""


async def test_a_line_written_before_its_facts_had_a_type_keeps_what_is_known_of_them(tmp_path: Path) -> None:
    path = tmp_path / "missions.db"
    async with sqlite_log(path) as log:
        log.append(event(0))
        await log.flushed()
    with contextlib.closing(sqlite3.connect(path)) as before:
        line = json.dumps(event(0).model_dump(mode="json", exclude={"data"}) | {"data": BEFORE})
        before.execute("UPDATE events SET line = ?", (line,))
        before.commit()
    async with sqlite_log(path) as log:
        (read,) = await log.events("a", after=-1, limit=10)
    vote = Vote(voter="clip", verdict=Verdict.YES, score=0.3, threshold=0.24)
    assert read.data == EventFacts(
        before=MissionState.DEPTH_CHECK, outcome=Outcome.FOUND, distance_m=0.812, votes=(vote,), picture=2
    )


async def test_a_corrupt_file_is_set_aside_and_a_new_history_begins(tmp_path: Path) -> None:
    path = tmp_path / "missions.db"
    path.write_bytes(b"this is no database, not at all. " * 100)
    async with sqlite_log(path) as log:
        assert await log.newest(10) == ()
    assert (tmp_path / "missions.db.corrupt-1").exists()


async def test_a_file_that_is_locked_at_the_start_is_opened_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sqlite_log_module, "OPEN_AGAIN_S", 0.01)
    path = tmp_path / "missions.db"
    async with sqlite_log(path) as log:
        log.upsert(mission("ran"))
    other = sqlite3.connect(path, isolation_level=None)
    other.execute("BEGIN EXCLUSIVE")
    async with sqlite_log(path, busy_timeout_s=0.05) as log:

        async def well() -> bool:
            return (await log.dependency()).ok

        log.append(event(0))
        log.record("meanwhile", "the header")
        log.upsert(mission("meanwhile", Outcome.FOUND))
        assert (log.opened, await well()) == (False, False)
        other.execute("ROLLBACK")
        other.close()
        await until_true(well)
        log.record("meanwhile", "a step")
        assert (log.opened, await log.recording("meanwhile")) == (True, ())
        found = await log.get("ran")
        assert found is not None
        assert found.outcome is Outcome.INTERRUPTED
    async with sqlite_log(path) as log:
        assert {one.id: one.outcome for one in await log.newest(10)} == {
            "ran": Outcome.INTERRUPTED,
            "meanwhile": Outcome.FOUND,
        }


async def test_while_the_file_is_locked_nothing_is_lost_and_its_trouble_is_named(tmp_path: Path) -> None:
    path = tmp_path / "missions.db"
    async with sqlite_log(path, busy_timeout_s=0.05) as log:
        log.upsert(mission("a"))
        await log.flushed()
        other = sqlite3.connect(path, isolation_level=None)
        other.execute("BEGIN IMMEDIATE")
        log.upsert(mission("a", Outcome.FOUND))
        log.append(event(0))

        async def well() -> bool:
            return (await log.dependency()).ok

        with pytest.raises(UnavailableError):
            await log.flushed()
        assert not await well()
        recent = await log.get("a")
        assert recent is not None
        assert recent.outcome is Outcome.FOUND
        other.execute("ROLLBACK")
        other.close()
        await until_true(well)
        assert len(await log.events("a", after=-1, limit=10)) == 1
        assert [one.outcome for one in await log.newest(10)] == [Outcome.FOUND]


async def test_lines_of_a_recording_are_kept_as_they_are_in_parts_that_a_restore_takes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also those with a character in them that other programs end a line at."""
    monkeypatch.setattr(history_records, "PART_LINES_MAX", 3)
    monkeypatch.setattr(history_records, "PART_BYTES_MAX", 20)
    lines = ["a\u2028b", "c\x0bd\x85e", *(f"line {number}" for number in range(20)), "x" * 20]
    async with sqlite_log(tmp_path / "missions.db") as log:
        log.upsert(mission("a"))
        for line in lines:
            log.record("a", line)
        log.record("a", "y" * 21)
        assert list(await log.recording("a")) == lines
        with (await log.snapshot()).file as file:
            database = file.read()

        async def body() -> AsyncIterator[bytes]:
            yield database

        async with log.candidate(body(), bytes_max=10**8) as candidate:
            assert candidate.rows["recordings"] > len(lines) // 3
