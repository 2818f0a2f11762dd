"""The loaded models behind one thread: look at an image, score crops against phrases."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from prometheus_client import Histogram

from contracts.base import BboxXyxy
from contracts.vision import Detection, ModelInfo, Target
from inference.colours import colour_prompts, pick_colour
from inference.ports import Detector, Embeddings, ImageText, RgbImage
from inference.worker import Worker
from mesh.errors import UnavailableError

MODEL_SECONDS = Histogram(
    "inference_model_seconds",
    "time a model took for one call",
    ["role"],
    buckets=(0.005, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.5, 1.0, 5.0),
)
TEXTS_KEPT = 4096


@dataclass(frozen=True)
class Loaded:
    detector: Detector | None = None
    clip: ImageText | None = None
    problems: tuple[str, ...] = ()
    """What could not be loaded, and why."""


@dataclass(frozen=True, slots=True)
class Look:
    """What one image showed."""

    detections: tuple[Detection, ...]
    model: str
    took_ms: float
    """Of the detector alone."""


@dataclass
class Models:
    """Raises `UnavailableError` while the models load, and for one that could not be loaded."""

    load: Callable[[], Loaded]
    worker: Worker
    colour_crops_max: int = 12
    loaded: Loaded | None = None
    _texts: dict[str, Embeddings] = field(default_factory=dict[str, Embeddings])

    async def open(self) -> None:
        self.loaded = await self.worker.run(self.load)

    @property
    def problem(self) -> str:
        """Empty when every model is loaded."""
        if self.loaded is None:
            return "loading"
        return "; ".join(self.loaded.problems)

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

    async def look(self, image: RgbImage, target: Target | None = None) -> Look:
        """Detections in pixels of `image`, their colours filled in where the image-text model is sure."""
        return await self.worker.run(self._look, self.detector(), image, target)

    async def score(
        self, image: RgbImage, bbox_xyxy: BboxXyxy | None, texts: Sequence[str]
    ) -> tuple[list[float], float]:
        """Cosine of the crop (or the whole image) with each text, and the milliseconds it took."""
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
            ModelInfo(role="detector", name="", backend="", available=False, detail=self.problem)
            if detector is None
            else ModelInfo(role="detector", name=detector.name, backend=detector.backend, threshold=detector.threshold),
            ModelInfo(role="clip", name="", backend="", available=False, detail=self.problem)
            if clip is None
            else ModelInfo(role="clip", name=clip.name, backend=clip.backend, threshold=clip.threshold),
        ]

    def _ready(self) -> Loaded:
        if self.loaded is None:
            raise UnavailableError("models", "still loading")
        return self.loaded

    # What follows runs in the worker thread.

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
            seen = clip.embed_image([clip.crop(image, detections[i].bbox_xyxy) for i in chosen])
            coloured = list(detections)
            for row, i in enumerate(chosen):
                scores = self._text(clip, colour_prompts(clip.template, detections[i].label, clip.colours)) @ seen[row]
                colour = pick_colour(clip.colours, [float(score) for score in scores], clip.colour_margin)
                coloured[i] = detections[i].model_copy(update={"colour": colour})
        return tuple(coloured)

    def _score(
        self, clip: ImageText, image: RgbImage, bbox_xyxy: BboxXyxy | None, texts: Sequence[str]
    ) -> tuple[list[float], float]:
        began_s = time.perf_counter()
        with MODEL_SECONDS.labels("clip").time():
            cosines = self._text(clip, texts) @ clip.embed_image([_cut(clip, image, bbox_xyxy)])[0]
        return [float(cosine) for cosine in cosines], round((time.perf_counter() - began_s) * 1000, 2)

    def _embed(
        self, clip: ImageText, image: RgbImage | None, bbox_xyxy: BboxXyxy | None, texts: Sequence[str]
    ) -> tuple[list[float] | None, list[list[float]]]:
        seen = clip.embed_image([_cut(clip, image, bbox_xyxy)])[0].tolist() if image is not None else None
        return seen, self._text(clip, texts).tolist() if texts else []

    def _text(self, clip: ImageText, texts: Sequence[str]) -> Embeddings:
        missing = [text for text in dict.fromkeys(texts) if text not in self._texts]
        if missing:
            if len(self._texts) + len(missing) > TEXTS_KEPT:
                self._texts.clear()
                missing = list(dict.fromkeys(texts))
            self._texts.update(zip(missing, clip.embed_text(missing), strict=True))
        return np.stack([self._texts[text] for text in texts])


def _cut(clip: ImageText, image: RgbImage, bbox_xyxy: BboxXyxy | None) -> RgbImage:
    return image if bbox_xyxy is None else clip.crop(image, bbox_xyxy)
