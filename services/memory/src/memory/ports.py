"""What the service needs of the world: a place that keeps things and views, and robot_bridge's senses."""

from collections import Counter
from collections.abc import AsyncGenerator, AsyncIterable, Collection, Mapping, Sequence
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, field, replace
from typing import Protocol

from contracts.geometry import Pose2D
from contracts.measuring import LocalizeRequest, Measurement
from contracts.memory import Area, ForgetRequest, LabelCount, MemoryStatistics, View
from contracts.robot import KnownMap
from geometry.grids import OccupancyGrid
from memory.frames import Frame, Tally
from memory.objects import MapObject
from store.copies import DatabaseCopy, JudgedDatabase


@dataclass(slots=True)
class StoredView:
    """A view as it is kept. `colour` is the thing's where there is one, empty where it is not known; `belief` is as of
    `believed_s`, and means something only where there is no thing.

    Nobody changes one: it is not frozen because a recall makes hundreds, and to freeze one takes seven times as long.
    """

    id: int
    label: str
    colour: str
    x: float
    y: float
    yaw: float
    confidence: float
    last_seen_s: float
    count: int
    belief: float
    believed_s: float
    map_number: int
    thing_id: int | None

    @property
    def pose(self) -> Pose2D:
        return Pose2D(x=self.x, y=self.y, yaw=self.yaw)

    def to_message(self) -> View:
        """As others are told of it."""
        return View(
            id=self.id,
            label=self.label,
            confidence=self.confidence,
            pose=self.pose,
            stamp_s=self.last_seen_s,
            colour=self.colour or None,
            object_id=self.thing_id,
            count=self.count,
        )


@dataclass(frozen=True, slots=True)
class Candidates:
    """What recall chooses from: a label's things by id, and views of them and without them, by id."""

    things: dict[int, MapObject] = field(default_factory=dict[int, MapObject])
    views: tuple[StoredView, ...] = ()


@dataclass(frozen=True, slots=True)
class KeptMap:
    """A map that something is remembered of, or was; `id` is empty where nobody knew which one it was."""

    number: int
    id: str
    last_seen_s: float


@dataclass(frozen=True, slots=True)
class KeptRoom:
    """A room of a map, remembered by a place in it. `number` counts the rooms of its map; `name` is a person's, or
    empty."""

    id: int
    map_number: int
    number: int
    x: float
    y: float
    name: str = ""


@dataclass(frozen=True, slots=True)
class Counts:
    """Of the whole store."""

    labels: int
    views: int
    sightings: int
    things: tuple[MapObject, ...]
    oldest_s: float | None
    newest_s: float | None
    database: str
    size_bytes: int | None

    def at(self, now_s: float) -> MemoryStatistics:
        """As it is told: how sure a thing is depends on when it is asked."""
        return MemoryStatistics(
            labels=self.labels,
            views=self.views,
            sightings=self.sightings,
            objects=dict(Counter(thing.state_at(now_s) for thing in self.things)),
            oldest_s=self.oldest_s,
            newest_s=self.newest_s,
            database=self.database,
            size_bytes=self.size_bytes,
        )


@dataclass(frozen=True, slots=True)
class ExportBatch:
    """What an import brings: views name things, and both name maps, by the numbers they had where they come from."""

    things: tuple[MapObject, ...] = ()
    views: tuple[StoredView, ...] = ()
    maps: tuple[KeptMap, ...] = ()


def in_maps(hoard: ExportBatch, numbers: Mapping[int, int]) -> ExportBatch:
    """The hoard with other numbers for its maps; those not named keep theirs."""
    return ExportBatch(
        things=tuple(replace(one, map_number=numbers.get(one.map_number, one.map_number)) for one in hoard.things),
        views=tuple(replace(one, map_number=numbers.get(one.map_number, one.map_number)) for one in hoard.views),
        maps=tuple(replace(one, number=numbers.get(one.number, one.number)) for one in hoard.maps),
    )


