"""Things and views in a database: one writing connection, a few reading ones, in threads beside the event loop."""

import asyncio
from collections.abc import AsyncGenerator, Callable, Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from sqlalchemy import Connection, make_url

from contracts.memory import Area, ForgetRequest, LabelCount
from memory.adapters import places, reading, writing
from memory.adapters.database import Database, naming_the_database
from memory.adapters.database_file import CHECK_S, SqliteFile
from memory.adapters.postgres import Postgres
from memory.adapters.tables import things, views
from memory.frames import Frame, Tally
from memory.objects import Thing
from memory.ports import Candidates, Counts, Hoard, KeptMap, KeptView
from memory.settings import Settings
from mesh.errors import UnavailableError

T = TypeVar("T")

READERS = 4
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
        self._database = database
        self._busy_timeout_s = busy_timeout_s
        self._views_max = views_max
        self._things_max = things_max
        self._at_most: dict[str, int] = {}
        self._prepared = False
        self._preparing = asyncio.Lock()
        self._writer = database.writer()
        self._reader = database.reader(READERS)
        self._writing = ThreadPoolExecutor(1, "memory-writer")
        self._reading = ThreadPoolExecutor(READERS, "memory-reader")

    @classmethod
    def from_settings(cls, settings: Settings) -> "SqlStore":
        url = make_url(settings.database_url)
        database = (
            SqliteFile(Path(str(url.database)), busy_timeout_s=settings.busy_timeout_s)
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

        return await self._write(work)

    async def maps(self) -> tuple[KeptMap, ...]:
        return await self._read(places.all_maps)

    async def map_sizes(self) -> dict[int, tuple[int, int]]:
        return await self._read(places.sizes)

    async def enter_map(self, map_id: str, was: Collection[str], now_s: float) -> int:
        return await self._write(lambda connection: places.enter(connection, map_id, was, now_s))

    async def maps_with(self, label: str, limit: int) -> tuple[int, ...]:
        return await self._read(lambda connection: places.maps_with(connection, label, limit))

    async def views(self, label: str | None, limit: int, map_number: int | None = None) -> list[KeptView]:
        return await self._read(lambda connection: reading.best_views(connection, label, limit, map_number))

    async def things(
        self, label: str | None, area: Area | None, limit: int, map_number: int | None = None
    ) -> list[Thing]:
        return await self._read(lambda connection: reading.some_things(connection, label, area, limit, map_number))

    async def thing(self, number: int) -> Thing | None:
        return await self._read(lambda connection: reading.one_thing(connection, number))

    async def labels(self, limit: int, map_number: int | None = None) -> list[LabelCount]:
        return await self._read(lambda connection: reading.labels(connection, limit, map_number))

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

        return await self._read(work)

    async def forget(self, what: ForgetRequest, map_number: int | None = None) -> int:
        return await self._forget(lambda connection: writing.forget(connection, what, map_number))

    async def forget_thing(self, number: int) -> int:
        return await self._forget(lambda connection: writing.forget_thing(connection, number))

    async def tidy(self, *, lost_before_s: float, seen_before_s: float) -> int:
        return await self._forget(
            lambda connection: writing.tidy(connection, lost_before_s=lost_before_s, seen_before_s=seen_before_s)
        )

    async def counts(self) -> Counts:
        found = await self._read(lambda connection: reading.counts(connection, self._database.name))
        size_bytes = await asyncio.to_thread(self._database.size_bytes, self._reader)
        return replace(found, size_bytes=size_bytes)

    async def pages(self) -> AsyncGenerator[Hoard]:
        """A view of a thing that came after the things were read is left out."""
        yield Hoard(maps=await self.maps())
        told: set[int] = set()
        for kind in ("things", "views"):
            after: int | None = 0
            while after is not None:
                page, after = await self._page(kind, after)
                told |= {thing.id for thing in page.things}
                yield Hoard(page.things, tuple(view for view in page.views if view.thing_id in {None, *told}))

    async def _page(self, kind: str, after: int) -> tuple[Hoard, int | None]:
        return await self._read(lambda connection: reading.page(connection, kind, after))

    async def bring_in(self, hoard: Hoard) -> None:
        def work(connection: Connection) -> None:
            writing.bring_in(connection, places.in_kept_maps(connection, hoard))
            self._make_room(connection, len(hoard.views) + len(hoard.things))

        await self._write(work)

    async def check(self) -> None:
        if self._preparing.locked():
            raise UnavailableError("database", "is being opened")
        await self._prepare(CHECK_S)
        await asyncio.to_thread(self._database.check_writable)

    async def aclose(self) -> None:
        self._writing.shutdown()
        self._reading.shutdown()
        self._writer.dispose()
        self._reader.dispose()

    async def _read(self, work: Callable[[Connection], T]) -> T:
        await self._prepare(self._busy_timeout_s)

        def reading_transaction() -> T:
            with naming_the_database(), self._reader.connect() as connection:
                return work(connection)

        return await asyncio.get_running_loop().run_in_executor(self._reading, reading_transaction)

    async def _write(self, work: Callable[[Connection], T]) -> T:
        """Once begun it is finished, also when whoever asked for it no longer waits."""
        await self._prepare(self._busy_timeout_s)

        def writing_transaction() -> T:
            with naming_the_database(), self._writer.begin() as connection:
                return work(connection)

        return await asyncio.get_running_loop().run_in_executor(self._writing, writing_transaction)

    async def _forget(self, work: Callable[[Connection], int]) -> int:
        count = await self._write(work)
        if count:
            loop = asyncio.get_running_loop()
            await loop.run_in_executor(self._writing, self._database.after_forgetting, self._writer)
        return count

    async def _prepare(self, patience_s: float) -> None:
        if self._prepared:
            return
        try:
            async with asyncio.timeout(self._busy_timeout_s):
                await self._preparing.acquire()
        except TimeoutError as error:
            raise UnavailableError("database", "is being opened") from error
        try:
            if not self._prepared:
                await asyncio.to_thread(self._database.prepare, patience_s=patience_s)
                self._prepared = True
        finally:
            self._preparing.release()

    def _make_room(self, connection: Connection, new: int) -> None:
        """Counting reads a whole table, so it is done only when the limit may have been passed."""
        for table, most in ((things, self._things_max), (views, self._views_max)):
            before = self._at_most.get(table.name)
            if before is not None and before + new <= most:
                self._at_most[table.name] = before + new
            else:
                self._at_most[table.name] = writing.make_room(connection, table, most, int(most * PRUNED_TO))
