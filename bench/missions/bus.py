"""The bus of a simulated mission: messages may come late, twice, or never."""

import asyncio
from collections import defaultdict
from collections.abc import Awaitable, Callable
from typing import Any

import numpy as np

from bench.world.faults import Faults
from contracts.base import Message
from contracts.topics import M, Topic


class SimulatedBus:
    """The port `mesh.bus.Bus`. Messages are immutable, so they are handed over as they are."""

    connected = True

    def __init__(self, faults: Faults, rng: np.random.Generator) -> None:
        self._faults = faults
        self._rng = rng
        self._kept: dict[str, Message] = {}
        self._listeners: dict[str, list[asyncio.Queue[Any]]] = defaultdict(list)

    def keep(self, topic: Topic[M], message: M) -> None:
        """As if it had been published before anybody listened."""
        self._kept[topic.name] = message

    async def publish(self, topic: Topic[M], message: M) -> bool:
        if topic.kept:
            self._kept[topic.name] = message
        faults, rng = self._faults, self._rng
        if faults.bus_drop and rng.random() < faults.bus_drop:
            return True
        copies = 2 if faults.bus_duplicate and rng.random() < faults.bus_duplicate else 1
        for _ in range(copies):
            late_s = float(rng.uniform(0.0, faults.bus_delay_s_max)) if faults.bus_delay_s_max else 0.0
            if late_s > 0.0:
                asyncio.get_running_loop().call_later(late_s, self._deliver, topic.name, message)
            else:
                self._deliver(topic.name, message)
        return True

    async def last(self, topic: Topic[M]) -> M | None:
        return self._kept.get(topic.name)  # type: ignore[return-value]

    async def listen(self, topic: Topic[M], handler: Callable[[M], Awaitable[None]]) -> None:
        queue: asyncio.Queue[M] = asyncio.Queue()
        self._listeners[topic.name].append(queue)
        try:
            if (kept := await self.last(topic)) is not None:
                await handler(kept)
            while True:
                await handler(await queue.get())
        finally:
            self._listeners[topic.name].remove(queue)

    def _deliver(self, name: str, message: Message) -> None:
        for queue in self._listeners[name]:
            queue.put_nowait(message)