class Store(Protocol):
    """Keeps things and views as `memory.object_association` and `memory.views` say. Every method raises
    `mesh.errors.UnavailableError` when it cannot, and then has changed nothing. `map_number`: of this map; none: of
    every map."""

    async def maps(self) -> tuple[KeptMap, ...]:
        """The one the robot was in last comes first; there always is one."""
        ...

    async def map_sizes(self) -> dict[int, tuple[int, int]]:
        """By number: how many views and how many things are of it."""
        ...

    async def enter_map(self, map_id: str, was: Collection[str], now_s: float) -> int:
        """The number of the map that the robot is in now. What is of a map in `was` is of this one from now on; what
        is of no known map is of the first one that is."""
        ...

    async def maps_with(self, label: str, limit: int) -> tuple[int, ...]:
        """Numbers of maps in which something of the label is remembered."""
        ...

    async def rooms(self, map_number: int) -> tuple[KeptRoom, ...]:
        """By their ids."""
        ...

    async def add_rooms(self, map_number: int, places: Sequence[tuple[float, float]]) -> bool:
        """Rooms without a name, by a place in each (x, y in m). False, and nothing is kept, where no such map is."""
        ...

    async def name_room(self, map_number: int, room_id: int, name: str, shown: Collection[int]) -> int | None:
        """The id of the room that bears the name now: another's of those `shown` where that had it before, and nothing
        has changed; one that is not shown loses it. None, and nothing has changed, where no such map is."""
        ...

    async def remember(self, frames: Sequence[Frame]) -> Tally:
        """All or nothing, and durable on return."""
        ...

    async def views(self, label: str | None, limit: int, map_number: int | None = None) -> list[StoredView]:
        """The label's views, or all: confidence descending, of equals the one first seen first."""
        ...

    async def things(
        self, label: str | None, area: Area | None, limit: int, map_number: int | None = None
    ) -> list[MapObject]:
        """Last seen first."""
        ...

    async def thing(self, number: int) -> MapObject | None: ...

    async def labels(self, limit: int, map_number: int | None = None) -> list[LabelCount]:
        """Most views first, of equals by name."""
        ...

    async def candidates(
        self, wanted: Mapping[str, Collection[str]], *, map_number: int = 0, views_a_thing: int, views_max: int
    ) -> dict[str, Candidates]:
        """By label, of one map, as things are at one moment. Of each thing so many of its best views; the best views
        without a thing. `wanted` maps each label to the colours asked for: no limit leaves them out for others."""
        ...

    async def forget(self, what: ForgetRequest, map_number: int | None = None) -> int:
        """How many things and views there were. Afterwards they are not in the files either."""
        ...

    async def forget_thing(self, number: int) -> int:
        """The thing and its views; 0 where there is none."""
        ...

    async def tidy(self, *, lost_before_s: float, seen_before_s: float) -> int:
        """Forgets what was lost long ago, what was hardly ever there, and what was last seen too long ago."""
        ...

    async def counts(self) -> Counts: ...

    def export_batches(self) -> AsyncGenerator[ExportBatch]:
        """Everything, a bounded part at a time: the things first."""
        ...

    async def import_batch(self, hoard: ExportBatch) -> None:
        """All or nothing. What is there already is not doubled."""
        ...

    async def snapshot(self) -> DatabaseCopy:
        """Everything at one moment, as an SQLite file; others go on writing. `ConflictError` while another copy is
        made, `UnprocessableError` where the database has a back-up of its own, as for `candidate`."""
        ...

    def candidate(self, body: AsyncIterable[bytes], *, bytes_max: int) -> AbstractAsyncContextManager[JudgedDatabase]:
        """A snapshot that came back, judged, for `replace` inside the block. `TooLargeError`, `UnprocessableError`."""
        ...

    async def replace(self, candidate: JudgedDatabase) -> str:
        """All or nothing; the name of the file that keeps what was there before."""
        ...

    async def check(self) -> None:
        """Answers within half a second whether it can be written now."""
        ...

    async def aclose(self) -> None: ...


class DepthAndMap(Protocol):
    """robot_bridge. Every method answers none where it cannot be had now, and within a second."""

    async def localize(self, request: LocalizeRequest) -> Sequence[Measurement] | None:
        """How far it is to the nearest thing in each box."""
        ...

    async def ground(self) -> OccupancyGrid | None:
        """The newest map, no older than a few seconds."""
        ...

    async def home(self) -> KnownMap | None:
        """Which home that map is of."""
        ...

    async def aclose(self) -> None: ...
