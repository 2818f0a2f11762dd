"""The bus of a world in one process: every message goes through its topic's own JSON, as over Redis."""

import asyncio
from collections import defaultdict
from collections.abc import Awaitable, Callable
from typing import Any

from bench.world.line import Line
from contracts.base import Message
from contracts.topics import M, Topic
from mesh.tracing import following, traceparent

DELAY_S = 0.001


class WorldBus:
    """The port `mesh.bus.Bus`: in order, to each listener, `DELAY_S` after it was said, as far as `line` lets it."""

    connected = True

    def __init__(self, line: Line | None = None) -> None:
        self._line = line or Line()
        self._kept: dict[str, tuple[Message, str]] = {}
        self._listeners: dict[str, list[asyncio.Queue[Any]]] = defaultdict(list)

    async def publish(self, topic: Topic[M], message: M) -> bool:
        if not topic.kept and not self._listeners[topic.name]:
            return True
        heard = topic.decode(topic.encode(message))  # messages are immutable: one decoding does for all
        said = heard, traceparent()
        if topic.kept:
            self._kept[topic.name] = said
        loop = asyncio.get_running_loop()
        for late_s in self._line.copies_s(loop.time()):
            loop.call_later(DELAY_S + late_s, self._deliver, topic.name, said)
        return True

    def _deliver(self, name: str, said: tuple[Message, str]) -> None:
        for queue in self._listeners[name]:
            queue.put_nowait(said)

    async def last(self, topic: Topic[M]) -> M | None:
        kept = self._kept.get(topic.name)
        return kept[0] if kept is not None else None  # type: ignore[return-value] # of a topic only its own messages are kept

    async def listen(self, topic: Topic[M], handler: Callable[[M], Awaitable[None]]) -> None:
        queue: asyncio.Queue[Any] = asyncio.Queue()
        self._listeners[topic.name].append(queue)
        try:
            if topic.kept and (kept := self._kept.get(topic.name)) is not None:
                queue.put_nowait(kept)
            while True:
                message, parent = await queue.get()
                with following(parent):
                    await handler(message)
        finally:
            self._listeners[topic.name].remove(queue)

    def listened_to(self, topic: Topic[Any]) -> bool:
        return bool(self._listeners[topic.name])
