"""The perception loop (requirement A7): newest frame, look, tell; one frame in flight, nothing queued."""

import asyncio
from dataclasses import dataclass, field

import cv2
import numpy as np
import structlog
from prometheus_client import Counter, Histogram

from contracts.measuring import LocalizeRequest, NotMeasured, not_measured
from contracts.mission import MissionTarget
from contracts.topics import MISSION_TARGET, VISION_DETECTIONS, VISION_OBJECT_SPOTTED
from contracts.vision import Detection, Detections, ObjectSpotted, Target
from inference.boxes import best_target, scaled
from inference.perception.annotate import AnnotatedFrame
from inference.perception.models import Models
from inference.ports import Camera, Frame, RgbImage
from inference.settings import Settings
from mesh.bus import Bus
from mesh.clock import Clock
from mesh.errors import MeshError, UnavailableError, UpstreamError
from mesh.latest_value import LatestValue
from mesh.metrics import Rounds
from mesh.tracing import Tracer, following, traceparent

log = structlog.get_logger()

TRACER = Tracer(__name__)

FRAMES = Counter("inference_frames_total", "camera frames looked at")
TROUBLES = Counter(
    "inference_perception_troubles_total", "rounds of the perception loop that came to nothing", ["kind"]
)
LOOKS = Histogram(
    "inference_look_seconds",
    "from a frame's arrival to what was seen in it being told",
    buckets=(0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 5.0),
)
UNMEASURED = Counter("inference_frames_unmeasured_total", "frames whose boxes robot_bridge did not measure in time")

PAUSE_S = 0.5
"""Between attempts while the bridge is away."""
SLICE_S = 0.1
"""Longest sleep between frames before the wanted rate is looked at again."""
EARLY_S = 0.05
"""How long before it is due a frame is asked for: the request waits at the camera, and the frame for nobody."""
STAMP_SLACK_S = 0.02
"""A frame this much earlier than a period after the last will do: cameras are not exact."""


