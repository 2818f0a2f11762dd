"""Things and views in a database."""

from collections.abc import AsyncGenerator, AsyncIterable, Callable, Collection, Mapping, Sequence
from contextlib import AbstractAsyncContextManager
from dataclasses import replace
from pathlib import Path

from sqlalchemy import Connection, make_url

from contracts.memory import Area, ForgetRequest, LabelCount
from memory.adapters import places, reading, rooms, writing
from memory.adapters.postgres import Postgres
from memory.adapters.tables import MIGRATIONS, things, views
from memory.frames import Frame, Tally
from memory.objects import MapObject
from memory.ports import Candidates, Counts, ExportBatch, KeptMap, KeptRoom, StoredView
from memory.settings import Settings
from store.connections import Connections
from store.copies import DatabaseCopy, JudgedDatabase
from store.database import Database
from store.sqlite_file import SqliteFile

READERS = 4
PRAGMAS = (
    "PRAGMA foreign_keys = ON",
    # In WAL mode NORMAL survives a killed process but not a lost battery: its last commits may be gone. What was
    # answered must be there, and at one write a second the extra fsync costs nothing.
    "PRAGMA synchronous = FULL",
    # What was forgotten must not lie in the file's free pages.
    "PRAGMA secure_delete = ON",
)
PRUNED_TO = 0.95
"""How full it is after forgetting: leaves room, so that forgetting stays rare."""


