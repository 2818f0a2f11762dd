"""What is written, each function inside one transaction of the only writer."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from sqlalchemy import Connection, and_, bindparam, case, delete, func, insert, literal, or_, select, true, update
from sqlalchemy.dialects import postgresql, sqlite

from contracts.memory import ForgetRequest
from memory.adapters.rows import THING, VIEW, Values, row_of, row_of_sighting, thing_of, view_of
from memory.adapters.tables import NO_THING, PLACE, things, views
from memory.belief import LOST_BELOW, after_miss
from memory.frames import Frame, Tally
from memory.object_association import Ledger
from memory.objects import MapObject
from memory.ports import ExportBatch, StoredView
from memory.views import CELL_M, LOOKED_M, AggregatedView, ViewCell, contradicted, view_at

EMPTY_LOOK = 0.6
"""The chance that a look from a view's place shows what was seen from there: less than for a thing whose own place is
known, for nothing tells whether something hides it now."""
FORGOTTEN_BELOW = 0.05
HARDLY_SEEN = 2
"""A thing seen no more often than this and then missing was most likely never there."""


def remember(connection: Connection, frames: Sequence[Frame]) -> Tally:
    labels = {one.label for frame in frames for one in frame.seen}
    labels |= {miss.label for frame in frames for miss in frame.misses}
    known = connection.execute(select(*THING).where(things.c.label.in_(sorted(labels)))) if labels else ()
    ledger = Ledger.of(thing_of(row) for row in known)
    confirmed = missed = 0
    for frame in frames:
        tally = ledger.apply(frame)
        confirmed += tally.confirmed
        missed += tally.missed
    numbers = write_things(connection, (ledger.things[number] for number in sorted(ledger.changed, key=abs)))
    write_sightings(connection, ledger.sightings.items(), numbers, add=True)
    for frame in frames:
        if frame.is_look:
            _disbelieve_views(connection, frame)
    return Tally(confirmed=confirmed, missed=missed)


def write_things(connection: Connection, changed: Iterable[MapObject]) -> dict[int, int]:
    """Inserts things whose id is below zero, updates the others; returns the ids the new ones got by those they had."""
    numbers: dict[int, int] = {}
    linked: list[MapObject] = []
    old: list[Values] = []
    for thing in changed:
        if thing.id < 0:
            row = insert(things).values(row_of(thing)).returning(things.c.id)
            numbers[thing.id] = connection.execute(row).scalar_one()
            if thing.moved_from is not None or thing.moved_to is not None:
                linked.append(thing)
        else:
            old.append({"number": thing.id, **row_of(thing)})
            linked.append(thing)
    if old:
        names = [name for name in old[0] if name != "number"]
        change = update(things).where(things.c.id == bindparam("number"))
        connection.execute(change.values({name: bindparam(name) for name in names}), old)
    if linked:
        change = update(things).where(things.c.id == bindparam("number"))
        links = [
            {
                "number": numbers.get(thing.id, thing.id),
                "before": _numbered(thing.moved_from, numbers),
                "after": _numbered(thing.moved_to, numbers),
            }
            for thing in linked
        ]
        connection.execute(change.values(moved_from=bindparam("before"), moved_to=bindparam("after")), links)
    return numbers


def write_sightings(
    connection: Connection, sightings: Iterable[tuple[ViewCell, AggregatedView]], numbers: dict[int, int], *, add: bool
) -> None:
    """`add`: counts add up; else the larger stays, so that importing twice changes nothing."""
    rows = [row_of_sighting(sighting, _numbered(place.thing_id, numbers)) for place, sighting in sightings]
    if rows:
        connection.execute(_merging(_insert(connection), add=add), rows)


def _numbered(number: int | None, numbers: dict[int, int]) -> int | None:
    return number if number is None else numbers.get(number, number)


def merge_loose_views(connection: Connection, old: int, new: int) -> None:
    """Views without a thing of map `old` become views of map `new`; those that say the same count once."""
    names = [column.name for column in views.c if column.name not in {"id", "map_number"}]
    loose = (views.c.map_number == old, views.c.thing_id.is_(None))
    source = select(literal(new), *(views.c[name] for name in names)).where(*loose)
    connection.execute(_merging(_insert(connection).from_select(["map_number", *names], source), add=True))
    connection.execute(delete(views).where(*loose))


def _insert(connection: Connection) -> Any:
    return (postgresql if connection.dialect.name == "postgresql" else sqlite).insert(views)


def _merging(statement: Any, *, add: bool) -> Any:
    """`memory.views.merged`, in SQL: the right-hand sides see the row as it was."""
    new, old = statement.excluded, views.c
    better = new.confidence > old.confidence
    later = new.last_seen_s > old.last_seen_s
    return statement.on_conflict_do_update(
        index_elements=list(PLACE),
        set_={
            "x": case((better, new.x), else_=old.x),
            "y": case((better, new.y), else_=old.y),
            "yaw": case((better, new.yaw), else_=old.yaw),
            "confidence": case((better, new.confidence), else_=old.confidence),
            "last_seen_s": case((later, new.last_seen_s), else_=old.last_seen_s),
            "sightings": old.sightings + new.sightings
            if add
            else case((new.sightings > old.sightings, new.sightings), else_=old.sightings),
            "belief": case((new.belief > old.belief, new.belief), else_=old.belief),
            "believed_s": case((new.believed_s > old.believed_s, new.believed_s), else_=old.believed_s),
        },
    )


def _disbelieve_views(connection: Connection, frame: Frame) -> None:
    """Views without a thing, taken from about here in about this direction, of what this look did not show."""
    reach = LOOKED_M / CELL_M + 1
    column, row = frame.pose.x / CELL_M, frame.pose.y / CELL_M
    near = select(*VIEW).where(
        views.c.map_number == frame.map_number,
        NO_THING == 0,  # as `views_place` has it: for `thing_id IS NULL` SQLite would read every view without a thing
        views.c.cell_x.in_(range(int(column - reach), int(column + reach) + 1)),  # a list: each is a range of the index
        views.c.cell_y.between(int(row - reach), int(row + reach)),
    )
    for found in connection.execute(near).all():
        view = view_of(found)
        if contradicted(view.label, view.pose, view.believed_s, frame):
            belief, _ = after_miss(view.belief, EMPTY_LOOK)
            if belief < FORGOTTEN_BELOW:
                connection.execute(delete(views).where(views.c.id == view.id))
            else:
                values = {"belief": belief, "believed_s": frame.stamp_s}
                connection.execute(update(views).where(views.c.id == view.id).values(values))


def forget(connection: Connection, what: ForgetRequest, map_number: int | None) -> int:
    """Views of a forgotten thing go with it, and are counted."""
    gone = [row.id for row in connection.execute(select(things.c.id).where(_met(things, what, map_number)))]
    count = sum(forget_thing(connection, number) for number in gone)
    return count + connection.execute(delete(views).where(_met(views, what, map_number))).rowcount


def forget_thing(connection: Connection, number: int) -> int:
    its_views = connection.execute(delete(views).where(views.c.thing_id == number)).rowcount
    return its_views + connection.execute(delete(things).where(things.c.id == number)).rowcount


def _met(table: Any, what: ForgetRequest, map_number: int | None) -> Any:
    conditions: list[Any] = [true()]
    if map_number is not None:
        conditions.append(table.c.map_number == map_number)
    if what.label is not None:
        conditions.append(table.c.label == what.label)
    if what.area is not None:
        conditions.append(table.c.x.between(what.area.x_min, what.area.x_max))
        conditions.append(table.c.y.between(what.area.y_min, what.area.y_max))
    if what.seen_after_s is not None:
        conditions.append(table.c.last_seen_s >= what.seen_after_s)
    if what.seen_before_s is not None:
        conditions.append(table.c.last_seen_s < what.seen_before_s)
    return and_(*conditions)


def tidy(connection: Connection, *, lost_before_s: float, seen_before_s: float) -> int:
    lost = things.c.belief < LOST_BELOW
    ghost = and_(lost, things.c.times_seen <= HARDLY_SEEN, things.c.moved_to.is_(None))
    long_lost = and_(lost, things.c.last_seen_s < lost_before_s)
    gone = select(things.c.id).where(or_(ghost, long_lost, things.c.last_seen_s < seen_before_s))
    count = sum(forget_thing(connection, row.id) for row in connection.execute(gone).all())
    return count + connection.execute(delete(views).where(views.c.last_seen_s < seen_before_s)).rowcount


def make_room(connection: Connection, table: Any, most: int, keep: int) -> int:
    """Forgets what was longest not seen when there is more than `most`; returns how many there are."""
    count = connection.execute(select(func.count()).select_from(table)).scalar_one()
    if count <= most:
        return count
    oldest = select(table.c.id).order_by(table.c.last_seen_s, table.c.id).limit(count - keep)
    connection.execute(delete(table).where(table.c.id.in_(oldest)))
    return keep


def import_batch(connection: Connection, hoard: ExportBatch) -> None:
    """A thing of that map and label first seen at that moment within a centimetre is the same, and stays as it is."""
    labels = sorted({thing.label for thing in hoard.things})
    known = [thing_of(row) for row in connection.execute(select(*THING).where(things.c.label.in_(labels)))]
    there = {_fingerprint(thing): thing.id for thing in known}
    numbers = {thing.id: there[_fingerprint(thing)] for thing in hoard.things if _fingerprint(thing) in there}
    new = [thing for thing in hoard.things if thing.id not in numbers]
    named = {thing.id: -index for index, thing in enumerate(new, start=1)}
    given = write_things(
        connection,
        [
            replace(
                thing,
                id=named[thing.id],
                moved_from=_numbered(thing.moved_from, {**numbers, **named}),
                moved_to=_numbered(thing.moved_to, {**numbers, **named}),
            )
            for thing in new
        ],
    )
    numbers.update({thing.id: given[named[thing.id]] for thing in new})
    sightings = [_sighting(view) for view in hoard.views]
    write_sightings(connection, ((one.place, one) for one in sightings), numbers, add=False)


def _sighting(view: StoredView) -> AggregatedView:
    return view_at(
        view.label,
        "" if view.thing_id is not None else view.colour,
        view.pose,
        confidence=view.confidence,
        last_seen_s=view.last_seen_s,
        count=view.count,
        thing_id=view.thing_id,
        map_number=view.map_number,
    )


def _fingerprint(thing: MapObject) -> tuple[int, str, float, float, float]:
    return thing.map_number, thing.label, thing.first_seen_s, round(thing.x, 2), round(thing.y, 2)
