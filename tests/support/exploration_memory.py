"""What explorations remember, kept in memory. Its twin is `coordinator.adapters.exploration_journal`."""

import asyncio

from contracts.exploration import ExplorationMemory
from mesh.errors import UnavailableError


class KeptHomes:
    """The port `Journal`. `away`: nothing can be read; while `held` is clear a read waits."""

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