@dataclass
class Perception:
    """`run()` and `follow_target()` are two background tasks; both live as long as the service."""

    settings: Settings
    camera: Camera
    models: Models
    bus: Bus
    clock: Clock
    wanted: MissionTarget = field(default_factory=MissionTarget)
    annotated: LatestValue[AnnotatedFrame] = field(default_factory=LatestValue[AnnotatedFrame])
    viewers: int = 0
    """Of the annotated stream, now."""
    trouble: str = "no frame yet"
    _last_stamp_s: float | None = None
    _came_s: float | None = None
    """When the last frame came, on this machine's clock; none where the last round brought none."""
    _last_frame_s: float | None = None
    _last_spotted_s: float | None = None
    _wanted_in: str = ""
    """The trace that asks for the target; '' while nobody does."""

    async def follow_target(self) -> None:
        async def changed(message: MissionTarget) -> None:
            self.wanted = message
            self._wanted_in = traceparent() if message.target is not None else ""

        await self.bus.listen(MISSION_TARGET, changed)

    async def run(self) -> None:
        await self.models.open()
        rounds = Rounds("perception")
        while True:
            rounds.turn()
            began_s = self.clock.now_s()
            try:
                await self.once()
            except MeshError as error:
                self._in_trouble(type(error).__name__, error.detail)
                await self.clock.sleep(PAUSE_S)
            await self._rest(began_s)

    async def once(self) -> None:
        """One frame, if a new one comes in time. Raises `MeshError` when something it needs is away."""
        self.models.detector()
        self._came_s = None
        frame = await self.camera.newest(after_s=self._after_s(), wait_s=self.settings.frame_wait_s)
        if frame is None or frame.stamp_s == self._last_stamp_s:
            self._in_trouble("no frame", "no new frame from the camera")
            return
        self._last_stamp_s, self._came_s = frame.stamp_s, self.clock.now_s()
        with LOOKS.time(), following(self._wanted_in), TRACER.part("look"):
            await self._look_at(frame)

    def frame_age_s(self) -> float | None:
        """Since a frame was last looked at, on this machine's clock; none before the first."""
        return None if self._last_frame_s is None else self.clock.now_s() - self._last_frame_s

    async def _look_at(self, frame: Frame) -> None:
        target = self.wanted.target
        sight = await self.models.see(frame.jpeg, target, shrink=self._shrunk, own=True)
        image, look = sight.image, sight.look
        x, y = self._scale(image)
        size_px = (image.shape[1], image.shape[0])
        found = await self._measured(tuple(scaled(one, x, y) for one in look.detections), frame.stamp_s, size_px)
        seen = Detections(
            stamp_s=frame.stamp_s,
            image_width_px=size_px[0],
            image_height_px=size_px[1],
            pose=frame.pose,
            detections=found,
            model=look.model,
            took_ms=look.took_ms,
        )
        await self.bus.publish(VISION_DETECTIONS, seen)
        if target is not None:
            await self._announce(seen, target)
        self._last_frame_s = self.clock.now_s()
        self.trouble = ""
        FRAMES.inc()
        settings = self.settings
        shown = AnnotatedFrame(image, found, target, settings.annotated_width_px, settings.jpeg_quality)
        self.annotated.put(shown, frame.stamp_s)

    async def _measured(
        self, found: tuple[Detection, ...], stamp_s: float, size_px: tuple[int, int]
    ) -> tuple[Detection, ...]:
        """The detections with their places: one call a frame, and never waited for beyond its bound."""
        if not found:
            return found
        request = LocalizeRequest(
            boxes_xyxy=tuple(one.bbox_xyxy for one in found),
            image_width_px=size_px[0],
            image_height_px=size_px[1],
            stamp_s=stamp_s,
        )
        limit_s = self.settings.localize_timeout_s
        try:
            async with asyncio.timeout(limit_s):
                measurements = await self.camera.localize(request)
        except (UnavailableError, UpstreamError, TimeoutError) as error:
            text = f"no answer within {limit_s:g} s" if isinstance(error, TimeoutError) else error.said
            UNMEASURED.inc()
            measurements = (not_measured(NotMeasured.NOT_ANSWERED, text),) * len(found)
        return tuple(
            one.model_copy(update={"measurement": measurement})
            for one, measurement in zip(found, measurements, strict=True)
        )

    async def _announce(self, seen: Detections, target: Target) -> None:
        """At most every 0.5 s of frame time; a clock that went back counts as a new time."""
        best = best_target(seen.detections, target)
        last_s = self._last_spotted_s
        if best is None or (last_s is not None and 0 <= seen.stamp_s - last_s < self.settings.spotted_period_s):
            return
        self._last_spotted_s = seen.stamp_s
        spotted = ObjectSpotted(
            stamp_s=seen.stamp_s,
            target=target,
            detection=best,
            image_width_px=seen.image_width_px,
            image_height_px=seen.image_height_px,
            pose=seen.pose,
        )
        await self.bus.publish(VISION_OBJECT_SPOTTED, spotted)

    def _shrunk(self, image: RgbImage) -> RgbImage:
        """The image the detector gets."""
        if self.settings.frame_width_px == 0:
            return image
        return np.asarray(cv2.resize(image, self._small_px(image), interpolation=cv2.INTER_AREA), np.uint8)

    def _scale(self, image: RgbImage) -> tuple[float, float]:
        """The factors that bring pixels of the shrunk image back to the frame's."""
        width_px, height_px = self._small_px(image)
        return image.shape[1] / width_px, image.shape[0] / height_px

    def _small_px(self, image: RgbImage) -> tuple[int, int]:
        width_px = self.settings.frame_width_px or image.shape[1]
        height_px = self.settings.frame_height_px if self.settings.frame_width_px else image.shape[0]
        return width_px, height_px or max(1, round(image.shape[0] * width_px / image.shape[1]))

    def _period_s(self) -> float:
        return 1.0 / (self.settings.fast_rate_hz if self.wanted.fast else self.settings.rest_rate_hz)

    def _after_s(self) -> float | None:
        """The stamp after which a frame is due: a period after the last, so that it is looked at as it comes.

        In trouble any newer frame will do, and after some seconds any frame at all: the robot's clock may have started
        again.
        """
        waited_s = self.frame_age_s()
        if waited_s is not None and waited_s >= self.settings.clock_restarted_after_s:
            return None
        if self._last_stamp_s is None or self.trouble:
            return self._last_stamp_s
        return self._last_stamp_s + max(0.0, self._period_s() - STAMP_SLACK_S)

    async def _rest(self, began_s: float) -> None:
        """Until shortly before the next frame is due; in slices, so that an approach is seen faster at once."""
        since_s, early_s = (began_s, 0.0) if self._came_s is None else (self._came_s, EARLY_S)
        while True:
            left_s = since_s + self._period_s() - early_s - self.clock.now_s()
            if left_s <= 0.0:
                return
            await self.clock.sleep(min(left_s, SLICE_S))

    def _in_trouble(self, kind: str, detail: str) -> None:
        TROUBLES.labels(kind).inc()
        if detail != self.trouble:
            log.warning("perception waits", reason=detail)
        self.trouble = detail
