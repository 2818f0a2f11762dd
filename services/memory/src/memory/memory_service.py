"""What the service does: takes frames in, keeps out what is excluded, writes in batches, recalls, forgets."""

import asyncio
from collections import deque
from collections.abc import AsyncGenerator, AsyncIterable, Sequence
from dataclasses import replace

import structlog

from contracts.backup import RestoreReply
from contracts.description import RobotDescription
from contracts.memory import (
    DeletedReply,
    ExportForm,
    ForgetRequest,
    ImportReply,
    LabelCount,
    LookBatch,
    LooksReply,
    MemoryStatistics,
    ObjectState,
    ObservationBatch,
    ObservationsReply,
    RecallReply,
    RecallRequest,
    RememberedMap,
    RememberedObject,
    View,
)
from contracts.problem import Dependency
from contracts.topics import ROBOT_STATE, VISION_DETECTIONS
from contracts.vision import Detections
from memory import exchange, recall
from memory.exporting import exported
from memory.frame_ingest import FrameIngest
from memory.frames import Camera, Exclusion, Frame, frames_of, not_after
from memory.metrics import LOST, STORED, WAITING, WRITES
from memory.objects import to_message
from memory.picture import map_svg
from memory.ports import DepthAndMap, Store
from memory.recall import Weights
from memory.room_book import RoomBook
from memory.settings import Settings
from memory.whereabouts import Whereabouts
from mesh.bus import Bus, redis_dependency
from mesh.clock import Clock
from mesh.errors import NotFoundError, UnavailableError, UnprocessableError
from store.copies import DatabaseCopy, JudgedDatabase
from store.finishing import finished
from store.shared_lock import SharedLock

log = structlog.get_logger()

PENDING_MAX = 20
"""Frames that wait to be looked at; perception makes two to five a second."""
MAP_PERIOD_S = 2.0
NOT_KNOWN_YET = -1
"""A frame's map while the database has not yet been read once: it is found out when the frame is written."""


