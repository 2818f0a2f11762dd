"""Views in an SQLite file: one writing connection, a few reading ones, each in its own thread beside the event loop."""

import asyncio
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sqlalchemy import URL, Row, case, delete, event, func, make_url, select
from sqlalchemy.dialects.sqlite import insert
from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine, create_async_engine

from contracts.geometry import Pose2D
from contracts.memory import LabelCount, Observation, View
from memory.adapters.database_file import check_writable, naming_the_database, prepare
from memory.adapters.tables import views
from memory.settings import Settings
from memory.views import Sighting, merge
from mesh.errors import UnavailableError

READERS = 4
CHECK_S = 0.3
PRUNED_TO = 0.95
"""How full it is after forgetting: leaves room, so that forgetting stays rare."""
PRAGMAS = (
    "PRAGMA foreign_keys = ON",
    # In WAL mode NORMAL survives a killed process but not a lost battery: its last commits may be gone. What was
    # answered must be there, and at one write a second the extra fsync costs nothing.
    "PRAGMA synchronous = FULL",
)


class SqliteStore:
    """A `memory.ports.Store`. Opens at first use, and again later when that failed (locked, read-only)."""

    def __init__(self, path: Path, *, busy_timeout_s: float = 2.0, views_max: int = 1_000_000) -> None:
        self._path = path
        self._busy_timeout_s = busy_timeout_s
        self._views_max = views_max
        self._rows_at_most: int | None = None
        self._prepared = False
        self._preparing = asyncio.Lock()
        self._writer = self._engine("BEGIN IMMEDIATE", PRAGMAS, connections=1)
        self._reader = self._engine("BEGIN", (*PRAGMAS, "PRAGMA query_only = ON"), connections=READERS)

    @classmethod
    def from_settings(cls, settings: Settings) -> "SqliteStore":
        path = Path(str(make_url(settings.database_url).database))
        return cls(path, busy_timeout_s=settings.busy_timeout_s, views_max=settings.views_max)

    async def add(self, observations: Sequence[Observation]) -> None:
        rows = [_row(sighting) for sighting in merge(observations).values()]
        await self._prepare(self._busy_timeout_s)
        with naming_the_database():
            async with self._writer.begin() as connection:
                await connection.execute(_UPSERT, rows)
                at_most = await self._make_room(connection, len(rows))
        self._rows_at_most = at_most

    async def views(self, label: str | None, limit: int) -> list[View]:
        query = select(views).order_by(views.c.confidence.desc(), views.c.id).limit(limit)
        if label is not None:
            query = query.where(views.c.label == label)
        return [_view(row) for row in await self._read(query)]

    async def labels(self, limit: int) -> list[LabelCount]:
        count = func.count().label("views")
        query = (
            select(
                views.c.label,
                count,
                func.max(views.c.confidence).label("best_confidence"),
                func.max(views.c.last_seen_s).label("last_seen_s"),
            )
            .group_by(views.c.label)
            .order_by(count.desc(), views.c.label)
            .limit(limit)
        )
        return [
            LabelCount(
                label=row.label, views=row.views, best_confidence=row.best_confidence, last_seen_s=row.last_seen_s
            )
            for row in await self._read(query)
        ]

    async def forget(self, label: str) -> int:
        await self._prepare(self._busy_timeout_s)
        with naming_the_database():
            async with self._writer.begin() as connection:
                return (await connection.execute(delete(views).where(views.c.label == label))).rowcount

    async def check(self) -> None:
        if self._preparing.locked():
            raise UnavailableError("database", "is being opened")
        await self._prepare(CHECK_S)
        await asyncio.to_thread(check_writable, self._path, busy_timeout_s=CHECK_S)

    async def aclose(self) -> None:
        await self._writer.dispose()
        await self._reader.dispose()

    async def _prepare(self, busy_timeout_s: float) -> None:
        if self._prepared:
            return
        try:
            async with asyncio.timeout(self._busy_timeout_s):
                await self._preparing.acquire()
        except TimeoutError as error:
            raise UnavailableError("database", "is being opened") from error
        try:
            if not self._prepared:
                await asyncio.to_thread(prepare, self._path, busy_timeout_s=busy_timeout_s)
                self._prepared = True
        finally:
            self._preparing.release()

    async def _read(self, query: Any) -> Sequence[Row[Any]]:
        await self._prepare(self._busy_timeout_s)
        with naming_the_database():
            async with self._reader.connect() as connection:
                return (await connection.execute(query)).all()

    async def _make_room(self, connection: AsyncConnection, new: int) -> int:
        """Forgets what was longest not seen when there are too many; returns how many there are at most.

        Counting reads the whole table, so it is done only when the limit may have been passed."""
        if self._rows_at_most is not None and self._rows_at_most + new <= self._views_max:
            return self._rows_at_most + new
        count = (await connection.execute(select(func.count()).select_from(views))).scalar_one()
        if count <= self._views_max:
            return count
        keep = int(self._views_max * PRUNED_TO)
        oldest = select(views.c.id).order_by(views.c.last_seen_s, views.c.id).limit(count - keep)
        await connection.execute(delete(views).where(views.c.id.in_(oldest)))
        return keep

    def _engine(self, begin: str, pragmas: Sequence[str], *, connections: int) -> AsyncEngine:
        engine = create_async_engine(
            URL.create("sqlite+aiosqlite", database=str(self._path)),
            hide_parameters=True,  # an error's text, and so a log, never holds what was to be written
            pool_size=connections,
            max_overflow=0,
            pool_timeout=self._busy_timeout_s,
            connect_args={"timeout": self._busy_timeout_s},
        )

        def set_up(connection: Any, record: object) -> None:
            connection.isolation_level = None  # BEGIN is ours to say: Python's sqlite3 would say it too late
            cursor = connection.cursor()
            for pragma in pragmas:
                cursor.execute(pragma)
            cursor.close()

        def on_begin(connection: Any) -> None:
            connection.exec_driver_sql(begin)

        event.listen(engine.sync_engine, "connect", set_up)
        event.listen(engine.sync_engine, "begin", on_begin)
        return engine


def _upsert() -> Any:
    """`memory.views.merged`, in SQL: the right-hand sides see the row as it was."""
    statement = insert(views)
    new, old = statement.excluded, views.c
    better = new.confidence > old.confidence
    return statement.on_conflict_do_update(
        index_elements=[old.label, old.colour, old.cell_x, old.cell_y, old.sector],
        set_={
            "x": case((better, new.x), else_=old.x),
            "y": case((better, new.y), else_=old.y),
            "yaw": case((better, new.yaw), else_=old.yaw),
            "confidence": func.max(new.confidence, old.confidence),
            "last_seen_s": func.max(new.last_seen_s, old.last_seen_s),
            "count": old["count"] + new["count"],
        },
    )


_UPSERT = _upsert()


def _row(sighting: Sighting) -> dict[str, str | int | float]:
    place, pose = sighting.place, sighting.pose
    return {
        "label": place.label,
        "colour": place.colour,
        "cell_x": place.cell_x,
        "cell_y": place.cell_y,
        "sector": place.sector,
        "x": pose.x,
        "y": pose.y,
        "yaw": pose.yaw,
        "confidence": sighting.confidence,
        "last_seen_s": sighting.last_seen_s,
        "count": sighting.count,
    }


def _view(row: Row[Any]) -> View:
    return View(
        id=row.id,
        label=row.label,
        confidence=row.confidence,
        pose=Pose2D(x=row.x, y=row.y, yaw=row.yaw),
        stamp_s=row.last_seen_s,
        colour=row.colour or None,
    )
