"""The forms in which memory is given away and taken back (pure).

FULL is JSON lines: a header, then one map a line, one object a line, one view a line; they name their map and their
object by the number it has in the same file. Version 1 had no maps: what it holds is of the map the robot is in.
SEEDS is `memory.json` of the documents this project comes from: class -> [{x, y, yaw, confidence, time}], of one map.
"""

import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, field, replace
from typing import Annotated, Any, Literal

from pydantic import Field, TypeAdapter, ValidationError

from contracts.base import Confidence, Label, Message, StampS
from contracts.geometry import Pose2D
from contracts.memory import Belief, ColourWord
from memory.frames import Exclusion
from memory.objects import MapObject
from memory.ports import ExportBatch, KeptMap, StoredView
from memory.views import view_at

FORMAT = "atom-memory"
VERSION = 2
RECORDS_MAX = 1_000_000
Metres = Annotated[float, Field(ge=-10_000.0, le=10_000.0)]
Count = Annotated[int, Field(ge=1, le=2**31 - 1)]
Number = Annotated[int, Field(ge=1, le=2**31 - 1)]
MapNumber = Annotated[int, Field(ge=0, le=2**31 - 1)]


class MalformedError(ValueError):
    """Says which line or record is wrong, and how."""


class Header(Message):
    kind: Literal["header"] = "header"
    format: Literal["atom-memory"] = FORMAT
    version: Literal[1, 2] = VERSION


class MapLine(Message):
    kind: Literal["map"] = "map"
    number: MapNumber
    id: str = Field(max_length=40)
    last_seen_s: StampS


class ThingLine(Message):
    kind: Literal["object"] = "object"
    id: Number
    label: Label
    x: Metres
    y: Metres
    z: Metres
    variance_m2: float = Field(ge=0.0, le=1e6)
    belief: Belief
    believed_s: StampS
    confidence: Confidence
    first_seen_s: StampS
    last_seen_s: StampS
    times_seen: Count
    colours: dict[ColourWord, Annotated[float, Field(ge=0.0, le=1e6)]] = Field(max_length=50)
    times_missed: Annotated[int, Field(ge=0, le=2**31 - 1)]
    last_missed_s: StampS | None
    miss_x: Metres
    miss_y: Metres
    miss_loss: float = Field(gt=0.0, le=1.0)
    moved_from: Number | None
    moved_to: Number | None
    map_number: MapNumber = 0
    embedding_model: str = Field(max_length=64)
    embedding: tuple[Annotated[float, Field(ge=-1.001, le=1.001)], ...] = Field(max_length=1024)


class ViewLine(Message):
    kind: Literal["view"] = "view"
    label: Label
    colour: ColourWord
    x: Metres
    y: Metres
    yaw: float = Field(ge=-6.2832, le=6.2832)
    confidence: Confidence
    last_seen_s: StampS
    count: Count
    belief: Belief
    believed_s: StampS
    map_number: MapNumber = 0
    thing_id: Number | None


class SeedsRecord(Message):
    """As the documents name its parts; `time` in seconds since the Unix epoch."""

    x: Metres
    y: Metres
    yaw: float = Field(ge=-1e6, le=1e6, description="rad")
    confidence: Confidence
    time: StampS


LINES: TypeAdapter[Header | MapLine | ThingLine | ViewLine] = TypeAdapter(
    Annotated[Header | MapLine | ThingLine | ViewLine, Field(discriminator="kind")]
)
SEEDS: TypeAdapter[dict[Label, list[SeedsRecord]]] = TypeAdapter(dict[Label, list[SeedsRecord]])


@dataclass(frozen=True, slots=True)
class Brought:
    """What an import holds, and how many of its records are of excluded labels."""

    hoard: ExportBatch
    ignored: int


def header_line() -> str:
    return Header().model_dump_json() + "\n"


def lines_of(hoard: ExportBatch) -> Iterator[str]:
    for one in hoard.maps:
        yield MapLine(number=one.number, id=one.id, last_seen_s=one.last_seen_s).model_dump_json() + "\n"
    for thing in hoard.things:
        yield json.dumps({"kind": "object", **asdict(thing)}, ensure_ascii=False) + "\n"
    for view in hoard.views:
        written = asdict(view)
        del written["id"]
        yield json.dumps({"kind": "view", **written}, ensure_ascii=False) + "\n"


def seeds_of(label: str, views: Iterable[StoredView]) -> str:
    """One class of the seeds' form, as `"label": [...]`; the views come by confidence descending."""
    records = [
        {"x": one.x, "y": one.y, "yaw": one.yaw, "confidence": one.confidence, "time": one.last_seen_s} for one in views
    ]
    return f"{json.dumps(label, ensure_ascii=False)}: {json.dumps(records)}"


