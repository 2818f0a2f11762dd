"""What is recorded, as it comes: the robot's own topics and the mesh's, handed to a sink."""

import asyncio
from typing import Any

from contracts.base import Message
from contracts.topics import ALL_TOPICS, Topic
from contracts.vision import Detections
from mesh.bus import Bus
from mesh.clock import Clock
from mesh.tasks import Tasks
from robot_bridge.ports import Kind, Raw, Robot, Sink
from robot_bridge.recording.mcap_file import json_kind

NEVER_STORED = "person"
"""The class that is never written anywhere (requirement A18)."""


class Feed:
    """Runs from its making to `close`."""

    def __init__(
        self, name: str, *, robot: Robot, bus: Bus, clock: Clock, tasks: Tasks, sink: Sink, images_hz: float
    ) -> None:
        """`name` says what it is for. Pictures come at most so often; 0 = none."""
        self._bus = bus
        self._clock = clock
        self._sink = sink
        self._stop_robot = robot.record(sink, images_hz=images_hz)
        self._listeners: list[asyncio.Task[Any]] = [
            tasks.start(f"{name}-{topic.name}", self._listen(topic), forever=False) for topic in ALL_TOPICS
        ]

    def close(self) -> None:
        """Waits for nothing."""
        self._stop_robot()
        for listener in self._listeners:
            listener.cancel()

    async def _listen(self, topic: Topic[Any]) -> None:
        """The mesh's own topics, as JSON."""
        kind = json_kind(topic.message)

        async def heard(message: Message) -> None:
            self._sink(_raw(topic, kind, message, self._clock.now_s()))

        await self._bus.listen(topic, heard)


def _raw(topic: Topic[Any], kind: Kind, message: Message, now_s: float) -> Raw:
    if isinstance(message, Detections):
        kept = tuple(each for each in message.detections if each.label != NEVER_STORED)
        message = message.model_copy(update={"detections": kept})
    return Raw(topic.name, kind, int(now_s * 1e9), message.model_dump_json().encode())
