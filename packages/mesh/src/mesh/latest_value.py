"""The newest value of a stream, for whoever waits for another; nothing queues."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Reading(Generic[T]):
    """A value and when it came, by the clock of whoever put it; wait for *another* `received_s`, not a later one:
    a robot's clock may start again."""

    value: T
    received_s: float

    def age_s(self, now_s: float) -> float:
        return max(0.0, now_s - self.received_s)


class LatestValue(Generic[T]):
    """Written by one thread, read by any; the tasks of one loop may wait on it."""

    def __init__(self) -> None:
        self._newest: Reading[T] | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._waiters: dict[asyncio.Future[None], None] = {}  # in the order of waiting

    @property
    def newest(self) -> Reading[T] | None:
        return self._newest

    @property
    def value(self) -> T | None:
        return self._newest.value if self._newest is not None else None

    def age_s(self, now_s: float) -> float | None:
        """Seconds since the newest reading came; none if there never was one."""
        return self._newest.age_s(now_s) if self._newest is not None else None

    def put(self, value: T, received_s: float) -> None:
        """Replaces the value; safe from any thread."""
        self._newest = Reading(value, received_s)
        loop = self._loop
        if self._waiters and loop is not None and not loop.is_closed():
            loop.call_soon_threadsafe(self._wake)

    async def wait_for(self, wanted: Callable[[Reading[T]], bool], timeout_s: float) -> Reading[T] | None:
        """The first reading that is `wanted`, the present one included; none when `timeout_s` passes."""
        loop = self._loop = asyncio.get_running_loop()
        deadline_s = loop.time() + timeout_s
        while True:
            waiter: asyncio.Future[None] = loop.create_future()
            self._waiters[waiter] = None  # before looking, so that a value put in between is not missed
            try:
                if (newest := self._newest) is not None and wanted(newest):
                    return newest
                remaining_s = deadline_s - loop.time()
                if remaining_s <= 0.0:
                    return None
                await asyncio.wait({waiter}, timeout=remaining_s)
            finally:
                self._waiters.pop(waiter, None)
                waiter.cancel()

    def _wake(self) -> None:
        for waiter in self._waiters:
            if not waiter.done():
                waiter.set_result(None)