@dataclass
class Reading:
    """A FULL export, line by line; what is wrong is raised with the line's number."""

    excluded: Exclusion
    things: dict[int, MapObject] = field(default_factory=dict[int, MapObject])
    views: list[StoredView] = field(default_factory=list[StoredView])
    maps: dict[int, KeptMap] = field(default_factory=dict[int, KeptMap])
    ignored_things: set[int] = field(default_factory=set[int])
    ignored_views: int = 0

    def take(self, number: int, line: bytes) -> None:
        try:
            read = LINES.validate_json(line)
        except ValidationError as error:
            raise MalformedError(f"line {number}: {_told(error)}") from error
        if isinstance(read, Header) != (number == 1):
            raise MalformedError(f"line {number}: the header must be the first line, and only it")
        if isinstance(read, MapLine):
            self.maps[read.number] = KeptMap(read.number, read.id, read.last_seen_s)
        elif isinstance(read, Header):
            return
        elif self.maps and read.map_number not in self.maps:
            raise MalformedError(f"line {number}: it is of map {read.map_number}, which is not above it")
        elif isinstance(read, ThingLine):
            self._thing(number, read)
        else:
            self._view(number, read)
        if len(self.maps) + len(self.things) + len(self.views) > RECORDS_MAX:
            raise MalformedError(f"more than {RECORDS_MAX} records")

    def _thing(self, number: int, read: ThingLine) -> None:
        if read.label in self.excluded:
            self.ignored_things.add(read.id)
        elif read.id in self.things:
            raise MalformedError(f"line {number}: a second object {read.id}")
        else:
            self.things[read.id] = MapObject(**read.model_dump(exclude={"kind"}))

    def _view(self, number: int, read: ViewLine) -> None:
        if read.label in self.excluded or read.thing_id in self.ignored_things:
            self.ignored_views += 1
        elif read.thing_id is not None and read.thing_id not in self.things:
            raise MalformedError(f"line {number}: a view of object {read.thing_id}, which is not above it")
        else:
            self.views.append(StoredView(id=0, **read.model_dump(exclude={"kind"})))

    def brought(self) -> Brought:
        whole = (
            replace(
                one,
                moved_from=one.moved_from if one.moved_from in self.things else None,
                moved_to=one.moved_to if one.moved_to in self.things else None,
            )
            for one in self.things.values()
        )
        hoard = ExportBatch(tuple(whole), tuple(self.views), tuple(self.maps.values()))
        return Brought(hoard, self.ignored_views + len(self.ignored_things))


def read_full(data: bytes, excluded: Exclusion) -> Brought:
    """Raises `MalformedError`; what is brought is whole: every view's object and every link is in it."""
    reading = Reading(excluded)
    lines = data.splitlines()
    if not lines:
        raise MalformedError("line 1: the header is missing")
    for number, line in enumerate(lines, start=1):
        reading.take(number, line)
    return reading.brought()


def read_seeds(data: bytes, excluded: Exclusion) -> Brought:
    """Raises `MalformedError`. Records of one cell and sector become one view, as if they had been seen here."""
    try:
        found = SEEDS.validate_json(data)
    except ValidationError as error:
        raise MalformedError(_told(error)) from error
    if sum(map(len, found.values())) > RECORDS_MAX:
        raise MalformedError(f"more than {RECORDS_MAX} records")
    views = [_view(label, one) for label, records in found.items() if label not in excluded for one in records]
    return Brought(
        ExportBatch(views=tuple(views)), sum(len(records) for label, records in found.items() if label in excluded)
    )


def _view(label: str, record: SeedsRecord) -> StoredView:
    yaw = math.remainder(record.yaw, 2.0 * math.pi)
    pose = Pose2D(x=record.x, y=record.y, yaw=yaw)
    kept = view_at(
        label,
        "",
        pose,
        confidence=record.confidence,
        last_seen_s=record.time,
        count=1,
        thing_id=None,
        map_number=0,
    )
    return StoredView(
        id=0,
        label=label,
        colour="",
        x=pose.x,
        y=pose.y,
        yaw=yaw,
        confidence=record.confidence,
        last_seen_s=record.time,
        count=1,
        belief=kept.belief,
        believed_s=record.time,
        map_number=0,
        thing_id=None,
    )


def _told(error: ValidationError) -> str:
    """The first trouble, without what was written there."""
    first: Any = error.errors(include_input=False, include_url=False)[0]
    where = ".".join(str(part) for part in first["loc"])
    return f"{where}: {first['msg']}" if where else str(first["msg"])
