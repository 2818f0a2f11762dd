"""A lock that many share, or one holds alone."""

import asyncio
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager


class SharedLock:
    """`shared` blocks run side by side, an `alone` block without any of them. `shared` blocks must not be nested:
    the inner one would wait for whoever waits for the outer one."""

    def __init__(self) -> None:
        self._inside = 0
        self._alone = asyncio.Lock()
        self._changed = asyncio.Condition()

    @asynccontextmanager
    async def shared(self) -> AsyncGenerator[None]:
        async with self._alone:
            self._inside += 1
        try:
            yield
        finally:
            self._inside -= 1
            async with self._changed:
                self._changed.notify_all()

    @asynccontextmanager
    async def alone(self) -> AsyncGenerator[None]:
        """Waits until who is inside has left; who comes meanwhile waits outside."""
        async with self._alone, self._changed:
            await self._changed.wait_for(lambda: self._inside == 0)
            yield
