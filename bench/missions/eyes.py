"""inference and memory, simulated: pictures from ground truth, votes with errors, and remembered views."""

import asyncio
from collections.abc import Sequence

import numpy as np

from bench.missions.bridge import Frame, SimulatedBridge, shown_in
from bench.missions.bus import SimulatedBus
from bench.missions.place import InPicture
from bench.missions.seeing import SIZE_PX, detect, false_box, votes
from bench.missions.wire import Wire
from bench.world.faults import Faults
from contracts.geometry import Pose2D
from contracts.language import ReasonReply, ReasonRequest
from contracts.measuring import Measurement
from contracts.memory import LabelCount, LookBatch, RecalledView, RecallReply, RecallRequest, RememberedObject, View
from contracts.problem import Dependency
from contracts.rooms import RoomGrid, RoomsReply
from contracts.topics import MISSION_TARGET, VISION_DETECTIONS
from contracts.vision import (
    Detection,
    Detections,
    ParsedTarget,
    ParsedTask,
    ParseTaskRequest,
    ValidateRequest,
    Validation,
    Verdict,
)
from mesh.errors import UnavailableError, UpstreamError

PERIOD_S, FAST_PERIOD_S = 0.5, 0.2
LATENCY_S = 0.15
VOTE_S, VLM_S = 0.4, (3.0, 15.0)


class SimulatedEyes:
    """The port `Eyes`. The parse is given, not read from the command: language is not what is tried here."""

    def __init__(
        self, bridge: SimulatedBridge, bus: SimulatedBus, faults: Faults, task: ParsedTarget, seed: int
    ) -> None:
        self.rng = np.random.default_rng([seed, 41])
        self.wire = Wire("inference", faults, np.random.default_rng([seed, 42]))
        self.validations = 0
        self._bridge = bridge
        self._bus = bus
        self._errors = faults.errors
        self._task = task

    async def run(self) -> None:
        """Takes pictures and publishes what is in them: 2 Hz, 5 Hz while the mission asks for it."""
        while True:
            target = await self._bus.last(MISSION_TARGET)
            fast = target is not None and target.fast
            await asyncio.sleep(FAST_PERIOD_S if fast else PERIOD_S)
            if not self.wire.down and not self._bridge.wire.down:
                frame = self._take()
                asyncio.get_running_loop().call_later(LATENCY_S, self._publish_later, frame)

    def _take(self) -> Frame:
        bridge, rng = self._bridge, self.rng
        shown = bridge.place.in_picture(bridge.wheels.pose)
        boxes: list[tuple[Detection, InPicture | None]] = [
            (found, one) for one in shown if (found := detect(one, rng, self._errors)) is not None
        ]
        if rng.random() < self._errors.false_boxes:
            boxes.append((false_box(self._task.yolo_class, rng), None))
        now_s = asyncio.get_running_loop().time()
        frame = Frame(now_s, bridge.wheels.pose, bridge.wheels.believed(), tuple(boxes))
        bridge.frames.append(frame)
        return frame

    def _publish_later(self, frame: Frame) -> None:
        boxes = [found.bbox_xyxy for found, _ in frame.boxes]
        measured = self._bridge.localize(frame, boxes) if boxes else ()
        told = detections_of(frame, measured)
        self._publishing = asyncio.ensure_future(self._bus.publish(VISION_DETECTIONS, told))

    async def parse_task(self, request: ParseTaskRequest) -> ParsedTask:
        async def work() -> ParsedTask:
            return ParsedTask(targets=(self._task.model_copy(update={"said": request.command}),))

        return await self.wire.call(work, timeout_s=20.0)

    async def validate(self, request: ValidateRequest, *, timeout_s: float) -> Validation:
        async def work() -> Validation:
            self.validations += 1
            await asyncio.sleep(VOTE_S + (float(self.rng.uniform(*VLM_S)) if self._errors.vlm else 0.0))
            frame = self._bridge.frames[-1]
            assert request.bbox_xyxy is not None
            box = request.bbox_xyxy
            seen = shown_in(frame, box)
            boxed = any(True for _ in frame.boxes)
            cast = votes(seen, boxed, request.target, self.rng, self._errors)
            yes = sum(vote.verdict is Verdict.YES for vote in cast)
            return Validation(
                confirmed=yes >= 2, votes=cast, stamp_s=frame.stamp_s, image_width_px=SIZE_PX, image_height_px=SIZE_PX,
                bbox_xyxy=box,
            )  # fmt: skip

        return await self.wire.call(work, timeout_s=timeout_s)

    async def evidence(self, validation_id: str) -> bytes:
        """There are no pictures here, only what is in them."""
        raise UnavailableError("inference", "no camera")

    async def reason(self, request: ReasonRequest) -> ReasonReply:
        raise UnavailableError("inference", "no language model")

    async def dependency(self) -> Dependency:
        return Dependency.of("inference", ok=not self.wire.down)


def detections_of(frame: Frame, measured: Sequence[Measurement]) -> Detections:
    """As inference publishes them: each box with its measurement."""
    boxes = (found for found, _ in frame.boxes)
    return Detections(
        stamp_s=frame.stamp_s,
        image_width_px=SIZE_PX,
        image_height_px=SIZE_PX,
        pose=frame.believed,
        detections=tuple(
            found.model_copy(update={"measurement": one}) for found, one in zip(boxes, measured, strict=True)
        ),
        model="ground truth with errors",
    )


class SimulatedMemory:
    """The port `Memory` over robot poses from which the thing was once seen."""

    def __init__(self, views: Sequence[Pose2D], label: str, faults: Faults, seed: int) -> None:
        self.wire = Wire("memory", faults, np.random.default_rng([seed, 51]))
        self._views = tuple(views)
        self._label = label

    async def labels(self) -> Sequence[LabelCount]:
        async def work() -> Sequence[LabelCount]:
            if not self._views:
                return []
            return [LabelCount(label=self._label, views=len(self._views), best_confidence=0.9, last_seen_s=1.0)]

        return await self.wire.call(work, timeout_s=3.0)

    async def recall(self, request: RecallRequest) -> RecallReply:
        async def work() -> RecallReply:
            views = tuple(
                View(id=k, label=self._label, confidence=0.9 - 0.05 * k, pose=pose, stamp_s=1.0)
                for k, pose in enumerate(self._views[: request.limit])
            )
            return RecallReply(views=tuple(RecalledView(view=view, source="label") for view in views))

        return await self.wire.call(work, timeout_s=3.0)

    async def looks(self, batch: LookBatch) -> None:
        async def work() -> None:
            pass

        await self.wire.call(work, timeout_s=3.0)

    async def views(self, label: str, limit: int) -> Sequence[View]:
        return ()

    async def objects(self, label: str | None, limit: int, room_id: int | None = None) -> Sequence[RememberedObject]:
        return ()

    async def rooms(self) -> RoomsReply:
        return RoomsReply()

    async def room_grid(self) -> RoomGrid:
        raise UpstreamError("memory", 404, "there is no map now that is cut into rooms")

    async def dependency(self) -> Dependency:
        return Dependency.of("memory", ok=not self.wire.down)