class MemoryService:
    """One per process. Frames wait in a bounded buffer for the next flush; what is posted is written at once."""

    def __init__(self, settings: Settings, store: Store, bus: Bus, clock: Clock, senses: DepthAndMap | None) -> None:
        self._settings = settings
        self._store = store
        self._bus = bus
        self._clock = clock
        self._senses = senses
        self._excluded = Exclusion.of(settings.excluded_labels)
        self.writing = SharedLock()
        """Shared by all that writes: numbers of maps that it holds are those of the database it writes to."""
        self._whereabouts = Whereabouts(store, senses, clock, self.writing)
        self.rooms = RoomBook(store, senses, self._whereabouts, clock, self.writing)
        self._ingest = FrameIngest(settings, store, senses)
        self._blind = FrameIngest(settings, store, None)
        self._pending: deque[Detections] = deque(maxlen=PENDING_MAX)
        self._came = asyncio.Event()
        self._looking = asyncio.Lock()
        self._buffer: deque[Frame] = deque(maxlen=settings.buffer_max)
        WAITING.labels("look").set_function(lambda: len(self._pending))
        WAITING.labels("write").set_function(lambda: len(self._buffer))
        self._weights = Weights(**{name: getattr(settings, f"weight_{name}") for name in Weights.__dataclass_fields__})

    async def listen(self) -> None:
        """Takes in `vision.detections` until cancelled."""
        await self._bus.listen(VISION_DETECTIONS, self.take)

    async def hear_robot(self) -> None:
        """Takes in which map the robot is in, until cancelled."""
        await self._bus.listen(ROBOT_STATE, self._whereabouts.hear)

    async def describe(self, robot: RobotDescription) -> None:
        self._ingest.camera = self._blind.camera = Camera.on(robot)

    async def look_forever(self) -> None:
        """Finds out where the things of each frame are, and what is missing from it."""
        while True:
            await self._came.wait()
            self._came.clear()
            await self._look_at_pending(self._ingest)

    async def watch_map_forever(self) -> None:
        """Finds out which map the robot is in, also where the bus is silent."""
        while True:
            await self._whereabouts.ask()
            await self._clock.sleep(MAP_PERIOD_S)

    async def flush_forever(self) -> None:
        """Writes the buffer once a period; what cannot be written now stays for the next time."""
        while True:
            await self._clock.sleep(self._settings.flush_period_s)
            await self.try_flush()

    async def close(self) -> None:
        """What waits is written, without asking anybody any more."""
        await self.rooms.aclose()
        await self._look_at_pending(self._blind)
        await self.try_flush()

    async def try_flush(self) -> None:
        try:
            await self.flush()
        except UnavailableError as error:
            log.warning("could not write; trying again", waiting=len(self._buffer), error=error.detail)

    async def flush(self) -> None:
        """Everything buffered, in one transaction. Raises `UnavailableError` and keeps it all when that fails."""
        async with self.writing.shared():
            await self._write_buffer()

    async def _write_buffer(self) -> None:
        batch = list(self._buffer)
        if not batch:
            return
        self._buffer.clear()
        written = False
        try:
            here = (await self._whereabouts.here()).number
            late = [replace(one, map_number=here) if one.map_number == NOT_KNOWN_YET else one for one in batch]
            with WRITES.time():
                await self._store.remember(late)
            written = True
        finally:  # cancelled counts too: the last flush of a closing service writes it then
            if not written:
                self._put_back(batch)
        STORED.labels("detections").inc(sum(len(frame.seen) for frame in batch))

    async def observe(self, batch: ObservationBatch) -> ObservationsReply:
        """Durable when it returns."""
        wanted = [one for one in batch.observations if one.label not in self._excluded]
        if wanted:
            async with self.writing.shared():
                here, now_s = await self._whereabouts.here(), self._clock.now_s()
                await self._store.remember([not_after(frame, now_s) for frame in frames_of(wanted, here.number)])
            STORED.labels("http").inc(len(wanted))
        return ObservationsReply(stored=len(wanted), ignored=len(batch.observations) - len(wanted))

    async def look(self, batch: LookBatch) -> LooksReply:
        """Durable when it returns. A look confirms nothing: what was seen comes as observations."""
        async with self.writing.shared():
            here = await self._whereabouts.here()
            judged = [await self._ingest.judge(look, here.number) for look in batch.looks]
            now_s = self._clock.now_s()
            await self._store.remember([not_after(frame, now_s) for frame, _ in judged])
        return LooksReply(
            confirmed=sum(tally.confirmed for _, tally in judged),
            missed=sum(tally.missed for _, tally in judged),
            undetermined=sum(tally.undetermined for _, tally in judged),
        )

    async def maps(self) -> list[RememberedMap]:
        """Homes that something is remembered of, the one the robot is in first."""
        here, sizes = await self._whereabouts.here(), await self._store.map_sizes()
        return [
            RememberedMap(
                id=one.id,
                current=one.number == here.number,
                last_seen_s=one.last_seen_s,
                views=sizes.get(one.number, (0, 0))[0],
                objects=sizes.get(one.number, (0, 0))[1],
            )
            for one in sorted(await self._store.maps(), key=lambda one: one.number != here.number)
            if one.number == here.number or one.number in sizes
        ]

    async def labels(self, limit: int, map_id: str | None = None) -> list[LabelCount]:
        return await self._store.labels(limit, await self._whereabouts.number(map_id))

    async def views(self, label: str | None, limit: int, map_id: str | None = None) -> list[View]:
        return [
            kept.to_message() for kept in await self._store.views(label, limit, await self._whereabouts.number(map_id))
        ]

    async def objects(
        self, label: str | None, state: ObjectState | None, colour: str | None, limit: int,
        map_id: str | None = None, room: int | None = None,
    ) -> list[RememberedObject]:  # fmt: skip
        """Most believed first; without their rooms while the map is being cut. Those in one room wait for that."""
        now_s, number = self._clock.now_s(), await self._whereabouts.number(map_id)
        kept = await self._store.things(label, None, self._settings.objects_max, number)
        told = [to_message(one, now_s) for one in kept]
        fits = [one for one in told if state in {None, one.state} and colour in {None, one.colour}]
        found = sorted(fits, key=lambda one: (-one.belief, -one.last_seen_s, one.id))
        if room is not None:
            return (await self.rooms.in_room(found, number, room))[:limit]
        return await self.rooms.placed(found[:limit], number)

    async def object(self, number: int) -> RememberedObject:
        thing = await self._store.thing(number)
        if thing is None:
            raise NotFoundError(f"no object {number} is remembered")
        (told,) = await self.rooms.placed([to_message(thing, self._clock.now_s())], thing.map_number)
        return told

    async def recall(self, request: RecallRequest) -> RecallReply:
        """Requirement A5; see `memory.recall`."""
        rule = request.rule if request.rule is not None else self._settings.recall_rule
        wanted = recall.labels_to_search(request)
        here = await self._whereabouts.here()
        found = await self._store.candidates(
            wanted,
            map_number=here.number,
            views_a_thing=self._settings.views_an_object,
            views_max=self._settings.candidates_max,
        )
        views = recall.rank(request, found, rule=rule, weights=self._weights, now_s=self._clock.now_s())
        elsewhere = await self._whereabouts.elsewhere(request.target.label)
        return RecallReply(views=views, rule=rule, map_id=here.id, in_other_maps=elsewhere)

    async def forget(self, what: ForgetRequest) -> DeletedReply:
        """What still waits in the buffer goes too. Raises `NotFoundError` when there was nothing."""
        await self.catch_up()
        async with self.writing.shared():
            of = (await self._whereabouts.here()).number if what.area is not None else None
            return _deleted(await self._store.forget(what, of))

    async def forget_object(self, number: int) -> DeletedReply:
        """Raises `NotFoundError` when there was nothing."""
        await self.catch_up()
        async with self.writing.shared():
            return _deleted(await self._store.forget_thing(number))

    def export(self, form: ExportForm) -> AsyncGenerator[str]:
        """Line by line. Raises `UnavailableError` before the first line where the database is away."""
        return exported(self._store, self._whereabouts, form, views_max=self._settings.views_max)

    async def import_batch(self, form: ExportForm, data: bytes) -> ImportReply:
        """All or nothing; durable when it returns. Raises `UnprocessableError` for what is not in that form."""
        read = exchange.read_full if form is ExportForm.FULL else exchange.read_seeds
        try:
            brought = await asyncio.to_thread(read, data, self._excluded)
        except exchange.MalformedError as error:
            raise UnprocessableError(str(error)) from error
        async with self.writing.shared():
            here = await self._whereabouts.here()
            named = tuple(replace(one, id=one.id or here.id) for one in brought.hoard.maps)
            await self._store.import_batch(replace(brought.hoard, maps=named or (replace(here, number=0),)))
        return ImportReply(objects=len(brought.hoard.things), views=len(brought.hoard.views), ignored=brought.ignored)

    async def snapshot(self) -> DatabaseCopy:
        """What is remembered at this moment, what waited to be written included, as an SQLite file."""
        await self.catch_up()
        return await self._store.snapshot()

    async def restore(self, body: AsyncIterable[bytes], *, dry_run: bool) -> RestoreReply:
        """What is remembered becomes what a snapshot holds; `dry_run`: it is only checked. What waited to be written
        belongs to what is replaced, and stays with it."""
        async with self._store.candidate(body, bytes_max=self._settings.restore_bytes_max) as candidate:
            kept = ""
            if not dry_run:
                kept = await finished(self._exchange(candidate))
                log.warning("what is remembered was replaced by a back-up", rows=candidate.rows, before=kept)
            return RestoreReply(applied=not dry_run, revision=candidate.revision, rows=candidate.rows, kept_as=kept)

    async def _exchange(self, candidate: JudgedDatabase) -> str:
        async with self.writing.alone():
            await self._write_buffer()
            kept = await self._store.replace(candidate)
            await self._whereabouts.know_again()
            return kept

    async def map_svg(self, label: str | None, views_max: int) -> str:
        now_s = self._clock.now_s()
        here = (await self._whereabouts.here()).number
        things = [to_message(one, now_s) for one in await self._store.things(label, None, 1000, here)]
        views = await self._store.views(label, views_max, here)
        ground = await self._senses.ground() if self._senses is not None else None
        return await asyncio.to_thread(map_svg, things, views, ground, now_s)

    async def statistics(self) -> MemoryStatistics:
        return (await self._store.counts()).at(self._clock.now_s())

    async def dependencies(self) -> Sequence[Dependency]:
        """Ready means: the database can be written, and Redis is there. Without robot_bridge it remembers views."""
        trouble = ""
        try:
            await self._store.check()
        except UnavailableError as error:
            trouble = error.detail
        database = Dependency.of("database", ok=not trouble, detail=trouble)
        return [database, self._ingest.dependency(), redis_dependency(self._bus)]

    async def take(self, message: Detections) -> None:
        """Puts a frame in line; the newest win."""
        if len(self._pending) == PENDING_MAX:
            LOST.inc()
        self._pending.append(message)
        self._came.set()

    async def _look_at_pending(self, ingest: FrameIngest) -> None:
        """A frame leaves the line only once it is in the buffer: an ending service finds it in one of the two."""
        async with self._looking:
            while self._pending:
                async with self.writing.shared():
                    await self._look_at_next(ingest)

    async def _look_at_next(self, ingest: FrameIngest) -> None:
        message = self._pending[0]
        frame = await self._frame_of(message, ingest)
        if self._pending and self._pending[0] is message:
            self._pending.popleft()
        if frame is not None:
            LOST.inc(len(self._buffer) == self._buffer.maxlen)
            self._buffer.append(not_after(frame, self._clock.now_s()))

    async def _frame_of(self, message: Detections, ingest: FrameIngest) -> Frame | None:
        try:
            here = await self._whereabouts.here()
        except UnavailableError:
            return await ingest.frame_of(message, NOT_KNOWN_YET)
        return await ingest.frame_of(message, here.number)

    async def catch_up(self) -> None:
        """Everything that has come is looked at and written when it returns."""
        await self._look_at_pending(self._ingest)
        await self.flush()

    def _put_back(self, batch: list[Frame]) -> None:
        """In front of what came meanwhile; the newest win."""
        everything = [*batch, *self._buffer]
        LOST.inc(max(0, len(everything) - self._settings.buffer_max))
        self._buffer.clear()
        self._buffer.extend(everything)


def _deleted(count: int) -> DeletedReply:
    if count == 0:
        raise NotFoundError("nothing of that kind is remembered")
    return DeletedReply(deleted=count)
