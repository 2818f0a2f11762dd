"""Keeps the newest value of a stream, and lets readers wait for a newer one."""

import asyncio
from typing import Generic, TypeVar

T = TypeVar("T")


class Newest(Generic[T]):
    """Newest wins; nothing queues. Values are told apart by the stamp they were put with."""

    def __init__(self) -> None:
        self._changed = asyncio.Condition()
        self.value: tuple[float, T] | None = None

    async def put(self, stamp_s: float, value: T) -> None:
        async with self._changed:
            self.value = (stamp_s, value)
            self._changed.notify_all()

    async def other_than(self, stamp_s: float | None, *, wait_s: float) -> tuple[float, T] | None:
        """The newest value if its stamp is not `stamp_s`, waited for up to `wait_s` seconds; else none.

        "Other", not "later": when the robot's clock starts again, the page must not wait for the old time.
        """
        try:
            async with asyncio.timeout(wait_s), self._changed:
                await self._changed.wait_for(lambda: self.value is not None and self.value[0] != stamp_s)
                return self.value
        except TimeoutError:
            return None
