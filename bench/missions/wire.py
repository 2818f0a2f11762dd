"""A call to another service over a bad line: late, lost on the way there or back, or refused while it is down."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import TypeVar

import numpy as np

from bench.world.faults import Faults
from mesh.errors import ServiceTimeoutError, UnavailableError

T = TypeVar("T")

TIMEOUT_S = 5.0


class Wire:
    """To one service. `started_s` is the mission's start: outages count from there."""

    def __init__(self, service: str, faults: Faults, rng: np.random.Generator) -> None:
        self.service = service
        self.started_s = float("inf")
        self._faults = faults
        self._rng = rng

    @property
    def down(self) -> bool:
        return self._faults.down(self.service, asyncio.get_running_loop().time() - self.started_s)

    async def call(self, work: Callable[[], Awaitable[T]], *, timeout_s: float = TIMEOUT_S) -> T:
        self._refuse()
        try:
            async with asyncio.timeout(timeout_s):
                return await self._carried(work, timeout_s)
        except TimeoutError as error:
            raise ServiceTimeoutError(self.service, f"no answer within {timeout_s:.0f} s") from error

    async def _carried(self, work: Callable[[], Awaitable[T]], timeout_s: float) -> T:
        faults, rng = self._faults, self._rng
        late_s = float(rng.uniform(0.0, faults.reply_delay_s_max)) if faults.reply_delay_s_max else 0.0
        lost = bool(faults.reply_lost) and rng.random() < faults.reply_lost
        if lost and rng.random() < 0.5:
            await asyncio.sleep(timeout_s + 1.0)
        await asyncio.sleep(late_s / 2)
        self._refuse()
        reply = await work()
        self._refuse()
        await asyncio.sleep(late_s / 2)
        if lost:
            await asyncio.sleep(timeout_s + 1.0)
        return reply

    def _refuse(self) -> None:
        if self.down:
            raise UnavailableError(self.service, "connection refused")
