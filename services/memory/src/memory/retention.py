"""Now and then forgets what is over: ghosts, what is too old, and labels that have since been excluded."""

import structlog

from contracts.memory import ForgetRequest
from memory.frames import Exclusion
from memory.ports import Store
from memory.settings import Settings
from mesh.clock import Clock
from mesh.errors import UnavailableError
from store.shared_lock import SharedLock

log = structlog.get_logger()

DAY_S = 86_400.0


class Retention:
    def __init__(self, settings: Settings, store: Store, clock: Clock, writing: SharedLock) -> None:
        self._settings = settings
        self._store = store
        self._clock = clock
        self._writing = writing
        self._excluded = Exclusion.of(settings.excluded_labels)

    async def tidy_forever(self) -> None:
        while True:
            try:
                await self.tidy()
            except UnavailableError as error:
                log.warning("could not tidy up; trying again", error=error.detail)
            await self._clock.sleep(self._settings.tidy_period_s)

    async def tidy(self) -> int:
        """How much was forgotten. Ages count back from the newest sighting: a clock that jumps ahead must not wipe out
        everything."""
        async with self._writing.shared():  # ages of one database are no reason to forget in another
            forgotten, newest_s = 0, 0.0
            for known in await self._store.labels(10_000):
                newest_s = max(newest_s, known.last_seen_s)
                if known.label in self._excluded:
                    forgotten += await self._store.forget(ForgetRequest(label=known.label))
            return forgotten + await self._store.tidy(
                lost_before_s=newest_s - self._settings.lost_retention_days * DAY_S,
                seen_before_s=newest_s - self._settings.retention_days * DAY_S,
            )
