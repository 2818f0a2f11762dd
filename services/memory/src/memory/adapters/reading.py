"""What is read, each function inside one read transaction."""

from collections.abc import Collection, Sequence
from operator import itemgetter
from typing import Any

from pydantic import TypeAdapter
from sqlalchemy import ColumnElement, Connection, Row, bindparam, func, literal_column, select

from contracts.memory import Area, LabelCount
from contracts.rooms import NamedBy, NamedRoom, RoomName
from memory.adapters.rows import COLOURS_AT, THING, VIEW, thing_of, view_of
from memory.adapters.tables import maps, rooms, things, views
from memory.objects import MapObject, to_message
from memory.ports import Candidates, Counts, ExportBatch, StoredView

PAGE = 2000
VOTES = TypeAdapter(dict[str, float])
ROOM_NAME: TypeAdapter[str] = TypeAdapter(RoomName)
NUMBER_MAX = 2**31 - 2
"""Of a room: the next one's has to fit."""
BY_ID = itemgetter(0)
"""Of rows of `VIEW`."""
THINGS_A_LABEL = 40
"""Recall looks at no more things of one label than this, the most believed."""
THINGS_A_COLOUR = 10
"""The most believed of a colour asked for are among them, however many others there are."""
VIEWS_A_COLOUR = 25
"""The same of views without a thing."""


def best_views(connection: Connection, label: str | None, limit: int, map_number: int | None) -> list[StoredView]:
    query = select(*VIEW).order_by(views.c.confidence.desc(), views.c.id).limit(limit)
    if map_number is not None:
        query = query.where(views.c.map_number == map_number)
    if label is not None:
        query = query.where(views.c.label == label)
    return _coloured(connection, connection.execute(query).all())


def some_things(
    connection: Connection, label: str | None, area: Area | None, limit: int, map_number: int | None
) -> list[MapObject]:
    query = select(*THING).order_by(things.c.last_seen_s.desc(), things.c.id).limit(limit)
    if map_number is not None:
        query = query.where(things.c.map_number == map_number)
    if label is not None:
        query = query.where(things.c.label == label)
    if area is not None:
        query = query.where(things.c.x.between(area.x_min, area.x_max), things.c.y.between(area.y_min, area.y_max))
    return [thing_of(row) for row in connection.execute(query)]


def one_thing(connection: Connection, number: int) -> MapObject | None:
    row = connection.execute(select(*THING).where(things.c.id == number)).one_or_none()
    return thing_of(row) if row is not None else None


def labels(connection: Connection, limit: int, map_number: int | None) -> list[LabelCount]:
    count = func.count().label("views")
    # By `label || ''`, which no index has: by their order SQLite would fetch every row from elsewhere in the file.
    rows = select((views.c.label + "").label("label"), views.c.confidence, views.c.last_seen_s)
    counted = select(things.c.label, func.count().label("things")).group_by(things.c.label)
    if map_number is not None:
        rows = rows.where(views.c.map_number + 0 == map_number)  # not by the index, for the same reason
        counted = counted.where(things.c.map_number == map_number)
    every = rows.subquery("every")
    query = (
        select(
            every.c.label,
            count,
            func.max(every.c.confidence).label("best_confidence"),
            func.max(every.c.last_seen_s).label("last_seen_s"),
        )
        .group_by(every.c.label)
        .order_by(count.desc(), _by_bytes(connection))
        .limit(limit)
    )
    of_label = {row.label: row.things for row in connection.execute(counted)}
    return [
        LabelCount(
            label=row.label,
            views=row.views,
            best_confidence=row.best_confidence,
            last_seen_s=row.last_seen_s,
            objects=of_label.get(row.label, 0),
        )
        for row in connection.execute(query)
    ]


def candidates(
    connection: Connection,
    label: str,
    colours: Collection[str],
    *,
    map_number: int,
    views_a_thing: int,
    views_max: int,
) -> Candidates:
    """A few rows a thing by an index each, not all rows of the label: a year leaves thousands.

    Where there are more than that, what is of a colour asked for is not left out for others.
    """
    of = {"label": label, "map_number": map_number}
    found = {row[0]: thing_of(row) for row in connection.execute(_LIKELY, of).all()}
    shown: list[Sequence[Any]] = [*connection.execute(_WITHOUT_THING, {**of, "most": views_max}).all()]
    more_things, more_views = len(found) == THINGS_A_LABEL, len(shown) == views_max
    known = {row[0] for row in shown}
    for colour in colours:
        if more_things:
            rows = connection.execute(_LIKELY_IN_COLOUR, {**of, "voted": f'%"{colour}"%'}).all()
            found.update((row[0], thing_of(row)) for row in rows if row[0] not in found)
        if more_views:
            rows = connection.execute(_WITHOUT_THING_IN_COLOUR, {**of, "colour": colour}).all()
            shown += [row for row in rows if row[0] not in known]
    if found:
        shown += connection.execute(_OF_THINGS, {"numbers": list(found), "each": views_a_thing}).all()
    shown.sort(key=BY_ID)
    return Candidates(found, tuple(_in_colour(shown, found)))


