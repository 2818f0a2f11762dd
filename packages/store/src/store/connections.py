"""One writing connection and a few reading ones, in threads beside the event loop."""

import asyncio
from collections.abc import AsyncGenerator, AsyncIterable, Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from pathlib import Path
from typing import BinaryIO, Final, TypeVar
from weakref import WeakSet

from sqlalchemy import Connection

from mesh.errors import ConflictError, TooLargeError, UnavailableError
from store.backup import Reads
from store.copies import DatabaseCopy, JudgedDatabase
from store.database import CHECK_S, Database
from store.finishing import finished
from store.sqlite_file import owners_alone, remove
from store.troubles import naming_the_database

T = TypeVar("T")

SNAPSHOTS_HELD_MAX: Final = 3
"""Each holds as much disk as the database until whoever asked for it has read it, or is let go."""


class Connections:
    """Opens at first use, and again later when that failed (locked, read-only, away).

    Everything here raises `UnavailableError` when the database cannot be had.
    """

    def __init__(self, database: Database, *, readers: int, busy_timeout_s: float) -> None:
        self._database = database
        self._busy_timeout_s = busy_timeout_s
        self._prepared = False
        self._preparing = asyncio.Lock()
        self._copying = asyncio.Lock()
        self._snapshots = WeakSet[BinaryIO]()
        self._writer = database.writer()
        self._reader = database.reader(readers)
        self._writing = ThreadPoolExecutor(1, "database-writer")
        self._reading = ThreadPoolExecutor(readers, "database-reader")

    async def read(self, work: Callable[[Connection], T]) -> T:
        await self._prepare(self._busy_timeout_s)

        def reading_transaction() -> T:
            with naming_the_database(), self._reader.connect() as connection:
                return work(connection)

        return await asyncio.get_running_loop().run_in_executor(self._reading, reading_transaction)

    async def write(self, work: Callable[[Connection], T]) -> T:
        """Once begun it is finished, also when whoever asked for it no longer waits."""
        await self._prepare(self._busy_timeout_s)

        def writing_transaction() -> T:
            with naming_the_database(), self._writer.begin() as connection:
                return work(connection)

        return await asyncio.get_running_loop().run_in_executor(self._writing, writing_transaction)

    async def after_forgetting(self) -> None:
        """What was deleted is no longer in the files either, as far as the system allows."""
        loop = asyncio.get_running_loop()
        await loop.run_in_executor(self._writing, self._database.after_forgetting, self._writer)

    async def snapshot(self) -> DatabaseCopy:
        """The content at one moment; writers go on. Raises `ConflictError` while another copy is being made or
        `SNAPSHOTS_HELD_MAX` are read still, and `UnprocessableError` where the database is no file."""
        await self._prepare(self._busy_timeout_s)
        async with self._alone():
            held = sum(not file.closed for file in self._snapshots)
            if held >= SNAPSHOTS_HELD_MAX:
                raise ConflictError(f"{held} back-ups are being read: wait for the end of one")
            made = await finished(asyncio.to_thread(self._database.snapshot))
            self._snapshots.add(made.file)
            return made

    @asynccontextmanager
    async def candidate(
        self, body: AsyncIterable[bytes], *, bytes_max: int, reads: Reads
    ) -> AsyncGenerator[JudgedDatabase]:
        """What came in `body`, checked, for `replace` inside the block; it is gone afterwards. Besides what `snapshot`
        raises: `TooLargeError`, and `UnprocessableError` for what cannot be this database."""
        await self._prepare(self._busy_timeout_s)
        async with self._alone():
            place = await asyncio.to_thread(self._database.place_for_candidate)
            try:
                await _received(body, place, bytes_max)
                yield await finished(asyncio.to_thread(self._database.judged, place, reads))
            finally:
                remove(place)

    async def replace(self, candidate: JudgedDatabase) -> str:
        """The database becomes the candidate, between two writes; the name of the file that keeps what it was.

        Once begun it is finished before this returns, also when it is cancelled: the candidate must still be there.
        """
        work = self._database.replace
        kept = await finished(asyncio.get_running_loop().run_in_executor(self._writing, work, candidate))
        return kept.name

    @asynccontextmanager
    async def _alone(self) -> AsyncGenerator[None]:
        """One copy at a time: each may be as large as the database."""
        if self._copying.locked():
            raise ConflictError("another back-up or restore is under way")
        async with self._copying:
            yield

    async def size_bytes(self) -> int | None:
        return await asyncio.to_thread(self._database.size_bytes, self._reader)

    async def check(self) -> None:
        """Whether it can be written, known within half a second."""
        if self._preparing.locked():
            raise UnavailableError("database", "is being opened")
        await self._prepare(CHECK_S)
        await asyncio.to_thread(self._database.check_writable)

    async def aclose(self) -> None:
        self._writing.shutdown()
        self._reading.shutdown()
        self._writer.dispose()
        self._reader.dispose()

    async def _prepare(self, patience_s: float) -> None:
        if self._prepared:
            return
        try:
            async with asyncio.timeout(self._busy_timeout_s):
                await self._preparing.acquire()
        except TimeoutError as error:
            raise UnavailableError("database", "is being opened") from error
        try:
            if not self._prepared:
                await asyncio.to_thread(self._database.prepare, patience_s=patience_s)
                self._prepared = True
        finally:
            self._preparing.release()


async def _received(body: AsyncIterable[bytes], place: Path, bytes_max: int) -> None:
    """The file is its owner's alone."""
    size_bytes = 0
    with naming_the_database(), await asyncio.to_thread(owners_alone, place) as file:
        async for part in body:
            size_bytes += len(part)
            if size_bytes > bytes_max:
                raise TooLargeError(f"the limit of a database is {bytes_max} bytes")
            await asyncio.to_thread(file.write, part)