class SqlStore:
    """A `memory.ports.Store`. Opens at first use, and again later when that failed (locked, read-only, away)."""

    def __init__(
        self,
        database: Database,
        *,
        busy_timeout_s: float = 2.0,
        views_max: int = 1_000_000,
        things_max: int = 5_000,
    ) -> None:
        self._name = database.name
        self._connections = Connections(database, readers=READERS, busy_timeout_s=busy_timeout_s)
        self._views_max = views_max
        self._things_max = things_max
        self._at_most: dict[str, int] = {}

    @classmethod
    def from_settings(cls, settings: Settings) -> "SqlStore":
        url = make_url(settings.database_url)
        database = (
            SqliteFile(Path(str(url.database)), MIGRATIONS, pragmas=PRAGMAS, busy_timeout_s=settings.busy_timeout_s)
            if url.get_backend_name() == "sqlite"
            else Postgres(url, busy_timeout_s=settings.busy_timeout_s)
        )
        return cls(
            database,
            busy_timeout_s=settings.busy_timeout_s,
            views_max=settings.views_max,
            things_max=settings.objects_max,
        )

    async def remember(self, frames: Sequence[Frame]) -> Tally:
        def work(connection: Connection) -> Tally:
            tally = writing.remember(connection, frames)
            new = sum(len(frame.seen) for frame in frames)
            self._make_room(connection, new)
            return tally

        return await self._connections.write(work)

    async def maps(self) -> tuple[KeptMap, ...]:
        return await self._connections.read(places.all_maps)

    async def map_sizes(self) -> dict[int, tuple[int, int]]:
        return await self._connections.read(places.sizes)

    async def enter_map(self, map_id: str, was: Collection[str], now_s: float) -> int:
        return await self._connections.write(lambda connection: places.enter(connection, map_id, was, now_s))

    async def maps_with(self, label: str, limit: int) -> tuple[int, ...]:
        return await self._connections.read(lambda connection: places.maps_with(connection, label, limit))

    async def rooms(self, map_number: int) -> tuple[KeptRoom, ...]:
        return await self._connections.read(lambda connection: rooms.rooms_of_map(connection, map_number))

    async def add_rooms(self, map_number: int, places: Sequence[tuple[float, float]]) -> bool:
        return await self._connections.write(lambda connection: rooms.add(connection, map_number, places))

    async def name_room(self, map_number: int, room_id: int, name: str, shown: Collection[int]) -> int | None:
        return await self._connections.write(
            lambda connection: rooms.name(connection, map_number, room_id, name, shown)
        )

    async def views(self, label: str | None, limit: int, map_number: int | None = None) -> list[StoredView]:
        return await self._connections.read(lambda connection: reading.best_views(connection, label, limit, map_number))

    async def things(
        self, label: str | None, area: Area | None, limit: int, map_number: int | None = None
    ) -> list[MapObject]:
        return await self._connections.read(
            lambda connection: reading.some_things(connection, label, area, limit, map_number)
        )

    async def thing(self, number: int) -> MapObject | None:
        return await self._connections.read(lambda connection: reading.one_thing(connection, number))

    async def labels(self, limit: int, map_number: int | None = None) -> list[LabelCount]:
        return await self._connections.read(lambda connection: reading.labels(connection, limit, map_number))

    async def candidates(
        self, wanted: Mapping[str, Collection[str]], *, map_number: int = 0, views_a_thing: int, views_max: int
    ) -> dict[str, Candidates]:
        def work(connection: Connection) -> dict[str, Candidates]:
            return {
                label: reading.candidates(
                    connection,
                    label,
                    colours,
                    map_number=map_number,
                    views_a_thing=views_a_thing,
                    views_max=views_max,
                )
                for label, colours in wanted.items()
            }

        return await self._connections.read(work)

    async def forget(self, what: ForgetRequest, map_number: int | None = None) -> int:
        return await self._forget(lambda connection: writing.forget(connection, what, map_number))

    async def forget_thing(self, number: int) -> int:
        return await self._forget(lambda connection: writing.forget_thing(connection, number))

    async def tidy(self, *, lost_before_s: float, seen_before_s: float) -> int:
        return await self._forget(
            lambda connection: writing.tidy(connection, lost_before_s=lost_before_s, seen_before_s=seen_before_s)
        )

    async def counts(self) -> Counts:
        found = await self._connections.read(lambda connection: reading.counts(connection, self._name))
        size_bytes = await self._connections.size_bytes()
        return replace(found, size_bytes=size_bytes)

    async def export_batches(self) -> AsyncGenerator[ExportBatch]:
        """A view of a thing that came after the things were read is left out."""
        yield ExportBatch(maps=await self.maps())
        told: set[int] = set()
        for kind in ("things", "views"):
            after: int | None = 0
            while after is not None:
                page, after = await self._page(kind, after)
                told |= {thing.id for thing in page.things}
                yield ExportBatch(page.things, tuple(view for view in page.views if view.thing_id in {None, *told}))

    async def _page(self, kind: str, after: int) -> tuple[ExportBatch, int | None]:
        return await self._connections.read(lambda connection: reading.page(connection, kind, after))

    async def import_batch(self, hoard: ExportBatch) -> None:
        def work(connection: Connection) -> None:
            writing.import_batch(connection, places.in_kept_maps(connection, hoard))
            self._make_room(connection, len(hoard.views) + len(hoard.things))

        await self._connections.write(work)

    async def snapshot(self) -> DatabaseCopy:
        return await self._connections.snapshot()

    def candidate(self, body: AsyncIterable[bytes], *, bytes_max: int) -> AbstractAsyncContextManager[JudgedDatabase]:
        return self._connections.candidate(body, bytes_max=bytes_max, reads=reading.everything)

    async def replace(self, candidate: JudgedDatabase) -> str:
        kept = await self._connections.replace(candidate)
        self._at_most.clear()
        return kept

    async def check(self) -> None:
        await self._connections.check()

    async def aclose(self) -> None:
        await self._connections.aclose()

    async def _forget(self, work: Callable[[Connection], int]) -> int:
        count = await self._connections.write(work)
        if count:
            await self._connections.after_forgetting()
        return count

    def _make_room(self, connection: Connection, new: int) -> None:
        """Counting reads a whole table, so it is done only when the limit may have been passed."""
        for table, most in ((things, self._things_max), (views, self._views_max)):
            before = self._at_most.get(table.name)
            if before is not None and before + new <= most:
                self._at_most[table.name] = before + new
            else:
                self._at_most[table.name] = writing.make_room(connection, table, most, int(most * PRUNED_TO))
