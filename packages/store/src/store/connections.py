"""One writing connection and a few reading ones, in threads beside the event loop."""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from sqlalchemy import Connection

from mesh.errors import UnavailableError
from store.database import CHECK_S, Database, naming_the_database

T = TypeVar("T")


class Connections:
    """Opens at first use, and again later when that failed (locked, read-only, away).

    Everything here raises `UnavailableError` when the database cannot be had.
    """

    def __init__(self, database: Database, *, readers: int, busy_timeout_s: float) -> None:
        self._database = database
        self._busy_timeout_s = busy_timeout_s
        self._prepared = False
        self._preparing = asyncio.Lock()
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
