"""What is put on top of inference's models errs as it was asked to, and as often."""

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import pytest

from bench.world.eyes import ErringDetector, ErringImageText, erring
from bench.world.faults import Errors
from contracts.colours import Colour
from contracts.vision import Detection
from inference.colours import phrase
from inference.perception.models import Loaded
from inference.ports import Embeddings, RgbImage

PICTURE = np.zeros((240, 320, 3), np.uint8)
CUP = Detection(label="cup", confidence=0.9, bbox_xyxy=(10.0, 10.0, 40.0, 60.0))
LOOKS = 400


class OneCup:
    """Sees the same cup in every picture."""

    name, backend, threshold, trouble = "one cup", "none", 0.3, ""
    backends_ms: ClassVar[dict[str, float]] = {}

    def detect(self, image: RgbImage) -> tuple[Detection, ...]:
        return (CUP,)


class ByLength:
    """A text's embedding is its length; a picture has none."""

    name, backend, threshold, template = "by length", "none", 0.3, "a photo of {}"
    backends_ms: ClassVar[dict[str, float]] = {}
    colour_margin = vote_margin = 0.1
    colours = (Colour.RED, Colour.GREEN, Colour.ORANGE)

    def known(self, text: str) -> tuple[str, tuple[str, ...]]:
        return text, ()

    def crop(self, image: RgbImage, bbox_xyxy: Sequence[float]) -> RgbImage:
        return image

    def embed_image(self, crops: Sequence[RgbImage]) -> Embeddings:
        return np.zeros((len(crops), 1), np.float32)

    def embed_text(self, texts: Sequence[str]) -> Embeddings:
        return np.array([[len(text)] for text in texts], np.float32)


def seen(**errors: object) -> list[Detection]:
    eyes = ErringDetector(OneCup(), Errors(**errors), "vase", np.random.default_rng(1))  # type: ignore[arg-type]
    return [one for _ in range(LOOKS) for one in eyes.detect(PICTURE)]


def taken_for(**errors: object) -> set[float]:
    eyes = ErringImageText(ByLength(), Errors(**errors), "red vase", np.random.default_rng(1))  # type: ignore[arg-type]
    return {float(row[0]) for _ in range(LOOKS) for row in eyes.embed_image([PICTURE])}


def length_of(words: str) -> float:
    return float(len(phrase(ByLength.template, words)))


@pytest.mark.parametrize("share", [0.2, 0.6])
def test_a_share_of_the_boxes_is_missed(share: float) -> None:
    assert len(seen(missed=share)) == pytest.approx((1.0 - share) * LOOKS, rel=0.15)


def test_boxes_of_what_is_asked_for_are_seen_on_nothing_inside_the_picture() -> None:
    on_nothing = [one for one in seen(false_boxes=0.25) if one.label == "vase"]
    assert len(on_nothing) == pytest.approx(0.25 * LOOKS, rel=0.25)
    assert all(0 <= x0 < x1 <= 320 and 0 <= y0 < y1 <= 240 for x0, y0, x1, y1 in (one.bbox_xyxy for one in on_nothing))


def test_a_lying_detector_takes_all_it_sees_for_what_is_asked_for() -> None:
    assert {one.label for one in seen(liar="detector")} == {"vase"}


def test_a_lying_clip_takes_every_crop_for_what_is_asked_for() -> None:
    assert taken_for(liar="clip") == {length_of("red vase")}


def test_a_wrong_colour_is_one_that_was_not_asked_for() -> None:
    assert taken_for(wrong_colour=0.4) == {0.0, length_of("green vase"), length_of("orange vase")}


def test_models_that_err_in_nothing_stay_as_they_are_and_the_same_seed_errs_alike() -> None:
    models = Loaded(detector=OneCup(), clip=ByLength())
    assert erring(models, Errors(), "vase", "red", 1) == models
    first, second, other = (erring(models, Errors(missed=0.5), "vase", "red", seed).detector for seed in (1, 1, 2))
    assert first is not None
    assert second is not None
    assert other is not None
    looks = [[bool(one.detect(PICTURE)) for _ in range(40)] for one in (first, second, other)]
    assert looks[0] == looks[1] != looks[2]
