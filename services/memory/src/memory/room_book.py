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
from mesh.errors import ConflictError, NotFoundError, UnprocessableError
from store.shared_lock import SharedLock

THINGS_MAX = 5000
MOVED = "the robot is in another map since"


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
        known = await self._known(here, found) if found is not None else None
        if found is None or known is None:
            return RoomsReply(map_id=here.id)
        now_s = self._clock.now_s()
        things = [to_message(one, now_s) for one in await self._store.things(None, None, THINGS_MAX, here.number)]
        return RoomsReply(map_id=here.id, rooms=naming.named(found, known, naming.placed(things, found, known)))

    async def placed(self, things: Sequence[RememberedObject], map_number: int) -> list[RememberedObject]:
        """Things of a map with their rooms; as they are where it is not the map the robot is in."""
        here = await self._whereabouts.here()
        found = await self._found(here) if things and map_number == here.number else None
        known = await self._known(here, found) if found is not None else None
        return list(things) if found is None or known is None else naming.placed(things, found, known)

    async def name(self, number: int, name: str) -> NamedRoom:
        """Durable when it returns. Raises `NotFoundError` where this map shows no such room, `ConflictError` where a
        person has given that name to another, and `UnprocessableError` for what a room without a name is called.
        """
        if naming.is_nameless(name):
            raise UnprocessableError(f"{name!r} is what a room is called that nobody has named")
        here = await self._whereabouts.here()
        found = await self._found(here)
        known = await self._known(here, found) if found is not None else None
        meant = next((one for one in (known or {}).values() if one.id == number), None)
        if found is None or meant is None:
            raise NotFoundError(f"the map has no room {number}")
        async with self._writing.shared():
            if not await self._is_still(here):
                raise ConflictError(MOVED)
            kept = naming.matched(await self._store.rooms(here.number), found).known.values()
            if (meant.x, meant.y) not in [(one.x, one.y) for one in kept if one.id == number]:
                raise ConflictError("the rooms are others since: ask for them again")
            holder = await self._store.name_room(here.number, number, name, [one.id for one in kept])
        if holder is None:
            raise ConflictError(MOVED)
        if holder != number:
            raise ConflictError(f"room {holder} is called {name!r} already")
        told = next((one for one in (await self.rooms()).rooms if one.id == number), None)
        if told is None:
            raise NotFoundError(f"its name is taken: the map shows room {number} as another that lies in it")
        return told

    async def _is_still(self, here: KeptMap) -> bool:
        """Whether the map has its number still: it may have been merged into another, or a back-up restored."""
        now = await self._whereabouts.here()
        return (now.id, now.number) == (here.id, here.number)

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

    async def _known(self, here: KeptMap, found: Rooms) -> dict[int, KeptRoom] | None:
        """By the number that the cut map gives each; a room that is new is written down. None where the robot is in
        another map since, and nothing was written.
        """
        first = naming.matched(await self._store.rooms(here.number), found)
        if not first.new:
            return dict(first.known)
        async with self._writing.shared(), self._one:
            if not await self._is_still(here):
                return None
            again = naming.matched(await self._store.rooms(here.number), found)
            places = [(one.x_m, one.y_m) for one in again.new]
            if places and not await self._store.add_rooms(here.number, places):
                return None
            return dict(naming.matched(await self._store.rooms(here.number), found).known)
