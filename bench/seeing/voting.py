"""Questions about labelled pictures, put to the service's own `Validator`, and what its answers are worth."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import cv2
import numpy as np

from contracts.measuring import LocalizeRequest, Measurement, NotMeasured, not_measured
from contracts.vision import Detection, Target, ValidateRequest, Verdict
from geometry.boxes import iou
from inference.perception.models import Loaded, Models
from inference.perception.worker import Worker
from inference.ports import Detector, RgbImage
from inference.ports import Frame as CameraFrame
from inference.validation.validation import Validator
from sim.home.catalog import THINGS
from sim.training.records import Box, Frame

HIT_IOU = 0.5
SAME_IOU = 0.3
"""A confirmed box this much over a labelled one means that thing."""


@dataclass(frozen=True)
class Question:
    """Is the thing at this box a `colour` `label`?"""

    box: Box
    label: str
    colour: str

    @property
    def description(self) -> str:
        return f"{self.colour} {self.label}"

    @property
    def right(self) -> bool:
        return (self.label, self.colour) == (self.box.kind, self.box.colour)

    @property
    def kind_of(self) -> str:
        if self.right:
            return "right"
        return "other colour" if self.label == self.box.kind else "other kind"


@dataclass(frozen=True)
class Answer:
    spotted: bool
    """The detector saw the thing as the kind it is."""
    confirmed_right: bool
    confirmed_wrong: bool
    detector: Verdict
    clip_score: float | None
    clip_lead: float | None
    """Over the same description in the next best colour."""
    clip_ms: float
    reason: str


def questions(frame: Frame, range_m: float, rng: np.random.Generator) -> Iterator[Question]:
    """Of each coloured, findable thing in range: what it is, every other colour, and one other kind in its colour."""
    kinds = sorted(kind for kind, one in THINGS.items() if one.findable and one.colours)
    for box in frame.boxes:
        if box.kind not in kinds or not box.colour or box.distance_m > range_m:
            continue
        for colour in dict.fromkeys(THINGS[box.kind].colours):
            yield Question(box, box.kind, colour)
        others = [kind for kind in kinds if kind != box.kind and box.colour in THINGS[kind].colours]
        if others:  # nothing but a teddy bear is brown
            yield Question(box, others[int(rng.integers(len(others)))], box.colour)


class Asker:
    """The service's models and votes, without its HTTP face; each picture is looked at once."""

    def __init__(self, loaded: Loaded) -> None:
        assert loaded.detector is not None
        self._detector = Remembering(loaded.detector)
        self._worker = Worker(waiting_max=4)
        self._models = Models(
            load=lambda: Loaded(detector=self._detector, clip=loaded.clip), worker=self._worker, colour_crops_max=0
        )
        self._camera = OneFrame()
        self._validator = Validator(self._camera, self._models, None, frame_wait_s=1.0, vlm_deadline_s=1.0)

    async def __aenter__(self) -> Self:
        await self._models.open()
        return self

    async def __aexit__(self, *_: object) -> None:
        self._worker.close()

    async def ask(self, picture: Path, frame: Frame, question: Question) -> Answer:
        self._camera.show(picture)
        target = Target(label=question.label, description=question.description)
        x_min, y_min, x_max, y_max = map(float, question.box.bbox_xyxy)
        told = await self._validator.validate(ValidateRequest(target=target, bbox_xyxy=(x_min, y_min, x_max, y_max)))
        meant = [box for box in frame.boxes if (box.kind, box.colour) == (question.label, question.colour)]
        is_one = told.bbox_xyxy is not None and any(
            iou(told.bbox_xyxy, tuple(map(float, box.bbox_xyxy))) >= SAME_IOU for box in meant
        )
        detector, clip = told.votes[0], told.votes[1]
        return Answer(
            spotted=hit(self._detector.found, question.box) is not None,
            confirmed_right=told.confirmed and is_one,
            confirmed_wrong=told.confirmed and not is_one,
            detector=detector.verdict,
            clip_score=clip.score,
            clip_lead=None if clip.score is None or clip.rival_score is None else clip.score - clip.rival_score,
            clip_ms=clip.took_ms,
            reason=f"{detector.reason}; {clip.reason}",
        )


def hit(found: Sequence[Detection], box: Box) -> Detection | None:
    """The detection that is this thing."""
    bbox = tuple(float(side) for side in box.bbox_xyxy)
    same = [one for one in found if one.label == box.kind and iou(one.bbox_xyxy, bbox) >= HIT_IOU]
    return max(same, key=lambda one: one.confidence, default=None)


def load_rgb(path: Path) -> RgbImage:
    image = cv2.imread(str(path))
    assert image is not None, f"{path} is no picture"
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), np.uint8)


class Remembering:
    """A detector that looks at the same picture once."""

    def __init__(self, detector: Detector) -> None:
        self._detector = detector
        self.name, self.backend, self.threshold = detector.name, detector.backend, detector.threshold
        self.backends_ms = detector.backends_ms
        self.found: tuple[Detection, ...] = ()
        self._seen: bytes = b""

    @property
    def trouble(self) -> str:
        return self._detector.trouble

    def detect(self, image: RgbImage) -> tuple[Detection, ...]:
        pixels = image.tobytes()
        if pixels != self._seen:
            self._seen, self.found = pixels, self._detector.detect(image)
        return self.found


class OneFrame:
    """A camera that shows one file."""

    def __init__(self) -> None:
        self._path = Path()
        self._jpeg = b""

    def show(self, path: Path) -> None:
        if path != self._path:
            self._path, self._jpeg = path, path.read_bytes()

    async def newest(self, *, after_s: float | None, wait_s: float) -> CameraFrame | None:
        return CameraFrame(1.0, self._jpeg)

    async def localize(self, request: LocalizeRequest) -> tuple[Measurement, ...]:
        return tuple(not_measured(NotMeasured.NOT_ANSWERED, "pictures have no depth") for _ in request.boxes_xyxy)

    async def aclose(self) -> None:
        return
