"""The loaded models behind one thread: look at an image, score crops against phrases."""

import asyncio
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import structlog
from prometheus_client import Counter, Histogram

from contracts.base import BboxXyxy
from contracts.colours import Colour
from contracts.vision import Detection, ModelInfo, ModelState, Target
from inference.colours import colour_prompts, pick_colour
from inference.perception.embeddings import NoEmbeddingError, cosines, embedded, unit
from inference.perception.images import decode
from inference.perception.worker import Worker
from inference.ports import Detector, Embeddings, FasterDetector, ImageText, RgbImage
from mesh.errors import UnavailableError

log = structlog.get_logger()

MODEL_SECONDS = Histogram(
    "inference_model_seconds",
    "time a model took for one call",
    ["role"],
    buckets=(0.005, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.5, 1.0, 5.0),
)
EMBEDDINGS_REFUSED = Counter("inference_embeddings_refused_total", "answers of the image-text model that are none")
TEXTS_KEPT = 4096


@dataclass(frozen=True)
class Loaded:
    detector: Detector | None = None
    clip: ImageText | None = None
    problems: tuple[str, ...] = ()
    """What could not be loaded, and why."""
    faster: FasterDetector | None = None
    """The same detector on a quicker backend, where that has to be prepared first."""


@dataclass(frozen=True, slots=True)
class Look:
    """What one image showed."""

    detections: tuple[Detection, ...]
    model: str
    took_ms: float
    """Of the detector alone."""


@dataclass(frozen=True, slots=True)
class Sight:
    image: RgbImage
    look: Look


Shrink = Callable[[RgbImage], RgbImage]


@dataclass(frozen=True, slots=True)
class Scores:
    """One cosine a text."""

    scores: tuple[float, ...]
    """Of the crop; of the whole image where no box was named."""
    frame_scores: tuple[float, ...]
    """Of the whole image where a box was named too, else empty."""
    took_ms: float


