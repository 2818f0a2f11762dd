"""A mission log in memory: gone with the process."""

from collections import OrderedDict, defaultdict
from collections.abc import AsyncIterable, AsyncIterator
from contextlib import AbstractAsyncContextManager

from contracts.mission import Mission, MissionEvent
from contracts.problem import Dependency
from coordinator.adapters.tail import EventTail
from coordinator.ports import KnownRequest
from mesh.errors import NotFoundError, UnprocessableError
from store.copies import DatabaseCopy, JudgedDatabase


class MemoryLog:
    """The port `MissionLog`; one suite of tests runs over it and `SqliteLog`."""

    opened = True

    def __init__(self) -> None:
        self._missions: OrderedDict[str, Mission] = OrderedDict()
        self._tail = EventTail(1_000_000)
        self._recordings: defaultdict[str, list[str]] = defaultdict(list)
        self._pictures: dict[tuple[str, int], bytes] = {}
        self._requests: dict[str, KnownRequest] = {}

    @property
    def next_event_id(self) -> int:
        return self._tail.events[-1].id + 1 if self._tail.events else 0

    def upsert(self, mission: Mission) -> None:
        self._missions[mission.id] = mission

    def append(self, event: MissionEvent) -> None:
        self._tail.append(event)

    def record(self, mission_id: str, line: str) -> None:
        self._recordings[mission_id].append(line)

    def keep_picture(self, mission_id: str, number: int, jpeg: bytes) -> None:
        self._pictures[mission_id, number] = jpeg

    def keep_request(self, key: str, request: KnownRequest) -> None:
        self._requests[key] = request

    async def flushed(self) -> None:
        pass

    async def get(self, mission_id: str) -> Mission | None:
        return self._missions.get(mission_id)

    async def newest(self, limit: int, *, before: str | None = None) -> tuple[Mission, ...]:
        ids = list(reversed(self._missions))
        if before is not None:
            if before not in self._missions:
                raise NotFoundError(f"no mission {before[:64]}")
            ids = ids[ids.index(before) + 1 :]
        return tuple(self._missions[one] for one in ids[:limit])

    async def events(self, mission_id: str, *, after: int, limit: int) -> tuple[MissionEvent, ...]:
        return tuple(e for e in self._tail.events if e.mission_id == mission_id and e.id > after)[:limit]

    def follow(self, *, after: int | None) -> AsyncIterator[MissionEvent]:
        return self._tail.follow(self.next_event_id - 1 if after is None else after, _nothing_older)

    async def recording(self, mission_id: str) -> tuple[str, ...]:
        return tuple(self._recordings.get(mission_id, ()))

    async def picture(self, mission_id: str, number: int) -> bytes | None:
        return self._pictures.get((mission_id, number))

    async def request(self, key: str) -> KnownRequest | None:
        return self._requests.get(key)

    async def dependency(self) -> Dependency:
        return Dependency.of("database", ok=True, detail="in memory: gone with the process")

    async def snapshot(self) -> DatabaseCopy:
        raise UnprocessableError("a dict has no back-up")

    def candidate(self, body: AsyncIterable[bytes], *, bytes_max: int) -> AbstractAsyncContextManager[JudgedDatabase]:
        raise UnprocessableError("a dict has no back-up")

    async def replace(self, candidate: JudgedDatabase, now_s: float) -> str:
        raise UnprocessableError("a dict has no back-up")


async def _nothing_older(after: int, limit: int) -> tuple[MissionEvent, ...]:
    return ()
