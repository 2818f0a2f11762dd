"""The live picture, one for all viewers: pulled from robot_bridge only while somebody waits for the next one."""

import asyncio
import contextlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from mesh.clock import Clock
from mesh.errors import MeshError
from ui.overlay import CameraFrame
from ui.ports import Robot

FRESH_S: Final = 0.25
FETCH_WAIT_S: Final = 1.0
PAUSE_S: Final = 0.5
"""After a fetch that failed."""


@dataclass(frozen=True, slots=True)
class Shown:
    """A frame and what is drawn over it, packed once: length (4 bytes, big-endian), JSON, JPEG."""

    frame: CameraFrame
    about: Mapping[str, Any]
    got_s: float
    packed: bytes

    @property
    def stamp_s(self) -> float:
        return self.frame.stamp_s


def pack(about: Mapping[str, Any], jpeg: bytes) -> bytes:
    head = json.dumps(about, separators=(",", ":")).encode()
    return len(head).to_bytes(4, "big") + head + jpeg


class Frames:
    """`other_than` may be called by any number of viewers; they share one fetch. `trouble` says why none comes."""

    def __init__(
        self, robot: Robot, clock: Clock, *, period_s: float, about: Callable[[CameraFrame], Mapping[str, Any]]
    ) -> None:
        self.trouble = ""
        self._robot = robot
        self._clock = clock
        self._period_s = period_s
        self._about = about
        self._newest: Shown | None = None
        self._fetched_s = float("-inf")
        self._fetching: asyncio.Task[None] | None = None

    async def other_than(self, after_s: float | None, *, wait_s: float) -> Shown | None:
        """The newest frame, never an old one, once its stamp is not `after_s`; none when none comes in time."""
        deadline_s = self._clock.now_s() + wait_s
        while True:
            newest = self._newest
            now_s = self._clock.now_s()
            if newest is not None and newest.stamp_s != after_s and now_s - newest.got_s < FRESH_S:
                return newest
            if now_s >= deadline_s:
                return None
            if self._fetching is None or self._fetching.done():
                self._fetching = asyncio.create_task(self._fetch(), name="frame")
            await asyncio.wait({self._fetching}, timeout=deadline_s - now_s)

    async def close(self) -> None:
        if self._fetching is not None:
            self._fetching.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._fetching

    async def _fetch(self) -> None:
        early_s = self._fetched_s + self._period_s - self._clock.now_s()
        if early_s > 0.0:
            await self._clock.sleep(early_s)
        self._fetched_s = self._clock.now_s()
        before = self._newest
        try:
            frame = await self._robot.frame(after_s=before.stamp_s if before is not None else None, wait_s=FETCH_WAIT_S)
            if frame is None:  # nothing newer: unless the robot's clock has begun anew
                frame = await self._robot.frame(after_s=None, wait_s=0.0)
        except MeshError as error:
            self.trouble = error.detail
            await self._clock.sleep(PAUSE_S)
            return
        if frame is None or (before is not None and frame.stamp_s == before.stamp_s):
            self.trouble = "no new picture"
            return
        self.trouble = ""
        about = self._about(frame)
        self._newest = Shown(frame, about, self._clock.now_s(), pack(about, frame.jpeg))
