"""One thread for the models: calls take turns, and only so many may wait."""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import ParamSpec, TypeVar

from mesh.errors import TooManyError

P = ParamSpec("P")
T = TypeVar("T")


class Worker:
    """First come, first served, by one thread: the models are not thread-safe, and two cores have no use for two."""

    def __init__(self, waiting_max: int) -> None:
        self._pool = ThreadPoolExecutor(max_workers=1, thread_name_prefix="models")
        self._waiting_max = waiting_max
        self._waiting = 0

    async def run(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Raises `TooManyError` instead of queueing more than `waiting_max` calls."""
        if self._waiting >= self._waiting_max:
            raise TooManyError(f"{self._waiting} calls already wait for the models")
        return await self.run_in_turn(function, *args, **kwargs)

    async def run_in_turn(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """For what the service itself must get done: never turned away, however many wait."""
        self._waiting += 1
        try:
            return await asyncio.get_running_loop().run_in_executor(self._pool, lambda: function(*args, **kwargs))
        finally:
            self._waiting -= 1

    @property
    def waiting(self) -> int:
        """Calls that wait or run."""
        return self._waiting

    def close(self) -> None:
        """Calls not yet begun are dropped; the one under way ends by itself."""
        self._pool.shutdown(wait=False, cancel_futures=True)
