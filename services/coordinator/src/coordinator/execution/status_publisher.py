"""What the coordinator tells the others: the timeline, its state, and what perception should look for."""

import asyncio
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import structlog

from contracts.mission import MissionEvent, MissionStatus, MissionTarget
from contracts.topics import MISSION_EVENTS, MISSION_STATE, MISSION_TARGET
from coordinator.core import actions as do
from coordinator.ports import MissionLog
from mesh.bus import Bus
from mesh.clock import Clock
from mesh.tasks import Tasks
from mesh.tracing import following, traceparent

log = structlog.get_logger()

OUTBOX_MAX = 1000
TARGET_PERIOD_S = 2.0


class StatusPublisher:
    """`state` and `target` say what is true now; they are published on every change and at least every `period_s`.

    `inside` is the trace of the mission under way.
    """

    def __init__(self, *, bus: Bus, log_: MissionLog, clock: Clock, period_s: float,
                 state: Callable[[], MissionStatus], target: Callable[[], MissionTarget],
                 inside: Callable[[], AbstractContextManager[Any]]) -> None:  # fmt: skip
        self._bus = bus
        self._log = log_
        self._clock = clock
        self._period_s = period_s
        self._state = state
        self._target = target
        self._inside = inside
        self._outbox: asyncio.Queue[tuple[MissionEvent, str]] = asyncio.Queue(OUTBOX_MAX)
        self._changed = asyncio.Event()
        self._changed.set()
        self._stated_s = float("-inf")
        self._told: MissionTarget | None = None
        self._told_s = float("-inf")

    def start(self, tasks: Tasks) -> None:
        tasks.start("publish-status", self._publish_status())
        tasks.start("publish-events", self._publish_events())

    def say(self, mission_id: str, action: do.Say) -> None:
        """One line of the timeline of that mission."""
        event = MissionEvent(
            id=self._log.next_event_id,
            mission_id=mission_id,
            stamp_s=max(0.0, self._clock.now_s()),
            state=action.state,
            kind=action.kind,
            text=action.text[:1000],
            data=action.data,
        )
        log.info(action.text, state=action.state.value, kind=action.kind)
        self._log.append(event)
        if self._outbox.full():
            self._outbox.get_nowait()
        self._outbox.put_nowait((event, traceparent()))

    def changed(self) -> None:
        self._changed.set()

    def tick(self) -> None:
        if self._clock.now_s() - self._stated_s >= self._period_s:
            self._changed.set()

    async def _publish_status(self) -> None:
        """The target goes out also now and then, for a Redis that came back empty."""
        while True:
            await self._changed.wait()
            self._changed.clear()
            now_s, target = self._clock.now_s(), self._target()
            with self._inside():
                if target != self._told or now_s - self._told_s >= TARGET_PERIOD_S:
                    self._told, self._told_s = target, now_s
                    await self._bus.publish(MISSION_TARGET, target)
                self._stated_s = now_s
                await self._bus.publish(MISSION_STATE, self._state())

    async def _publish_events(self) -> None:
        while True:
            event, said_in = await self._outbox.get()
            with following(said_in):
                await self._bus.publish(MISSION_EVENTS, event)
