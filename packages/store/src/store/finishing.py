"""What must not be left halfway."""

import asyncio
from collections.abc import Awaitable
from typing import TypeVar

T = TypeVar("T")


async def finished(work: Awaitable[T]) -> T:
    """What `work` gives. Who is cancelled meanwhile is so only once it is over: a thread cannot be cancelled, and what
    it works on must not be taken away from under it."""
    doing = asyncio.ensure_future(work)
    stopped: asyncio.CancelledError | None = None
    while not doing.done():
        try:
            await asyncio.wait({doing})
        except asyncio.CancelledError as error:
            stopped = error
    if stopped is not None:
        raise stopped from (None if doing.cancelled() else doing.exception())
    return doing.result()
