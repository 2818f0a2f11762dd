"""The rooms of the map the robot is in, by name (shell): cut from robot_bridge's map, names kept in the database."""

import asyncio
from collections.abc import Sequence

import structlog

from contracts.memory import RememberedObject
from contracts.rooms import NamedRoom, RoomGrid, RoomsReply
from geometry import room_grids
from geometry.grids import OccupancyGrid
from geometry.rooms import Rooms, rooms_of
from memory import naming
from memory.objects import to_message
from memory.ports import DepthAndMap, KeptMap, KeptRoom, Store
from memory.whereabouts import Whereabouts
from mesh.clock import Clock
from mesh.errors import ConflictError, NotFoundError, UnavailableError, UnprocessableError
from store.shared_lock import SharedLock

log = structlog.get_logger()

THINGS_MAX = 5000
CUT_S_MAX = 10.0
"""The largest map takes about 3 s of one core."""
MOVED = "the robot is in another map since"


class RoomBook:
    """Shares the lock to write. A map is cut once, in a thread, one map at a time: things are told without rooms
    meanwhile, and where it cannot be cut. Who asks for rooms waits for them."""

    def __init__(
        self, store: Store, senses: DepthAndMap | None, whereabouts: Whereabouts, clock: Clock, writing: SharedLock
    ) -> None:
        self._store = store
        self._senses = senses
        self._whereabouts = whereabouts
        self._clock = clock
        self._writing = writing
        self._ground: OccupancyGrid | None = None
        self._cut: asyncio.Task[Rooms | None] | None = None
        self._cutting = asyncio.Lock()
        self._one = asyncio.Lock()

    async def rooms(self) -> RoomsReply:
        """None of them where there is no map now. Raises `UnavailableError` where the database is away, and where the
        map is not cut within `CUT_S_MAX` or cannot be cut.
        """
        here = await self._whereabouts.here()
        found = await self._waited_for(here)
        known = await self._known(here, found) if found is not None else None
        if found is None or known is None:
            return RoomsReply(map_id=here.id)
        now_s = self._clock.now_s()
        things = [to_message(one, now_s) for one in await self._store.things(None, None, THINGS_MAX, here.number)]
        return RoomsReply(map_id=here.id, rooms=naming.named(found, known, naming.placed(things, found, known)))

    async def grid(self) -> RoomGrid:
        """Where the rooms lie that `rooms` names. Raises `NotFoundError` where there is no map now, else as it does."""
        here = await self._whereabouts.here()
        found = await self._waited_for(here)
        known = await self._known(here, found) if found is not None else None
        if found is None or known is None:
            raise NotFoundError("there is no map now that is cut into rooms")
        told = {number: kept.id for number, kept in known.items() if number <= naming.ROOMS_TOLD}
        return await asyncio.to_thread(room_grids.encode, found, told, map_id=here.id)

    async def placed(self, things: Sequence[RememberedObject], map_number: int) -> list[RememberedObject]:
        """Things of a map with their rooms; as they are where it is not the map the robot is in, and where that map is
        not cut yet."""
        here = await self._whereabouts.here()
        cut = await self._cut_of(here) if things and map_number == here.number else None
        found = cut.result() if cut is not None and cut.done() and not _trouble(cut) else None
        known = await self._known(here, found) if found is not None else None
        return list(things) if found is None or known is None else naming.placed(things, found, known)

    async def in_room(
        self, things: Sequence[RememberedObject], map_number: int, room_id: int
    ) -> list[RememberedObject]:
        """Those that stand in that room. Raises `UnavailableError` as `rooms` does."""
        here = await self._whereabouts.here()
        if map_number == here.number:
            await self._waited_for(here)
        return [one for one in await self.placed(things, map_number) if one.room_id == room_id]

    async def name(self, number: int, name: str) -> NamedRoom:
        """Durable when it returns. Raises `NotFoundError` where this map shows no such room, `ConflictError` where a
        person has given that name to another, and `UnprocessableError` for what a room without a name is called.
        """
        if naming.is_nameless(name):
            raise UnprocessableError(f"{name!r} is what a room is called that nobody has named")
        here = await self._whereabouts.here()
        found = await self._waited_for(here)
        known = await self._known(here, found) if found is not None else None
        meant = next((one for one in naming.shown(known or {}) if one.id == number), None)
        if found is None or meant is None:
            raise NotFoundError(f"the map has no room {number}")
        async with self._writing.shared():
            if not await self._is_still(here):
                raise ConflictError(MOVED)
            kept = naming.shown(naming.matched(await self._store.rooms(here.number), found).known)
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

    async def aclose(self) -> None:
        """Waits for no cut; the thread that makes one ends with it."""
        if self._cut is not None:
            self._cut.cancel()
            await asyncio.wait({self._cut})

    async def _waited_for(self, here: KeptMap) -> Rooms | None:
        cut = await self._cut_of(here)
        if cut is None:
            return None
        await asyncio.wait({cut}, timeout=CUT_S_MAX)
        if not cut.done():
            raise UnavailableError("rooms", f"the map is still being cut into rooms after {CUT_S_MAX:.0f} s")
        if _trouble(cut):
            raise UnavailableError("rooms", "the map cannot be cut into rooms")
        return cut.result()

    async def _cut_of(self, here: KeptMap) -> asyncio.Task[Rooms | None] | None:
        """Of the map as it is now, begun where it is a new one. None where there is no map."""
        if self._senses is None:
            return None
        home, ground = await self._senses.home(), await self._senses.ground()
        if ground is None or (home is not None and home.id != here.id):
            return None
        if ground is not self._ground or self._cut is None:
            self._ground = ground
            self._cut = asyncio.create_task(self._make(ground), name="cut-rooms")
            self._cut.add_done_callback(_tell_trouble)
        return self._cut

    async def _make(self, ground: OccupancyGrid) -> Rooms | None:
        """None where a newer map has come before this one's turn."""
        async with self._cutting:
            return await asyncio.to_thread(rooms_of, ground) if ground is self._ground else None

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


def _trouble(cut: asyncio.Task[Rooms | None]) -> bool:
    return cut.cancelled() or cut.exception() is not None


def _tell_trouble(cut: asyncio.Task[Rooms | None]) -> None:
    if not cut.cancelled() and cut.exception() is not None:
        log.error("a map cannot be cut into rooms: things are told without", exc_info=cut.exception())
