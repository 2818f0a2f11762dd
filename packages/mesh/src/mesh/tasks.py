"""Owns background tasks: when one dies the process ends, so that its supervisor starts it again."""

import asyncio
import os
import signal
from collections.abc import Callable, Coroutine
from types import TracebackType
from typing import Any, Self

import structlog

log = structlog.get_logger()


def end_this_process() -> None:
    os.kill(os.getpid(), signal.SIGTERM)


class Tasks:
    """`async with Tasks() as tasks: tasks.start("loop", loop())`; leaving the block cancels and awaits them all."""

    def __init__(self, *, on_death: Callable[[], None] = end_this_process) -> None:
        self._on_death = on_death
        self._running: set[asyncio.Task[Any]] = set()
        self._closing = False

    def start(self, name: str, coroutine: Coroutine[Any, Any, Any], *, forever: bool = True) -> asyncio.Task[Any]:
        """`forever` tasks must not end by themselves; others may return, but not raise."""
        task = asyncio.create_task(coroutine, name=name)
        self._running.add(task)
        task.add_done_callback(lambda done: self._ended(done, forever=forever))
        return task

    def _ended(self, task: asyncio.Task[Any], *, forever: bool) -> None:
        self._running.discard(task)
        if self._closing or task.cancelled():
            return
        error = task.exception()
        if error is None and not forever:
            return
        log.error("a background task died; ending the process", task=task.get_name(), exc_info=error)
        self._on_death()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._closing = True
        tasks = list(self._running)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