@dataclass
class Models:
    """Raises `UnavailableError` while the models load, and for one that could not be loaded."""

    load: Callable[[], Loaded]
    worker: Worker
    colour_crops_max: int = 12
    loaded: Loaded | None = None
    slower_because: str = ""
    clip_trouble: str = ""
    """What was wrong with the image-text model's numbers for the last picture; empty when nothing was."""
    """Why the detector is not on the backend that was wanted."""
    _opened: asyncio.Event = field(default_factory=asyncio.Event)
    _texts: dict[str, Embeddings] = field(default_factory=dict[str, Embeddings])

    async def open(self) -> None:
        self.loaded = await self.worker.run_in_turn(self.load)
        self._opened.set()

    async def quicken(self) -> None:
        """Once open: exports the detector where that was never done, and goes on with the export."""
        await self._opened.wait()
        loaded = self._ready()
        if loaded.faster is None:
            return
        log.info("the detector is being exported; it runs on torch until then")
        self.slower_because = await loaded.faster.prepare()
        if self.slower_because:
            log.warning("the detector stays as it is", reason=self.slower_because)
            return
        detector = await self.worker.run_in_turn(loaded.faster.load)
        self.loaded = replace(loaded, detector=detector, faster=None)
        log.info("the detector was exported", backend=detector.backend, backends_ms=dict(detector.backends_ms))

    @property
    def problem(self) -> str:
        """Empty when every model is loaded."""
        if self.loaded is None:
            return "loading"
        return "; ".join(self.loaded.problems)

    @property
    def trouble(self) -> str:
        """What was wrong with the models' answers to the last picture, told as a warning; empty when nothing was."""
        detector = self.loaded.detector if self.loaded is not None else None
        return "; ".join(one for one in (detector.trouble if detector is not None else "", self.clip_trouble) if one)

    def detector(self) -> Detector:
        loaded = self._ready()
        if loaded.detector is None:
            raise UnavailableError("detector", self.problem or "not configured")
        return loaded.detector

    def clip(self) -> ImageText:
        loaded = self._ready()
        if loaded.clip is None:
            raise UnavailableError("clip", self.problem or "not configured")
        return loaded.clip

    def clip_or_none(self) -> ImageText | None:
        return self.loaded.clip if self.loaded is not None else None

    async def see(
        self, encoded: bytes, target: Target | None = None, *, shrink: Shrink | None = None, own: bool = False
    ) -> Sight:
        """An encoded image and what it shows; colours are filled in where the image-text model is sure.

        The boxes are in pixels of what `shrink` makes of the image. `own` is for the service's own frames: they are
        never turned away. Raises as `images.decode`, and `TooManyError`.
        """
        run = self.worker.run_in_turn if own else self.worker.run
        return await run(self._see, self.detector(), encoded, target, shrink)

    async def score(self, image: RgbImage, bbox_xyxy: BboxXyxy | None, texts: Sequence[str]) -> Scores:
        """Each text against the crop and the whole image at once."""
        return await self.worker.run(self._score, self.clip(), image, bbox_xyxy, texts)

    async def embed(
        self, image: RgbImage | None, bbox_xyxy: BboxXyxy | None, texts: Sequence[str]
    ) -> tuple[list[float] | None, list[list[float]]]:
        """The crop's embedding (none without an image) and one for each text, as given: no template is put on."""
        return await self.worker.run(self._embed, self.clip(), image, bbox_xyxy, texts)

    def infos(self) -> list[ModelInfo]:
        loaded = self.loaded or Loaded()
        detector, clip = loaded.detector, loaded.clip
        return [
            ModelInfo(role="detector", name="", backend="", state=ModelState.NOT_LOADED, detail=self.problem)
            if detector is None
            else _info("detector", detector, self.slower_because),
            ModelInfo(role="clip", name="", backend="", state=ModelState.NOT_LOADED, detail=self.problem)
            if clip is None
            else _info("clip", clip),
        ]

    def _ready(self) -> Loaded:
        if self.loaded is None:
            raise UnavailableError("models", "still loading")
        return self.loaded

    def look_here(self, image: RgbImage) -> Look:
        """The models alone, in the thread that calls: only for the one that opened them."""
        return self._look(self.detector(), image, None)

    # What follows runs in the worker thread.

    def _see(self, detector: Detector, encoded: bytes, target: Target | None, shrink: Shrink | None) -> Sight:
        image = decode(encoded)
        return Sight(image, self._look(detector, image if shrink is None else shrink(image), target))

    def _look(self, detector: Detector, image: RgbImage, target: Target | None) -> Look:
        with MODEL_SECONDS.labels("detector").time():
            began_s = time.perf_counter()
            detections = detector.detect(image)
            took_ms = (time.perf_counter() - began_s) * 1000
        return Look(self._coloured(image, detections, target), detector.name, round(took_ms, 2))

    def _coloured(
        self, image: RgbImage, detections: tuple[Detection, ...], target: Target | None
    ) -> tuple[Detection, ...]:
        """Colour words for the most interesting boxes: the target's class first, then the surest."""
        clip = self.clip_or_none()
        if clip is None or not detections or self.colour_crops_max == 0:
            return detections
        label = target.label if target is not None else ""
        order = sorted(range(len(detections)), key=lambda i: (detections[i].label != label, -detections[i].confidence))
        chosen = order[: self.colour_crops_max]
        with MODEL_SECONDS.labels("clip").time():
            crops = [clip.crop(image, detections[i].bbox_xyxy) for i in chosen]
            words = self._colours(clip, crops, [detections[i].label for i in chosen])
        coloured = list(detections)
        for i, colour in zip(chosen, words, strict=True):
            coloured[i] = detections[i].model_copy(update={"colour": colour})
        return tuple(coloured)

    def _colours(self, clip: ImageText, crops: Sequence[RgbImage], labels: Sequence[str]) -> list[Colour | None]:
        """A colour word a crop. Numbers that are none cost a box its colour, and no more."""
        self.clip_trouble = ""
        try:
            seen = embedded(lambda: clip.embed_image(crops), len(crops))
        except NoEmbeddingError as error:
            self._in_clip_trouble(error)
            return [None] * len(crops)
        return [self._colour(clip, seen[row : row + 1], label) for row, label in enumerate(labels)]

    def _colour(self, clip: ImageText, seen: Embeddings, label: str) -> Colour | None:
        try:
            scores = cosines(seen, self._text(clip, colour_prompts(clip.template, label, clip.colours)))[0]
        except NoEmbeddingError as error:
            self._in_clip_trouble(error)
            return None
        return pick_colour(clip.colours, [float(score) for score in scores], clip.colour_margin)

    def _in_clip_trouble(self, error: NoEmbeddingError) -> None:
        EMBEDDINGS_REFUSED.inc()
        self.clip_trouble = error.detail

    def _score(self, clip: ImageText, image: RgbImage, bbox_xyxy: BboxXyxy | None, texts: Sequence[str]) -> Scores:
        began_s = time.perf_counter()
        views = [judged_crop(clip, image, bbox_xyxy), *([] if bbox_xyxy is None else [image])]
        with MODEL_SECONDS.labels("clip").time():
            seen = embedded(lambda: clip.embed_image(views), len(views))
            found = cosines(seen, self._text(clip, texts))
        took_ms = round((time.perf_counter() - began_s) * 1000, 2)
        rows = [tuple(float(cosine) for cosine in row) for row in found]
        return Scores(rows[0], () if bbox_xyxy is None else rows[1], took_ms)

    def _embed(
        self, clip: ImageText, image: RgbImage | None, bbox_xyxy: BboxXyxy | None, texts: Sequence[str]
    ) -> tuple[list[float] | None, list[list[float]]]:
        said: list[list[float]] = self._text(clip, texts).tolist() if texts else []
        if image is None:
            return None, said
        crops = [judged_crop(clip, image, bbox_xyxy)]
        return unit(embedded(lambda: clip.embed_image(crops), 1))[0].tolist(), said

    def _text(self, clip: ImageText, texts: Sequence[str]) -> Embeddings:
        missing = [text for text in dict.fromkeys(texts) if text not in self._texts]
        if missing:
            if len(self._texts) + len(missing) > TEXTS_KEPT:
                self._texts.clear()
                missing = list(dict.fromkeys(texts))
            self._texts.update(
                zip(missing, unit(embedded(lambda: clip.embed_text(missing), len(missing))), strict=True)
            )
        return np.stack([self._texts[text] for text in texts])


def _info(role: str, model: Detector | ImageText, detail: str = "") -> ModelInfo:
    return ModelInfo(
        role=role,
        name=model.name,
        backend=model.backend,
        backends_ms=dict(model.backends_ms),
        threshold=model.threshold,
        detail=detail,
    )


def judged_crop(clip: ImageText, image: RgbImage, bbox_xyxy: BboxXyxy | None) -> RgbImage:
    """What the model is shown of it: the whole image where no box was named."""
    return image if bbox_xyxy is None else clip.crop(image, bbox_xyxy)
