"""The rooms of a map and their names, each function inside one transaction."""

from collections.abc import Collection, Sequence

from sqlalchemy import Connection, func, insert, select, update

from memory.adapters.tables import maps, rooms
from memory.ports import KeptRoom


def rooms_of_map(connection: Connection, map_number: int) -> tuple[KeptRoom, ...]:
    query = select(rooms).where(rooms.c.map_number == map_number).order_by(rooms.c.id)
    return tuple(
        KeptRoom(row.id, row.map_number, row.number, row.x, row.y, row.name) for row in connection.execute(query)
    )


def add(connection: Connection, map_number: int, places: Sequence[tuple[float, float]]) -> bool:
    """See `memory.ports.Store.add_rooms`."""
    if not _is_kept(connection, map_number):
        return False
    most = _most(connection, map_number)
    for number, (x, y) in enumerate(places, most + 1):
        connection.execute(insert(rooms).values(map_number=map_number, number=number, x=x, y=y, name=""))
    return True


def name(connection: Connection, map_number: int, room_id: int, called: str, shown: Collection[int]) -> int | None:
    """See `memory.ports.Store.name_room`."""
    if not _is_kept(connection, map_number):
        return None
    kept = rooms_of_map(connection, map_number)
    others = [one for one in kept if called and one.id != room_id and one.name.casefold() == called.casefold()]
    holder = next((one.id for one in others if one.id in shown), None)
    if holder is not None:
        return holder
    for named, value in (*((one.id, "") for one in others), (room_id, called)):
        of = (rooms.c.id == named) & (rooms.c.map_number == map_number)
        connection.execute(update(rooms).where(of).values(name=value))
    return room_id


def merge(connection: Connection, old: int, new: int) -> None:
    """The rooms of one map are of another from now on, with numbers behind those it has, and without names it has."""
    most = _most(connection, new)
    taken = {one.name.casefold() for one in rooms_of_map(connection, new)}
    for one in rooms_of_map(connection, old):
        called = "" if one.name.casefold() in taken else one.name
        moved = update(rooms).where(rooms.c.id == one.id)
        connection.execute(moved.values(map_number=new, number=one.number + most, name=called))


def _is_kept(connection: Connection, map_number: int) -> bool:
    return connection.execute(select(maps.c.number).where(maps.c.number == map_number)).first() is not None


def _most(connection: Connection, map_number: int) -> int:
    query = select(func.coalesce(func.max(rooms.c.number), 0)).where(rooms.c.map_number == map_number)
    return int(connection.execute(query).scalar_one())
