"""What explorations remember, kept in memory. Its twin is `coordinator.adapters.exploration_journal`."""

import asyncio
from collections.abc import AsyncIterable
from contextlib import AbstractAsyncContextManager

from contracts.exploration import ExplorationMemory
from mesh.errors import UnavailableError, UnprocessableError
from store.copies import DatabaseCopy, JudgedDatabase


class KeptHomes:
    """The port `CopiedJournal`. `away`: nothing can be read; while `held` is clear a read waits."""

    def __init__(self) -> None:
        self.of: dict[str, ExplorationMemory] = {}
        self.away = False
        self.held = asyncio.Event()
        self.held.set()

    async def read(self, home: str) -> ExplorationMemory:
        await self.held.wait()
        if self.away:
            raise UnavailableError("journal", "is away")
        return self.of.get(home, ExplorationMemory())

    def write(self, home: str, memory: ExplorationMemory) -> None:
        self.of[home] = memory

    async def snapshot(self) -> DatabaseCopy:
        raise UnprocessableError("a dict has no back-up")

    def candidate(self, body: AsyncIterable[bytes], *, bytes_max: int) -> AbstractAsyncContextManager[JudgedDatabase]:
        raise UnprocessableError("a dict has no back-up")

    async def replace(self, candidate: JudgedDatabase) -> str:
        raise UnprocessableError("a dict has no back-up")
