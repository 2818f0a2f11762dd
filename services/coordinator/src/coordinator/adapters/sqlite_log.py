"""The mission log in an SQLite file: written behind the back of the event loop, in batches, oldest first."""

import asyncio
import zlib
from collections import OrderedDict, defaultdict
from collections.abc import AsyncIterable, AsyncIterator, Sequence
from contextlib import AbstractAsyncContextManager
from typing import Any

import structlog
from sqlalchemy import Connection, Executable, Row, delete, func, select
from sqlalchemy.dialects.sqlite import insert

from contracts.mission import Mission, MissionEvent
from contracts.problem import Dependency
from coordinator.adapters.history_records import everything, next_event_id, number_on, parts, unpacked
from coordinator.adapters.interrupted import interrupted, line_of
from coordinator.adapters.tables import MIGRATIONS, events, missions, pictures, recordings, requests
from coordinator.adapters.tail import EventTail
from coordinator.ports import KnownRequest
from coordinator.settings import Settings
from mesh.errors import NotFoundError, UnavailableError
from store.connections import Connections
from store.copies import DatabaseCopy, JudgedDatabase
from store.finishing import finished
from store.sqlite_file import SqliteFile

log = structlog.get_logger()

TAIL = 2000
RECENT = 100
PENDING_MAX = 50_000
SAVED_WITHIN_S = 20.0
AGAIN_S = 1.0
OPEN_AGAIN_S = 10.0
READERS = 2
# WAL with NORMAL: safe against a killed process; a power cut may take the last second, which a history can bear.
PRAGMAS = ("PRAGMA synchronous = NORMAL",)

Write = tuple[Executable, list[dict[str, Any]]]

_EVENT = insert(events)
_NEW = insert(missions)
_MISSION = _NEW.on_conflict_do_update(
    index_elements=[missions.c.id], set_={"over": _NEW.excluded.over, "record": _NEW.excluded.record}
)