def _of_things() -> Any:
    best = views.alias("best")
    of_thing = (
        select(best.c.id)
        .where(best.c.thing_id == things.c.id, best.c.label == things.c.label)  # both, for the index
        .correlate(things)
        .order_by(best.c.confidence.desc(), best.c.id)
        .limit(bindparam("each"))
    )
    shown = select(*VIEW).select_from(things.join(views, views.c.id.in_(of_thing)))
    return shown.where(things.c.id.in_(bindparam("numbers", expanding=True)))


# Written once: to build them anew takes longer than to run them.
_LIKELY = (
    select(*THING)
    .where(things.c.map_number == bindparam("map_number"), things.c.label == bindparam("label"))
    .order_by(things.c.belief.desc(), things.c.last_seen_s.desc(), things.c.id)
    .limit(THINGS_A_LABEL)
)
_LIKELY_IN_COLOUR = _LIKELY.where(things.c.colours.like(bindparam("voted"))).limit(THINGS_A_COLOUR)
_WITHOUT_THING = (
    select(*VIEW)
    .where(
        views.c.map_number == bindparam("map_number"),
        views.c.label == bindparam("label"),
        views.c.thing_id.is_(None),
    )
    .order_by(views.c.confidence.desc(), views.c.id)
    .limit(bindparam("most"))
)
_WITHOUT_THING_IN_COLOUR = _WITHOUT_THING.where(views.c.colour == bindparam("colour")).limit(VIEWS_A_COLOUR)
_OF_THINGS = _of_things()


def counts(connection: Connection, database: str) -> Counts:
    row = connection.execute(
        select(
            func.count(func.distinct(views.c.label)),
            func.count(),
            func.coalesce(func.sum(views.c.sightings), 0),
            func.min(views.c.last_seen_s),
            func.max(views.c.last_seen_s),
        )
    ).one()
    found = tuple(thing_of(one) for one in connection.execute(select(*THING)))
    return Counts(
        labels=row[0],
        views=row[1],
        sightings=int(row[2]),
        things=found,
        oldest_s=row[3],
        newest_s=row[4],
        database=database,
        size_bytes=None,
    )


def page(connection: Connection, kind: str, after: int) -> tuple[ExportBatch, int | None]:
    """The next rows after an id, and the id to go on after; none at the end."""
    table, wanted = (things, THING) if kind == "things" else (views, VIEW)
    rows = connection.execute(select(*wanted).where(table.c.id > after).order_by(table.c.id).limit(PAGE)).all()
    going_on = rows[-1].id if len(rows) == PAGE else None
    if kind == "things":
        return ExportBatch(things=tuple(thing_of(row) for row in rows)), going_on
    return ExportBatch(views=tuple(_coloured(connection, rows))), going_on


def everything(connection: Connection) -> None:
    """A `store.backup.Reads`: raises `ValueError` for what could not be told anybody."""
    known = set(connection.execute(select(maps.c.number)).scalars())
    if not known:
        raise ValueError("it holds no map, so nothing can be anywhere")
    for table in (things, views, rooms):
        astray = set(connection.execute(select(table.c.map_number).distinct()).scalars()) - known
        if astray:
            raise ValueError(f"{table.name} are in a map {min(astray)} that it does not hold")
    for row in connection.execute(select(*THING)):
        VOTES.validate_json(row[COLOURS_AT])
        thing = thing_of(row)
        to_message(thing, thing.last_seen_s)
    for room in connection.execute(select(rooms)):
        ROOM_NAME.validate_python(room.name)
        if not (1 <= room.number <= NUMBER_MAX and room.id <= NUMBER_MAX):
            raise ValueError(f"a room has the number {room.number}")
        NamedRoom(id=room.id, name=room.name, named_by=NamedBy.PERSON, x=room.x, y=room.y, area_m2=0.0)
    for row in connection.execution_options(yield_per=PAGE).execute(select(*VIEW)):
        view_of(row).to_message()


def _coloured(connection: Connection, rows: Sequence[Row[Any]]) -> list[StoredView]:
    """With the colours of the things they show."""
    numbers = sorted({row.thing_id for row in rows if row.thing_id is not None})
    known: dict[int, MapObject] = {}
    for start in range(0, len(numbers), 500):
        query = select(*THING).where(things.c.id.in_(numbers[start : start + 500]))
        known.update({row.id: thing_of(row) for row in connection.execute(query)})
    return _in_colour(rows, known)


def _in_colour(rows: Sequence[Sequence[Any]], known: dict[int, MapObject]) -> list[StoredView]:
    colours = {number: thing.colour or "" for number, thing in known.items()}
    return [view_of(row, colours.get(row[-1])) for row in rows]


def _by_bytes(connection: Connection) -> ColumnElement[str]:
    """Names in the same order everywhere, whatever language the database speaks."""
    order: ColumnElement[str] = literal_column('every.label COLLATE "C"')
    return order if connection.dialect.name == "postgresql" else literal_column("every.label")
