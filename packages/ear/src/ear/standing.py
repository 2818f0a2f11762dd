"""While somebody speaks, and while the ear does, the mission stands: held, held again, and let go."""

import asyncio
from dataclasses import dataclass, field
from typing import Final

import structlog

from ear.deadlines import within
from ear.messages import Hold, LetGo
from ear.ports import Coordinator
from mesh.clock import Clock
from mesh.errors import MeshError

log = structlog.get_logger()

STANDS_S: Final = 3.0
"""So long a sentence waits for it: then it is said all the same, as that the coordinator is away has to be said too."""
RENEWALS: Final = 3
"""So many a hold: two of them may get lost."""


@dataclass
class Standing:
    coordinator: Coordinator
    clock: Clock
    hold_s: float
    _wanted: bool = False
    _held: str = ""
    _to_do: asyncio.Queue[Hold | LetGo] = field(default_factory=asyncio.Queue[Hold | LetGo])

    def take(self, action: Hold | LetGo) -> None:
        self._wanted = isinstance(action, Hold)
        self._to_do.put_nowait(action)

    def again(self) -> None:
        """Another mission began, or time has passed: nothing where none is to stand."""
        if self._wanted and self._to_do.empty():
            self._to_do.put_nowait(Hold())

    async def settled(self) -> None:
        """All that was asked for is done, or has failed."""
        await self._to_do.join()

    async def before_a_sentence(self) -> None:
        try:
            await within(self.clock, STANDS_S, self.settled())
        except TimeoutError:
            log.warning("a sentence is said though the mission may not stand")

    async def keep_renewing(self) -> None:
        while True:
            await self.clock.sleep(self.hold_s / RENEWALS)
            self.again()

    async def hold_and_let_go(self) -> None:
        """In their order. A mission that a person paused, or that has ended, is left alone."""
        while True:
            action = await self._to_do.get()
            try:
                match action:
                    case Hold():
                        await self._hold()
                    case LetGo():
                        held, self._held = self._held, ""
                        if held:
                            await self.coordinator.hold(held, for_s=0.0)
            except MeshError as error:
                log.info("not held, or not let go", why=error.detail)
            finally:
                self._to_do.task_done()

    async def _hold(self) -> None:
        mission = (await self.coordinator.status()).mission
        if mission is None or mission.outcome is not None or mission.queue_position is not None:
            self._held = ""
        elif not mission.paused or mission.id == self._held:
            self._held = mission.id  # before it is asked: the answer may get lost
            await self.coordinator.hold(mission.id, for_s=self.hold_s)
