"""Which home the robot's map is of: the maps it ever had, known again by what stands in them, and kept on disk."""

import asyncio
import os
import threading
from dataclasses import dataclass
from pathlib import Path

import structlog
from pydantic import Field, ValidationError

from contracts.base import Message
from contracts.robot import KnownMap, Map
from geometry.grids import MapError, OccupancyGrid, decode, encode
from geometry.places import content_id, same_place, sketch_of
from mesh.clock import Clock
from mesh.errors import ConflictError, NotFoundError
from mesh.latest_value import LatestValue
from robot_bridge.sensing.sensor_readings import Grid

log = structlog.get_logger()

FILE = "maps.json"
MAPS_MAX = 50
SAID_MIN = 0.4
"""A person may say that two maps are of one home where their walls agree this well: two homes rarely do."""
KEEPS_MIN = 0.9
"""A map that knows less than this of what the last one knew does not take its place: it is a part of it."""
WAIT_S = 5.0


@dataclass(frozen=True, eq=False)
class Entry:
    """A known map and its `geometry.places.sketch_of`."""

    known: KnownMap
    sketch: OccupancyGrid


class Line(Message):
    """An entry on disk."""

    known: KnownMap
    sketch: Map


class Book(Message):
    """The file: the map had most recently comes last."""

    maps: tuple[Line, ...] = Field(default=(), max_length=MAPS_MAX)


class MapBook:
    """Names the robot's map: it is the known one that it agrees with, the last one looked at first; else a new one."""

    def __init__(self, state_dir: Path, mailbox: LatestValue[Grid], clock: Clock) -> None:
        self._file = state_dir / FILE
        self._mailbox = mailbox
        self._clock = clock
        self._one_at_a_time = threading.Lock()
        self._entries = self._load()
        self._named: Grid | None = None

    @property
    def current(self) -> KnownMap | None:
        """The home the robot is in, by the newest map that was looked at; none before there was one."""
        return self._entries[-1].known if self._named is not None else None

    def known(self) -> tuple[KnownMap, ...]:
        """Every map it ever had, the last one first."""
        return tuple(entry.known for entry in reversed(self._entries))

    async def watch(self) -> None:
        """Names each map that comes; runs as a background task."""
        while True:
            reading = await self._mailbox.wait_for(lambda newest: newest.value is not self._named, WAIT_S)
            if reading is not None:
                await self.name(reading.value)

    async def name(self, grid: Grid) -> KnownMap:
        """Takes milliseconds for a home."""
        return await asyncio.to_thread(self._name, grid)

    async def same_home(self, other_id: str) -> KnownMap:
        """A person says that the map of now is of the home `other_id`: it is that home from now on.

        Raises `NotFoundError`, and `ConflictError` where the walls do not lie on one another.
        """
        return await asyncio.to_thread(self._same_home, other_id)

    def _name(self, grid: Grid) -> KnownMap:
        with self._one_at_a_time:
            if self._named is not grid:
                self._put(self._found(sketch_of(grid)))
                self._named = grid
            return self._entries[-1].known

    def _found(self, sketch: OccupancyGrid) -> Entry:
        now_s = self._clock.now_s()
        for entry in reversed(self._entries):
            if same_place(entry.sketch, sketch).is_one_place:
                known = entry.known.model_copy(update={"last_seen_s": max(now_s, entry.known.last_seen_s)})
                return Entry(known, sketch if _replaces(sketch, entry.sketch) else entry.sketch)
        return Entry(KnownMap(id=content_id(sketch), first_seen_s=now_s, last_seen_s=now_s), sketch)

    def _same_home(self, other_id: str) -> KnownMap:
        with self._one_at_a_time:
            if self._named is None:
                raise ConflictError("no map has been received")
            now = self._entries[-1]
            other = next((entry for entry in self._entries if entry.known.id == other_id), None)
            if other is None:
                raise NotFoundError(f"no map {other_id} is known")
            if other is now:
                return now.known
            agreement = same_place(other.sketch, now.sketch).agreement
            if agreement < SAID_MIN:
                raise ConflictError(
                    f"the walls of the two maps do not lie on one another (agreement {agreement:.2f}, at least "
                    f"{SAID_MIN} is needed): what is remembered would be looked for in wrong places"
                )
            was = (*other.known.was, now.known.id, *now.known.was)
            known = other.known.model_copy(update={"was": was, "last_seen_s": now.known.last_seen_s})
            self._entries = tuple(entry for entry in self._entries if entry is not now)
            self._put(Entry(known, now.sketch))
            return known

    def _put(self, entry: Entry) -> None:
        """Makes it the last one; what is new of it goes to disk."""
        same = next((one for one in self._entries if one.known.id == entry.known.id), None)
        is_new = (
            same is None or same.known.was != entry.known.was or content_id(same.sketch) != content_id(entry.sketch)
        )
        if self._entries and same is None:
            log.warning("the map is of a place not known yet: what belongs to others stays apart", map=entry.known.id)
        is_last = bool(self._entries) and self._entries[-1] is same
        self._entries = (*(one for one in self._entries if one is not same), entry)[-MAPS_MAX:]
        if is_new or not is_last:
            self._store()

    def _store(self) -> None:
        book = Book(maps=tuple(Line(known=one.known, sketch=encode(one.sketch)) for one in self._entries))
        beside = self._file.with_suffix(f".{os.getpid()}.tmp")
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            beside.write_text(book.model_dump_json())
            beside.replace(self._file)
        except OSError as error:
            log.warning("which maps are known could not be stored", error=str(error))

    def _load(self) -> tuple[Entry, ...]:
        """What cannot be read is forgotten: a map that was saved keeps its id, which is told by its content."""
        try:
            book = Book.model_validate_json(self._file.read_bytes())
            return tuple(Entry(line.known, decode(line.sketch)) for line in book.maps)
        except FileNotFoundError:
            return ()
        except (OSError, ValidationError, MapError) as error:
            log.warning("which maps are known cannot be read: starting anew", error=type(error).__name__)
            return ()


def _replaces(sketch: OccupancyGrid, before: OccupancyGrid) -> bool:
    return float((~sketch.unknown).sum()) >= KEEPS_MIN * float((~before.unknown).sum())