class SqliteLog:
    """The port `MissionLog`. `await open()` first, then keep `write_forever()` running.

    A file that cannot be opened is left alone and named in `dependency`; `write_forever` tries it again.
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        file = SqliteFile(
            settings.database_file, MIGRATIONS, pragmas=PRAGMAS, busy_timeout_s=settings.busy_timeout_s
        )  # fmt: skip
        self._connections = Connections(file, readers=READERS, busy_timeout_s=settings.busy_timeout_s)
        self._tail = EventTail(TAIL)
        self._recent: OrderedDict[str, Mission] = OrderedDict()
        self._pending: list[Write] = []
        self._lines: defaultdict[str, list[str]] = defaultdict(list)
        self._next_event_id = 0
        self._news = asyncio.Event()
        self._hurry = asyncio.Event()
        self._turned = asyncio.Condition()
        self._file_is_ours = asyncio.Lock()
        """Held while it is written, and while it becomes another one: rows of the old one never follow into the new."""
        self._written = 0
        self._asked = 0
        self._opened = False
        """Before it, nothing is queued: events have no number in the file yet."""
        self._beheaded: set[str] = set()
        """Missions whose recordings would lack their beginning."""
        self._started_s = 0.0
        self._trouble = "not opened yet"

    async def open(self, now_s: float) -> None:
        """Makes the file ready, and writes of what was queued or running when the last process ended that it was
        interrupted. Missions of the time before it could be opened are kept; their timelines and recordings are not.
        """
        self._started_s = now_s
        try:
            next_id, left = await self._connections.write(_what_is_there)
        except UnavailableError as error:
            if error.detail != self._trouble:
                log.warning("the history of missions cannot be opened; trying again", error=error.detail)
            self._trouble = error.detail
            return
        self._opened, self._trouble = True, ""
        self._next_event_id = max(self._next_event_id, next_id)
        meanwhile = tuple(self._recent.values())
        for record in left:
            mission = interrupted(Mission.model_validate_json(record), now_s)
            self.upsert(mission)
            self.append(line_of(mission, self._next_event_id, now_s))
        for mission in meanwhile:
            self.upsert(mission)
        self._forget_the_oldest()

    async def aclose(self) -> None:
        """Writes what is left, then closes."""
        try:
            await self._flush()
        except UnavailableError as error:
            log.warning("the end of the history could not be written", error=error.detail)
        await self._connections.aclose()

    # writing

    @property
    def opened(self) -> bool:
        return self._opened

    @property
    def next_event_id(self) -> int:
        return self._next_event_id

    def upsert(self, mission: Mission) -> None:
        self._recent[mission.id] = mission
        self._recent.move_to_end(mission.id)
        while len(self._recent) > RECENT:
            self._recent.popitem(last=False)
        over = mission.outcome is not None
        self._write(_MISSION, id=mission.id, over=over, record=mission.model_dump_json())
        if over and self._opened:
            self._forget_the_oldest()

    def append(self, event: MissionEvent) -> None:
        self._next_event_id = event.id + 1
        self._tail.append(event)
        self._write(_EVENT, id=event.id, mission_id=event.mission_id, line=event.model_dump_json())

    def record(self, mission_id: str, line: str) -> None:
        if not self._opened:
            self._beheaded.add(mission_id)
        elif mission_id not in self._beheaded:
            self._lines[mission_id].append(line)
            self._news.set()

    def keep_picture(self, mission_id: str, number: int, jpeg: bytes) -> None:
        self._write(
            insert(pictures).on_conflict_do_nothing(), mission_id=mission_id, number=number, jpeg=jpeg,
        )  # fmt: skip

    def keep_request(self, key: str, request: KnownRequest) -> None:
        ids = " ".join(request.mission_ids)
        self._write(insert(requests).on_conflict_do_nothing(), key=key, digest=request.digest, mission_ids=ids)

    async def flushed(self) -> None:
        self._asked += 1
        wanted = self._asked
        self._news.set()
        self._hurry.set()
        try:
            async with asyncio.timeout(SAVED_WITHIN_S), self._turned:
                await self._turned.wait_for(lambda: self._written >= wanted or self._trouble != "")
        except TimeoutError as error:
            raise UnavailableError("database", "it did not write in time") from error
        if self._written < wanted:
            raise UnavailableError("database", self._trouble)

    async def write_forever(self) -> None:
        while not self._opened:
            await asyncio.sleep(OPEN_AGAIN_S)
            await self.open(self._started_s)
        while True:
            await self._news.wait()
            try:
                async with asyncio.timeout(self._settings.flush_s):
                    await self._hurry.wait()
            except TimeoutError:
                pass
            self._news.clear()
            self._hurry.clear()
            asked = self._asked
            try:
                await self._flush()
            except UnavailableError as error:
                if error.detail != self._trouble:
                    log.warning("the history cannot be written; trying again", error=error.detail)
                self._trouble = error.detail
            else:
                self._written, self._trouble = asked, ""
            async with self._turned:
                self._turned.notify_all()
            if self._trouble:
                self._news.set()
                await asyncio.sleep(AGAIN_S)

    async def _flush(self) -> None:
        """One transaction. What could not be written stays to be written."""
        async with self._file_is_ours:
            await self._write_what_waits()

    async def _write_what_waits(self) -> None:
        writes, self._pending = self._pending, []
        lines, self._lines = self._lines, defaultdict(list)
        chunks = [
            {"mission_id": mission_id, "lines": zlib.compress(part)}
            for mission_id, some in lines.items()
            for part in parts(some)
        ]
        batch: list[Write] = [*writes, (insert(recordings), chunks)] if chunks else writes
        if not batch:
            return

        def work(connection: Connection) -> None:
            for statement, rows in batch:
                connection.execute(statement, rows or None)

        try:
            await self._connections.write(work)
        except UnavailableError:
            self._pending = [*batch, *self._pending][-PENDING_MAX:]
            raise

    def _write(self, statement: Executable, **row: Any) -> None:
        """Rows of one statement in a row go together."""
        if not self._opened:
            return
        if self._pending and self._pending[-1][0] is statement:
            self._pending[-1][1].append(row)
        else:
            self._pending.append((statement, [row]))
        if len(self._pending) > PENDING_MAX:
            del self._pending[0]
        self._news.set()

    def _forget_the_oldest(self) -> None:
        kept = self._settings
        self._drop(missions, missions.c.number, kept.missions_kept)
        self._drop(events, events.c.id, kept.events_kept)
        for table in (recordings, pictures):
            newest = select(missions.c.id).order_by(missions.c.number.desc()).limit(kept.recordings_kept)
            self._pending.append((delete(table).where(table.c.mission_id.not_in(newest)), []))

    def _drop(self, table: Any, number: Any, kept: int) -> None:
        last = select(func.max(number)).scalar_subquery()
        self._pending.append((delete(table).where(number <= last - kept), []))

    # reading

    async def get(self, mission_id: str) -> Mission | None:
        if mission_id in self._recent:
            return self._recent[mission_id]
        rows = await self._read(select(missions.c.record).where(missions.c.id == mission_id))
        return Mission.model_validate_json(rows[0].record) if rows else None

    async def newest(self, limit: int, *, before: str | None = None) -> tuple[Mission, ...]:
        query = select(missions.c.record).order_by(missions.c.number.desc()).limit(limit)
        if before is not None:
            rows = await self._read(select(missions.c.number).where(missions.c.id == before))
            if not rows:
                raise NotFoundError(f"no mission {before[:64]}")
            query = query.where(missions.c.number < rows[0].number)
        return tuple(Mission.model_validate_json(row.record) for row in await self._read(query))

    async def events(self, mission_id: str, *, after: int, limit: int) -> tuple[MissionEvent, ...]:
        query = select(events.c.line).where(events.c.mission_id == mission_id, events.c.id > after)
        rows = await self._read(query.order_by(events.c.id).limit(limit))
        return tuple(MissionEvent.model_validate_json(row.line) for row in rows)

    def follow(self, *, after: int | None) -> AsyncIterator[MissionEvent]:
        return self._tail.follow(self._next_event_id - 1 if after is None else after, self._older)

    async def _older(self, after: int, limit: int) -> tuple[MissionEvent, ...]:
        rows = await self._read(select(events.c.line).where(events.c.id > after).order_by(events.c.id).limit(limit))
        return tuple(MissionEvent.model_validate_json(row.line) for row in rows)

    async def recording(self, mission_id: str) -> tuple[str, ...]:
        chosen = select(recordings.c.lines).where(recordings.c.mission_id == mission_id)
        rows = await self._read(chosen.order_by(recordings.c.number))
        return tuple(line for row in rows for line in unpacked(row.lines).split("\n"))

    async def picture(self, mission_id: str, number: int) -> bytes | None:
        chosen = select(pictures.c.jpeg).where(pictures.c.mission_id == mission_id, pictures.c.number == number)
        rows = await self._read(chosen)
        return rows[0].jpeg if rows else None

    async def request(self, key: str) -> KnownRequest | None:
        rows = await self._read(select(requests).where(requests.c.key == key))
        return KnownRequest(rows[0].digest, tuple(rows[0].mission_ids.split())) if rows else None

    # back-up

    async def snapshot(self) -> DatabaseCopy:
        await self.flushed()
        return await self._connections.snapshot()

    def candidate(self, body: AsyncIterable[bytes], *, bytes_max: int) -> AbstractAsyncContextManager[JudgedDatabase]:
        return self._connections.candidate(body, bytes_max=bytes_max, reads=everything)

    async def replace(self, candidate: JudgedDatabase, now_s: float) -> str:
        """What comes meanwhile is not kept: its numbers could be taken already in what is restored. Once begun it is
        finished, also when it is cancelled."""
        await self.flushed()
        kept = await finished(self._exchange(candidate, now_s))
        await self.flushed()
        return kept

    async def _exchange(self, candidate: JudgedDatabase, now_s: float) -> str:
        async with self._file_is_ours:
            self._opened = False
            try:
                await asyncio.to_thread(number_on, candidate.path, self._next_event_id)  # with it, or not at all
                kept = await self._connections.replace(candidate)
            except asyncio.CancelledError:  # the loop ends: what waits must not follow into what may be another file
                self._forget_what_waits()
                raise
            except Exception:
                self._opened = True
                raise
            self._recent.clear()
            self._forget_what_waits()
            self._beheaded.clear()
            self._tail.clear()
            await self.open(now_s)
        if not self._opened:
            raise UnavailableError("database", f"it is restored, but not open: {self._trouble}; start it again")
        return kept

    def _forget_what_waits(self) -> None:
        self._pending.clear()
        self._lines.clear()

    async def dependency(self) -> Dependency:
        return Dependency.of("database", ok=self._trouble == "", detail=self._trouble[:200])

    async def _read(self, query: Any) -> Sequence[Row[Any]]:
        """What was written before is seen."""
        await self.flushed()
        return await self._connections.read(lambda connection: connection.execute(query).all())


def _what_is_there(connection: Connection) -> tuple[int, list[str]]:
    """The next event's id, and the records of missions that are not over."""
    left = connection.execute(select(missions.c.record).where(~missions.c.over)).all()
    return next_event_id(connection), [row.record for row in left]
