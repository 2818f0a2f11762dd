"""The newest picture's detections, for whoever asks what the robot sees now."""

from contracts.topics import VISION_DETECTIONS
from contracts.vision import Detections
from mesh.bus import Bus
from mesh.clock import Clock
from mesh.errors import UnavailableError
from mesh.tasks import Tasks

VIEW_AGE_S_MAX = 3.0
"""What was seen longer ago is not what the robot sees now."""


class NewestView:
    def __init__(self, bus: Bus, clock: Clock) -> None:
        self._bus = bus
        self._clock = clock
        self._seen: Detections | None = None
        self._came_s = float("-inf")

    def start(self, tasks: Tasks) -> None:
        tasks.start("newest-view", self._bus.listen(VISION_DETECTIONS, self._on_detections))

    async def _on_detections(self, seen: Detections) -> None:
        self._seen, self._came_s = seen, self._clock.now_s()

    def now(self) -> Detections:
        """Raises `UnavailableError` where no picture came lately: on the dock the camera may sleep."""
        if self._seen is None or self._clock.now_s() - self._came_s > VIEW_AGE_S_MAX:
            raise UnavailableError("inference", f"no picture came within {VIEW_AGE_S_MAX:.0f} s")
        return self._seen
