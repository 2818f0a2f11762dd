"""The rooms of a map and their names, each function inside one transaction."""

from collections.abc import Sequence

from sqlalchemy import Connection, func, insert, select, update

from memory.adapters.tables import rooms
from memory.ports import KeptRoom


def rooms_of_map(connection: Connection, map_number: int) -> tuple[KeptRoom, ...]:
    query = select(rooms).where(rooms.c.map_number == map_number).order_by(rooms.c.id)
    return tuple(
        KeptRoom(row.id, row.map_number, row.number, row.x, row.y, row.name) for row in connection.execute(query)
    )


def add(connection: Connection, map_number: int, places: Sequence[tuple[float, float]]) -> None:
    most = _most(connection, map_number)
    for number, (x, y) in enumerate(places, most + 1):
        connection.execute(insert(rooms).values(map_number=map_number, number=number, x=x, y=y, name=""))


def name(connection: Connection, map_number: int, room_id: int, called: str) -> int:
    """See `memory.ports.Store.name_room`."""
    if called:
        for other in rooms_of_map(connection, map_number):
            if other.id != room_id and other.name.casefold() == called.casefold():
                return other.id
    of = (rooms.c.id == room_id) & (rooms.c.map_number == map_number)
    connection.execute(update(rooms).where(of).values(name=called))
    return room_id


def merge(connection: Connection, old: int, new: int) -> None:
    """The rooms of one map are of another from now on, with numbers behind those it has."""
    most = _most(connection, new)
    moved = update(rooms).where(rooms.c.map_number == old)
    connection.execute(moved.values(map_number=new, number=rooms.c.number + most))


def _most(connection: Connection, map_number: int) -> int:
    query = select(func.coalesce(func.max(rooms.c.number), 0)).where(rooms.c.map_number == map_number)
    return int(connection.execute(query).scalar_one())
