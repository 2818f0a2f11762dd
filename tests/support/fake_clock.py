"""A clock that stands still until a test advances it."""

import asyncio
import heapq
import itertools

SETTLE_ROUNDS = 12


class FakeClock:
    """Sleepers wake in order of their time; between two of them everything that can run, runs."""

    def __init__(self, now_s: float = 1000.0) -> None:
        self._now_s = now_s
        self._order = itertools.count()
        self._sleepers: list[tuple[float, int, asyncio.Future[None]]] = []

    def now_s(self) -> float:
        return self._now_s

    async def sleep(self, seconds: float) -> None:
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        heapq.heappush(self._sleepers, (self._now_s + max(0.0, seconds), next(self._order), future))
        await future

    async def advance(self, seconds: float) -> None:
        until_s = self._now_s + seconds
        await self.settle()
        while self._sleepers and self._sleepers[0][0] <= until_s:
            wake_s, _, future = heapq.heappop(self._sleepers)
            if not future.done():
                self._now_s = max(self._now_s, wake_s)
                future.set_result(None)
                await self.settle()
        self._now_s = until_s

    async def settle(self) -> None:
        """Lets everything run that can; waits for work that a thread does (tasks named plan-...)."""
        for _ in range(SETTLE_ROUNDS):
            await asyncio.sleep(0)
        while any(task.get_name().startswith("plan-") for task in asyncio.all_tasks()):
            await asyncio.sleep(0.001)
            for _ in range(SETTLE_ROUNDS):
                await asyncio.sleep(0)
