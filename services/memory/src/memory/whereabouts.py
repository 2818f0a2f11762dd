"""Which map the robot is in, for what is remembered belongs to one (shell)."""

import structlog

from contracts.robot import RobotState
from memory.ports import DepthAndMap, KeptMap, Store
from mesh.clock import Clock
from mesh.errors import NotFoundError, UnavailableError
from store.shared_lock import SharedLock

log = structlog.get_logger()

MAPS_TOLD = 20


class Whereabouts:
    """robot_bridge says which map it is, on the bus and with its map; until it does, the robot is where it was last."""

    def __init__(self, store: Store, senses: DepthAndMap | None, clock: Clock, writing: SharedLock) -> None:
        """Shares the lock to write down where the robot is."""
        self._writing = writing
        self._store = store
        self._senses = senses
        self._clock = clock
        self._here: KeptMap | None = None
        self._was: tuple[str, ...] = ()
        self._maps: dict[int, KeptMap] = {}

    async def here(self) -> KeptMap:
        """Raises `UnavailableError` where the database is away."""
        if self._here is None:
            await self._know()
            self._here = next(iter(self._maps.values()))
        return self._here

    async def number(self, map_id: str | None) -> int:
        """Of a map by its id, or of the one the robot is in. Raises `NotFoundError`."""
        here = await self.here()
        if map_id is None or map_id == here.id:
            return here.number
        known = next((one.number for one in self._maps.values() if one.id == map_id), None)
        if known is None:
            raise NotFoundError(f"nothing is remembered of a map {map_id!r}")
        return known

    async def elsewhere(self, label: str) -> tuple[str, ...]:
        """Ids of other maps in which such a thing is remembered."""
        here = await self.here()
        if len(self._maps) < 2:
            return ()
        found = await self._store.maps_with(label, MAPS_TOLD)
        return tuple(self._maps[one].id for one in found if one != here.number and one in self._maps)

    async def hear(self, state: RobotState) -> None:
        """What the bus says of the robot."""
        if state.map_id is not None and (self._here is None or state.map_id != self._here.id):
            await self._enter(state.map_id, ())

    async def ask(self) -> None:
        """Asks the bridge, which also knows what maps the present one was."""
        home = await self._senses.home() if self._senses is not None else None
        if home is not None and (self._here is None or (home.id, home.was) != (self._here.id, self._was)):
            await self._enter(home.id, home.was)

    async def know_again(self) -> None:
        """The database is another one: the map has another number there, or none yet."""
        here, self._here = self._here, None
        if here is not None and here.id:
            await self._enter_alone(here.id, self._was)

    async def _enter(self, map_id: str, was: tuple[str, ...]) -> None:
        async with self._writing.shared():
            await self._enter_alone(map_id, was)

    async def _enter_alone(self, map_id: str, was: tuple[str, ...]) -> None:
        try:
            number = await self._store.enter_map(map_id, was, self._clock.now_s())
            await self._know()
        except UnavailableError as error:
            log.warning("which map the robot is in could not be written; trying again", error=error.detail)
            return
        if self._here is not None and self._here.id != map_id:
            log.info("the robot is in another map: what is remembered of others stays apart", map=map_id)
        self._here, self._was = self._maps[number], was

    async def _know(self) -> None:
        self._maps = {one.number: one for one in await self._store.maps()}
