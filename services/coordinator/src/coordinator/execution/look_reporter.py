"""Tells memory what each look saw, so that it can doubt what should have been there and was not (negative evidence)."""

import asyncio

import structlog

from contracts.memory import Look, LookBatch, SeenBox
from contracts.vision import Detections
from coordinator.core.actions import RecordLook
from coordinator.ports import Memory
from mesh.clock import Clock
from mesh.errors import MeshError, UpstreamError

log = structlog.get_logger()

WAITING_MAX = 20
BATCH = 10
NOT_TAKEN_S = 60.0
NOT_THERE = frozenset({404, 405})


class LookReporter:
    """Bounded: the oldest is dropped. A memory that takes no looks is asked again only now and then."""

    def __init__(self, memory: Memory, clock: Clock) -> None:
        self._memory = memory
        self._clock = clock
        self._waiting: list[Look] = []
        self._news = asyncio.Event()
        self._not_before_s = float("-inf")

    def add(self, look: RecordLook) -> None:
        if look.seen is not None:
            self._waiting = [*self._waiting, as_look(look, look.seen)][-WAITING_MAX:]
            self._news.set()

    async def send_forever(self) -> None:
        while True:
            await self._news.wait()
            self._news.clear()
            while self._waiting and self._clock.now_s() >= self._not_before_s:
                batch, self._waiting = self._waiting[:BATCH], self._waiting[BATCH:]
                await self._send(LookBatch(looks=tuple(batch)))

    async def _send(self, batch: LookBatch) -> None:
        try:
            await self._memory.looks(batch)
        except UpstreamError as error:
            if error.upstream_status in NOT_THERE:
                self._not_before_s = self._clock.now_s() + NOT_TAKEN_S
            log.warning("memory did not take a look", error=error.detail)
        except MeshError as error:
            log.warning("a look was not told to memory", error=error.detail)


def as_look(look: RecordLook, seen: Detections) -> Look:
    return Look(
        pose=look.pose,
        stamp_s=seen.stamp_s,
        image_width_px=seen.image_width_px,
        image_height_px=seen.image_height_px,
        seen=tuple(SeenBox(label=d.label, bbox_xyxy=d.bbox_xyxy) for d in seen.detections),
    )
