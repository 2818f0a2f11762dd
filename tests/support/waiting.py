"""Waiting on a condition instead of sleeping for a time."""

import asyncio
from collections.abc import Awaitable, Callable


async def until(condition: Callable[[], bool], *, timeout_s: float = 45.0) -> None:
    """Returns as soon as `condition()` holds; fails the test when it never does."""
    async with asyncio.timeout(timeout_s):
        while not condition():  # noqa: ASYNC110 - the condition has no event of its own
            await asyncio.sleep(0.01)


async def until_true(condition: Callable[[], Awaitable[bool]], *, timeout_s: float = 45.0) -> None:
    """The same for a condition that has to be asked for."""
    async with asyncio.timeout(timeout_s):
        while not await condition():  # noqa: ASYNC110 - it has no event of its own
            await asyncio.sleep(0.02)
