"""A mission log in memory: bounded, gone with the process."""

import asyncio
from collections import OrderedDict, deque
from collections.abc import AsyncIterator

from contracts.mission import Mission, MissionEvent


class MemoryLog:
    def __init__(self, *, missions_max: int = 200, events_max: int = 10_000) -> None:
        self._missions: OrderedDict[str, Mission] = OrderedDict()
        self._events: deque[MissionEvent] = deque(maxlen=events_max)
        self._missions_max = missions_max
        self._news = asyncio.Event()

    def put(self, mission: Mission) -> None:
        self._missions[mission.id] = mission
        while len(self._missions) > self._missions_max:
            self._missions.popitem(last=False)

    def get(self, mission_id: str) -> Mission | None:
        return self._missions.get(mission_id)

    def newest(self, limit: int) -> tuple[Mission, ...]:
        """Newest first."""
        return tuple(reversed(self._missions.values()))[:limit]

    def append(self, event: MissionEvent) -> None:
        self._events.append(event)
        self._news.set()
        self._news = asyncio.Event()

    def events(self, mission_id: str, *, after: int, limit: int) -> tuple[MissionEvent, ...]:
        found = [e for e in self._events if e.mission_id == mission_id and e.id > after]
        return tuple(found[:limit])

    async def follow(self, *, after: int | None) -> AsyncIterator[MissionEvent]:
        """A reader too slow for the bound misses the oldest; the ids show the gap."""
        last = after if after is not None else (self._events[-1].id if self._events else -1)
        while True:
            news = self._news
            for event in [e for e in self._events if e.id > last]:
                last = event.id
                yield event
            if self._events and self._events[-1].id > last:
                continue
            await news.wait()
