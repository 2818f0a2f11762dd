"""What the service does: takes observations in, keeps out what is excluded, writes in batches, recalls."""

from collections import deque
from collections.abc import Sequence

import structlog
from prometheus_client import Counter

from contracts.memory import (
    DeletedReply,
    LabelCount,
    Observation,
    ObservationBatch,
    ObservationsReply,
    RecallReply,
    RecallRequest,
    View,
)
from contracts.problem import Dependency
from contracts.topics import VISION_DETECTIONS
from contracts.vision import Detections
from memory import recall
from memory.ports import Store
from memory.settings import Settings
from memory.views import Exclusion, observations_of
from mesh.bus import Bus
from mesh.clock import Clock
from mesh.errors import NotFoundError, UnavailableError

log = structlog.get_logger()

STORED = Counter("memory_observations_stored_total", "observations written", ["via"])
LOST = Counter("memory_observations_lost_total", "detections dropped because the buffer was full")


class Memory:
    """One per process. Detections wait in a bounded buffer for the next flush; what is posted is written at once."""

    def __init__(self, settings: Settings, store: Store, bus: Bus, clock: Clock) -> None:
        self._settings = settings
        self._store = store
        self._bus = bus
        self._clock = clock
        self._excluded = Exclusion.of(settings.excluded_labels)
        self._buffer: deque[Observation] = deque(maxlen=settings.buffer_max)

    async def listen(self) -> None:
        """Takes in `vision.detections` until cancelled."""
        await self._bus.listen(VISION_DETECTIONS, self._take)

    async def flush_forever(self) -> None:
        """Writes the buffer once a period; what cannot be written now stays for the next time."""
        while True:
            await self._clock.sleep(self._settings.flush_period_s)
            await self.try_flush()

    async def try_flush(self) -> None:
        try:
            await self.flush()
        except UnavailableError as error:
            log.warning("could not write; trying again", waiting=len(self._buffer), error=error.detail)

    async def flush(self) -> None:
        """Everything buffered, in one transaction. Raises `UnavailableError` and keeps it all when that fails."""
        batch = list(self._buffer)
        if not batch:
            return
        self._buffer.clear()
        written = False
        try:
            await self._store.add(batch)
            written = True
        finally:  # cancelled counts too: the last flush of a closing service writes it then
            if not written:
                self._put_back(batch)
        STORED.labels("detections").inc(len(batch))

    async def observe(self, batch: ObservationBatch) -> ObservationsReply:
        """Durable when it returns."""
        wanted = [one for one in batch.observations if one.label not in self._excluded]
        if wanted:
            await self._store.add(wanted)
            STORED.labels("http").inc(len(wanted))
        return ObservationsReply(stored=len(wanted), ignored=len(batch.observations) - len(wanted))

    async def labels(self, limit: int) -> list[LabelCount]:
        return await self._store.labels(limit)

    async def views(self, label: str | None, limit: int) -> list[View]:
        return await self._store.views(label, limit)

    async def recall(self, request: RecallRequest) -> RecallReply:
        """Requirement A5; see `memory.recall`."""
        limit = self._settings.candidates_max
        of_label = await self._store.views(request.label, limit)
        first = request.memory_object
        of_memory_object = await self._store.views(first, limit) if first not in {None, request.label} else []
        return RecallReply(views=recall.rank(request, of_memory_object, of_label))

    async def forget(self, label: str) -> DeletedReply:
        """What still waits in the buffer goes too. Raises `NotFoundError` when there was nothing."""
        await self.flush()
        deleted = await self._store.forget(label)
        if deleted == 0:
            raise NotFoundError("no view of such a thing is remembered")
        return DeletedReply(deleted=deleted)

    async def dependencies(self) -> Sequence[Dependency]:
        """Ready means: the database can be written, and Redis is there."""
        trouble = ""
        try:
            await self._store.check()
        except UnavailableError as error:
            trouble = error.detail
        connected = self._bus.connected
        return [
            Dependency(name="database", ok=not trouble, detail=trouble),
            Dependency(name="redis", ok=connected, detail="" if connected else "not reachable"),
        ]

    async def _take(self, message: Detections) -> None:
        new = observations_of(message, self._excluded, self._settings.confidence_min)
        LOST.inc(max(0, len(self._buffer) + len(new) - self._settings.buffer_max))
        self._buffer.extend(new)

    def _put_back(self, batch: list[Observation]) -> None:
        """In front of what came meanwhile; the newest win."""
        everything = [*batch, *self._buffer]
        LOST.inc(max(0, len(everything) - self._settings.buffer_max))
        self._buffer.clear()
        self._buffer.extend(everything)
