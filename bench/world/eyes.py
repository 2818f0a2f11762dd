"""What goes wrong with the eyes, drawn from a seed: inference's models at their lowest port, with errors put on top."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bench.world.faults import Errors
from contracts.colours import Colour
from contracts.vision import Detection
from inference.colours import phrase
from inference.perception.models import Loaded
from inference.ports import Detector, Embeddings, ImageText, RgbImage

SMALLEST_PX, LARGEST_PX = 14.0, 60.0
"""Sides of a box on nothing."""
CONFIDENCE: Final = (0.32, 0.8)
"""Of a box on nothing."""


def erring(models: Loaded, errors: Errors, kind: str, colour: str | None, seed: int) -> Loaded:
    """The same models, erring in a mission that asks for that kind and colour; what errs in nothing stays as it is."""
    detector, clip = models.detector, models.clip
    if detector is not None and (errors.false_boxes or errors.missed or errors.liar == "detector"):
        detector = ErringDetector(detector, errors, kind, np.random.default_rng([seed, 430]))
    if clip is not None and colour is not None and (errors.wrong_colour or errors.liar == "clip"):
        clip = ErringImageText(clip, errors, f"{colour} {kind}", np.random.default_rng([seed, 431]))
    return replace(models, detector=detector, clip=clip, faster=None)


class ErringDetector:
    """Implements `inference.ports.Detector`: misses boxes, sees some on nothing; a liar takes all for what is asked."""

    def __init__(self, real: Detector, errors: Errors, kind: str, rng: np.random.Generator) -> None:
        self._real, self._errors, self._kind, self._rng = real, errors, kind, rng

    @property
    def name(self) -> str:
        return self._real.name

    @property
    def backend(self) -> str:
        return self._real.backend

    @property
    def backends_ms(self) -> Mapping[str, float]:
        return self._real.backends_ms

    @property
    def threshold(self) -> float:
        return self._real.threshold

    @property
    def trouble(self) -> str:
        return self._real.trouble

    def detect(self, image: RgbImage) -> tuple[Detection, ...]:
        errors, rng = self._errors, self._rng
        seen = [one for one in self._real.detect(image) if not rng.random() < errors.missed]
        if errors.liar == "detector":
            seen = [one.model_copy(update={"label": self._kind}) for one in seen]
        if rng.random() < errors.false_boxes:
            seen.append(self._on_nothing(image))
        return tuple(sorted(seen, key=lambda one: -one.confidence))

    def _on_nothing(self, image: RgbImage) -> Detection:
        rng, (height_px, width_px) = self._rng, image.shape[:2]
        width, height = rng.uniform(SMALLEST_PX, LARGEST_PX, 2).tolist()
        x, y = rng.uniform(0.0, width_px - width), rng.uniform(0.2 * height_px, height_px - height)
        sure = float(rng.uniform(*CONFIDENCE))
        return Detection(label=self._kind, confidence=sure, bbox_xyxy=(x, y, x + width, y + height))


class ErringImageText:
    """Implements `inference.ports.ImageText`: takes some crops for `wanted` in another colour; a liar all for `wanted`.

    A crop that is taken for something gets the embedding of the words for it.
    """

    def __init__(self, real: ImageText, errors: Errors, wanted: str, rng: np.random.Generator) -> None:
        self._real, self._errors, self._wanted, self._rng = real, errors, wanted, rng

    @property
    def name(self) -> str:
        return self._real.name

    @property
    def backend(self) -> str:
        return self._real.backend

    @property
    def backends_ms(self) -> Mapping[str, float]:
        return self._real.backends_ms

    @property
    def threshold(self) -> float:
        return self._real.threshold

    @property
    def colour_margin(self) -> float:
        return self._real.colour_margin

    @property
    def vote_margin(self) -> float:
        return self._real.vote_margin

    @property
    def colours(self) -> tuple[Colour, ...]:
        return self._real.colours

    @property
    def template(self) -> str:
        return self._real.template

    def known(self, text: str) -> tuple[str, tuple[str, ...]]:
        return self._real.known(text)

    def crop(self, image: RgbImage, bbox_xyxy: Sequence[float]) -> RgbImage:
        return self._real.crop(image, bbox_xyxy)

    def embed_text(self, texts: Sequence[str]) -> Embeddings:
        return self._real.embed_text(texts)

    def embed_image(self, crops: Sequence[RgbImage]) -> Embeddings:
        taken_for = [self._taken_for() for _ in crops]
        rows = self._real.embed_image(crops)
        said = [k for k, words in enumerate(taken_for) if words]
        if said:
            rows = np.array(rows)
            rows[said] = self.embed_text([phrase(self.template, taken_for[k]) for k in said])
        return rows

    def _taken_for(self) -> str:
        """Empty where the crop is seen as it is."""
        if self._errors.liar == "clip":
            return self._wanted
        if not self._rng.random() < self._errors.wrong_colour:
            return ""
        colour, kind = self._wanted.split(" ", 1)
        others = [one for one in self.colours if one != colour]
        return f"{others[int(self._rng.integers(len(others)))]} {kind}"
