"""An in-memory bus with the behaviour of `mesh.bus.RedisBus`; one suite runs over both (tests/integration/mesh)."""

import asyncio
from collections import defaultdict
from collections.abc import Awaitable, Callable
from typing import Any

from contracts.base import Message
from contracts.topics import M, Topic, traceparent_of
from mesh.tracing import following, traceparent


class MemoryBus:
    """Every listener gets each message in order; kept topics greet a late listener; `published` is there to look at."""

    def __init__(self) -> None:
        self.connected = True
        self.published: list[tuple[str, Message]] = []
        self._said_in: list[tuple[str, str]] = []
        self._kept: dict[str, bytes] = {}
        self._listeners: dict[str, list[asyncio.Queue[bytes]]] = defaultdict(list)

    async def publish(self, topic: Topic[M], message: M) -> bool:
        if not self.connected:
            return False
        data = topic.encode(message, traceparent())
        self.published.append((topic.name, message))
        self._said_in.append((topic.name, traceparent()))
        if topic.kept:
            self._kept[topic.name] = data
        for queue in self._listeners[topic.name]:
            queue.put_nowait(data)
        return True

    def keep(self, topic: Topic[M], message: M) -> None:
        """As if it had been published before anybody listened."""
        self._kept[topic.name] = topic.encode(message)

    async def last(self, topic: Topic[M]) -> M | None:
        data = self._kept.get(topic.name)
        return topic.decode(data) if data is not None else None

    async def listen(self, topic: Topic[M], handler: Callable[[M], Awaitable[None]]) -> None:
        queue: asyncio.Queue[bytes] = asyncio.Queue()
        self._listeners[topic.name].append(queue)
        try:
            if topic.kept and (kept := self._kept.get(topic.name)) is not None:
                queue.put_nowait(kept)
            while True:
                data = await queue.get()
                with following(traceparent_of(data)):
                    await handler(topic.decode(data))
        finally:
            self._listeners[topic.name].remove(queue)

    def listened_to(self, topic: Topic[Any]) -> bool:
        return bool(self._listeners[topic.name])

    def idle(self, topic: Topic[Any]) -> bool:
        """Every listener has taken everything that was published."""
        return all(queue.empty() for queue in self._listeners[topic.name])

    def of(self, topic: Topic[Any]) -> list[Any]:
        """Everything published on a topic so far, oldest first."""
        return [message for name, message in self.published if name == topic.name]

    def said_in(self, topic: Topic[Any]) -> list[str]:
        """The traceparents of everything published on a topic so far, '' where it was said in no trace."""
        return [parent for name, parent in self._said_in if name == topic.name]
