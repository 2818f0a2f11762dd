"""The bus of a world in one process: every message goes through its topic's own JSON, as over Redis."""

import asyncio
from collections import defaultdict
from collections.abc import Awaitable, Callable
from typing import Any

from contracts.base import Message
from contracts.topics import M, Topic

DELAY_S = 0.001


class WorldBus:
    """The port `mesh.bus.Bus`: in order, to each listener, `DELAY_S` after it was said."""

    connected = True

    def __init__(self) -> None:
        self._kept: dict[str, Message] = {}
        self._listeners: dict[str, list[asyncio.Queue[Any]]] = defaultdict(list)

    async def publish(self, topic: Topic[M], message: M) -> bool:
        if not topic.kept and not self._listeners[topic.name]:
            return True
        heard = topic.decode(topic.encode(message))  # messages are immutable: one decoding does for all
        if topic.kept:
            self._kept[topic.name] = heard
        asyncio.get_running_loop().call_later(DELAY_S, self._deliver, topic.name, heard)
        return True

    def _deliver(self, name: str, heard: Message) -> None:
        for queue in self._listeners[name]:
            queue.put_nowait(heard)

    async def last(self, topic: Topic[M]) -> M | None:
        return self._kept.get(topic.name)  # type: ignore[return-value] # of a topic only its own messages are kept

    async def listen(self, topic: Topic[M], handler: Callable[[M], Awaitable[None]]) -> None:
        queue: asyncio.Queue[M] = asyncio.Queue()
        self._listeners[topic.name].append(queue)
        try:
            if topic.kept and (kept := await self.last(topic)) is not None:
                await handler(kept)
            while True:
                await handler(await queue.get())
        finally:
            self._listeners[topic.name].remove(queue)

    def listened_to(self, topic: Topic[Any]) -> bool:
        return bool(self._listeners[topic.name])
