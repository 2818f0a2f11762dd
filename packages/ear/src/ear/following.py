"""The coordinator's timeline, followed: whether the robot may move, and how its missions ended."""

import asyncio
import contextlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final, assert_never

from contracts.mission import EventKind, MissionEvent, MissionStatus
from ear import words
from ear.ports import Coordinator, Line
from mesh.clock import Clock
from mesh.errors import MeshError
from mesh.tasks import Tasks

NEWS_S_MAX: Final = 60.0
"""Older than that it is no news any more."""
AGAIN_S: Final = 2.0
RUNS: Final = frozenset({EventKind.START, EventKind.RESUME})
ENDS: Final = frozenset({EventKind.FOUND, EventKind.END})


@dataclass
class Following:
    """`begun` is called when a mission begins, `ended` with a sentence on how one ended.

    Whether the robot may move is what the coordinator says of itself, asked whenever it may have changed; until it
    answers, and while the timeline is away, it may.
    """

    coordinator: Coordinator
    clock: Clock
    tasks: Tasks
    begun: Callable[[], None]
    ended: Callable[[str], None]
    may_move: bool = True
    _follows: bool = False
    _in_doubt: asyncio.Event = field(default_factory=asyncio.Event)

    def expect(self) -> None:
        """A mission begins, or may have begun."""
        self.may_move = True
        self._in_doubt.set()

    async def follow(self) -> None:
        async for event in self.coordinator.events():
            match event:
                case Line():
                    self._follows = event is Line.OPEN
                    self.expect()
                case MissionEvent():
                    self._take(event)
                case _:
                    assert_never(event)

    def _take(self, event: MissionEvent) -> None:
        if event.kind in RUNS:
            self.expect()
            self.begun()
        elif event.kind in ENDS:  # of a waiting one, or the robot celebrates still: it says so when it is asked
            self._in_doubt.set()
            self.tasks.start("news", self._tell(event), forever=False)
        elif event.state.settled:
            self._in_doubt.set()

    async def keep_sure(self) -> None:
        while True:
            await self._in_doubt.wait()
            self._in_doubt.clear()
            try:
                status = await self.coordinator.status()
            except MeshError:
                self.expect()
                await self.clock.sleep(AGAIN_S)
            else:
                if self._follows and not self._in_doubt.is_set():  # else the answer may be older than what came
                    self.may_move = may_move(status)

    async def _tell(self, event: MissionEvent) -> None:
        if self.clock.now_s() - event.stamp_s > NEWS_S_MAX or not event.mission_id:
            return
        with contextlib.suppress(MeshError):
            sentence = words.ending(await self.coordinator.mission(event.mission_id))
            if sentence:
                self.ended(sentence)


def may_move(status: MissionStatus) -> bool:
    """It does, or a mission waits that begins next."""
    runs = status.mission is not None and status.mission.outcome is None
    return runs or bool(status.queue) or not status.state.settled
