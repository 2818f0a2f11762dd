"""Time as a dependency: pass a clock in, never call `time` in logic."""

import asyncio
import time
from typing import Protocol


class Clock(Protocol):
    def now_s(self) -> float:
        """Seconds since the Unix epoch; on a simulated clock, seconds since its start."""
        ...

    async def sleep(self, seconds: float) -> None: ...


class SystemClock:
    """Wall time that never runs backwards: the epoch is read once, then the monotonic clock counts on."""

    def __init__(self) -> None:
        self._offset_s = time.time() - time.monotonic()

    def now_s(self) -> float:
        return self._offset_s + time.monotonic()

    async def sleep(self, seconds: float) -> None:
        await asyncio.sleep(seconds)
