"""The maps that what is remembered belongs to, each function inside one transaction."""

from collections.abc import Collection

from sqlalchemy import Connection, delete, func, insert, select, update

from memory.adapters import rooms
from memory.adapters.tables import maps, things, views
from memory.adapters.writing import merge_loose_views
from memory.ports import ExportBatch, KeptMap, in_maps

NOBODY_KNOWS = ""
"""The id of a map that nobody has named."""


def all_maps(connection: Connection) -> tuple[KeptMap, ...]:
    rows = connection.execute(select(maps).order_by(maps.c.last_seen_s.desc(), maps.c.number.desc()))
    return tuple(KeptMap(row.number, row.id, row.last_seen_s) for row in rows)


def sizes(connection: Connection) -> dict[int, tuple[int, int]]:
    """Reads both tables from end to end."""
    of: list[dict[int, int]] = []
    for table in (views, things):
        counted = select(table.c.map_number, func.count()).group_by(table.c.map_number)
        of.append({row[0]: row[1] for row in connection.execute(counted)})
    return {number: (of[0].get(number, 0), of[1].get(number, 0)) for number in {*of[0], *of[1]}}


def map_numbered(connection: Connection, map_id: str, seen_s: float) -> int:
    """Of a map by its id; it gets a number where it has none."""
    found = connection.execute(select(maps.c.number).where(maps.c.id == map_id)).scalar_one_or_none()
    if found is not None:
        return found
    return connection.execute(insert(maps).values(id=map_id, last_seen_s=seen_s).returning(maps.c.number)).scalar_one()


def in_kept_maps(connection: Connection, hoard: ExportBatch) -> ExportBatch:
    """The hoard with the numbers that its maps have here."""
    return in_maps(hoard, {one.number: map_numbered(connection, one.id, one.last_seen_s) for one in hoard.maps})


def enter(connection: Connection, map_id: str, was: Collection[str], now_s: float) -> int:
    """See `memory.ports.Store.enter_map`."""
    known = {row.id: row.number for row in connection.execute(select(maps.c.id, maps.c.number))}
    if map_id not in known and set(known) == {NOBODY_KNOWS}:
        connection.execute(update(maps).values(id=map_id))
        known = {map_id: known[NOBODY_KNOWS]}
    number = known[map_id] if map_id in known else map_numbered(connection, map_id, now_s)
    for other in was:
        if other in known and known[other] != number:
            _merge(connection, known[other], number)
    connection.execute(update(maps).where(maps.c.number == number).values(last_seen_s=now_s))
    return number


def _merge(connection: Connection, old: int, new: int) -> None:
    merge_loose_views(connection, old, new)
    rooms.merge(connection, old, new)
    for table in (things, views):
        connection.execute(update(table).where(table.c.map_number == old).values(map_number=new))
    connection.execute(delete(maps).where(maps.c.number == old))


def maps_with(connection: Connection, label: str, limit: int) -> tuple[int, ...]:
    """By one look into an index for each map."""
    numbers = connection.execute(select(maps.c.number).order_by(maps.c.last_seen_s.desc()).limit(limit)).scalars().all()
    seen = select(views.c.id).where(views.c.label == label).limit(1)
    return tuple(one for one in numbers if connection.execute(seen.where(views.c.map_number == one)).first())
