"""The newest events in memory, for those who follow the timeline."""

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable

from contracts.mission import MissionEvent

Older = Callable[[int, int], Awaitable[tuple[MissionEvent, ...]]]
"""(after, limit) -> events with a higher id, oldest first."""

PAGE = 500


class EventTail:
    def __init__(self, kept: int) -> None:
        self.events: deque[MissionEvent] = deque(maxlen=kept)
        self._news = asyncio.Event()

    def append(self, event: MissionEvent) -> None:
        self.events.append(event)
        self._news.set()
        self._news = asyncio.Event()

    def clear(self) -> None:
        self.events.clear()

    @property
    def first_id(self) -> int | None:
        return self.events[0].id if self.events else None

    async def follow(self, after: int, older: Older) -> AsyncIterator[MissionEvent]:
        """Everything with a higher id; what has left the memory comes from `older`."""
        last = after
        while True:
            news = self._news
            first = self.first_id
            if first is None or last + 1 < first:
                page = await older(last, PAGE)
                for event in page:
                    last = event.id
                    yield event
                if page:
                    continue
            for event in [e for e in self.events if e.id > last]:
                last = event.id
                yield event
            if self.events and self.events[-1].id > last:
                continue
            await news.wait()
