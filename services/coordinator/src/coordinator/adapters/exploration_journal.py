"""What explorations know of each home, in an SQLite file of its own: written once an action, behind the event loop."""

import asyncio
from collections.abc import AsyncIterable
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Final

import structlog
from pydantic import ValidationError
from sqlalchemy import Column, Connection, MetaData, Table, Text, select
from sqlalchemy.dialects.sqlite import insert

from contracts.exploration import ExplorationMemory
from mesh.errors import UnavailableError
from store.connections import Connections
from store.copies import DatabaseCopy, JudgedDatabase
from store.finishing import finished
from store.sqlite_file import SqliteFile

log = structlog.get_logger()

MIGRATIONS: Final = Path(__file__).with_name("exploration_migrations")
PRAGMAS: Final = ("PRAGMA synchronous = NORMAL",)  # a power cut may take the last action; a killed process takes none
AGAIN_S: Final = 1.0

explorations = Table(
    "explorations",
    MetaData(),
    Column("home", Text, primary_key=True),  # robot_bridge's name of the map
    Column("memory", Text, nullable=False),  # contracts.exploration.ExplorationMemory, JSON
)
_NEW = insert(explorations)
_KEEP = _NEW.on_conflict_do_update(index_elements=[explorations.c.home], set_={"memory": _NEW.excluded.memory})


class ExplorationJournal:
    """The port `CopiedJournal`. Keep `write_forever()` running. Of what waits to be written, a home's newest counts."""

    def __init__(self, file: Path, *, busy_timeout_s: float) -> None:
        database = SqliteFile(file, MIGRATIONS, pragmas=PRAGMAS, busy_timeout_s=busy_timeout_s)
        self._connections = Connections(database, readers=1, busy_timeout_s=busy_timeout_s)
        self._waiting: dict[str, ExplorationMemory] = {}
        self._news = asyncio.Event()
        self._file_is_ours = asyncio.Lock()
        """Held while it is written, and while it becomes another one."""
        self._trouble = ""

    async def read(self, home: str) -> ExplorationMemory:
        """Empty for a home that is not known, and for a record that an older version of this program left and this one
        does not understand. Raises `UnavailableError`."""
        if home in self._waiting:
            return self._waiting[home]

        def work(connection: Connection) -> str | None:
            return connection.execute(select(explorations.c.memory).where(explorations.c.home == home)).scalar()

        record = await self._connections.read(work)
        if record is None:
            return ExplorationMemory()
        try:
            return ExplorationMemory.model_validate_json(record)
        except ValidationError as error:
            log.warning("what was explored of a home is not understood: it begins anew", home=home, error=str(error))
            return ExplorationMemory()

    def write(self, home: str, memory: ExplorationMemory) -> None:
        self._waiting[home] = memory
        self._news.set()

    async def write_forever(self) -> None:
        while True:
            await self._news.wait()
            self._news.clear()
            try:
                await self.flush()
            except UnavailableError as error:
                if error.detail != self._trouble:
                    log.warning("what was explored cannot be written; trying again", error=error.detail)
                self._trouble = error.detail
                self._news.set()
                await asyncio.sleep(AGAIN_S)

    async def flush(self) -> None:
        """What could not be written stays to be written. Raises `UnavailableError`."""
        async with self._file_is_ours:
            await self._write_what_waits()

    async def _write_what_waits(self) -> None:
        waiting, self._waiting = self._waiting, {}
        rows = [{"home": home, "memory": memory.model_dump_json()} for home, memory in waiting.items()]
        if not rows:
            return

        def work(connection: Connection) -> None:
            connection.execute(_KEEP, rows)

        try:
            await self._connections.write(work)
        except UnavailableError:
            self._waiting = {**waiting, **self._waiting}
            raise
        self._trouble = ""

    async def snapshot(self) -> DatabaseCopy:
        """What waits to be written is in it. Raises `UnavailableError`, and `ConflictError` while another is made."""
        await self.flush()
        return await self._connections.snapshot()

    def candidate(self, body: AsyncIterable[bytes], *, bytes_max: int) -> AbstractAsyncContextManager[JudgedDatabase]:
        """Raises `TooLargeError`, and `UnprocessableError` for what cannot be this database."""
        return self._connections.candidate(body, bytes_max=bytes_max, reads=_every_home)

    async def replace(self, candidate: JudgedDatabase) -> str:
        """What is told meanwhile is of the time before, and is not kept. Once begun it is finished, also when it is
        cancelled. Raises `UnavailableError`: nothing has changed."""
        await self.flush()  # what was there before is kept whole
        return await finished(self._exchange(candidate))

    async def _exchange(self, candidate: JudgedDatabase) -> str:
        async with self._file_is_ours:
            kept = await self._connections.replace(candidate)
            self._waiting.clear()
        return kept

    async def aclose(self) -> None:
        try:
            await self.flush()
        except UnavailableError as error:
            log.warning("the end of what was explored could not be written", error=error.detail)
        await self._connections.aclose()


def _every_home(connection: Connection) -> None:
    """A `store.backup.Reads`. A record that this program does not understand is no reason to refuse the others: `read`
    has its home begin anew, as it did where the back-up was made."""
    for row in connection.execute(select(explorations)):
        try:
            ExplorationMemory.model_validate_json(row.memory)
        except ValidationError as error:
            log.warning("what was explored of a home is not understood", home=row.home[:64], error=str(error)[:200])
