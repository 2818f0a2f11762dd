"""The rooms of the map the robot is in, by name (shell): cut from robot_bridge's map, names kept in the database."""

import asyncio
from collections.abc import Sequence

from contracts.memory import RememberedObject
from contracts.rooms import NamedRoom, RoomsReply
from geometry.grids import OccupancyGrid
from geometry.rooms import Rooms, rooms_of
from memory import naming
from memory.objects import to_message
from memory.ports import DepthAndMap, KeptMap, KeptRoom, Store
from memory.whereabouts import Whereabouts
from mesh.clock import Clock
from mesh.errors import ConflictError, NotFoundError
from store.shared_lock import SharedLock

THINGS_MAX = 5000


class RoomBook:
    """Shares the lock to write. A map is cut once, in a thread."""

    def __init__(
        self, store: Store, senses: DepthAndMap | None, whereabouts: Whereabouts, clock: Clock, writing: SharedLock
    ) -> None:
        self._store = store
        self._senses = senses
        self._whereabouts = whereabouts
        self._clock = clock
        self._writing = writing
        self._ground: OccupancyGrid | None = None
        self._cut: Rooms | None = None
        self._one = asyncio.Lock()

    async def rooms(self) -> RoomsReply:
        """None of them where there is no map now. Raises `UnavailableError` where the database is away."""
        here = await self._whereabouts.here()
        found = await self._found(here)
        if found is None:
            return RoomsReply(map_id=here.id)
        known = await self._known(here, found)
        now_s = self._clock.now_s()
        things = [to_message(one, now_s) for one in await self._store.things(None, None, THINGS_MAX, here.number)]
        return RoomsReply(map_id=here.id, rooms=naming.named(found, known, naming.placed(things, found, known)))

    async def placed(self, things: Sequence[RememberedObject], map_number: int) -> list[RememberedObject]:
        """Things of a map with their rooms; as they are where it is not the map the robot is in."""
        here = await self._whereabouts.here()
        found = await self._found(here) if things and map_number == here.number else None
        return list(things) if found is None else naming.placed(things, found, await self._known(here, found))

    async def name(self, number: int, name: str) -> NamedRoom:
        """Durable when it returns. Raises `NotFoundError` where this map has no such room, `ConflictError` where a
        person has given that name to another.
        """
        rooms = {one.id: one for one in (await self.rooms()).rooms}
        if number not in rooms:
            raise NotFoundError(f"the map has no room {number}")
        here = await self._whereabouts.here()
        async with self._writing.shared():
            holder = await self._store.name_room(here.number, number, name)
        if holder != number:
            raise ConflictError(f"room {holder} is called {name!r} already")
        return next(one for one in (await self.rooms()).rooms if one.id == number)

    async def _found(self, here: KeptMap) -> Rooms | None:
        if self._senses is None:
            return None
        home, ground = await self._senses.home(), await self._senses.ground()
        if ground is None or (home is not None and home.id != here.id):
            return None
        async with self._one:
            if ground is not self._ground or self._cut is None:
                self._cut = await asyncio.to_thread(rooms_of, ground)
                self._ground = ground
            return self._cut

    async def _known(self, here: KeptMap, found: Rooms) -> dict[int, KeptRoom]:
        """By the number that the cut map gives each; a room that is new is written down."""
        first = naming.matched(await self._store.rooms(here.number), found)
        if not first.new:
            return dict(first.known)
        async with self._writing.shared(), self._one:
            again = naming.matched(await self._store.rooms(here.number), found)
            if again.new:
                await self._store.add_rooms(here.number, [(one.x_m, one.y_m) for one in again.new])
            return dict(naming.matched(await self._store.rooms(here.number), found).known)
