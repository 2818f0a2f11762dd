"""The real detector and image-text model behind their ports; one suite over them and the fakes the other tests use."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from contracts.coco import COCO_LABELS
from inference.adapters.image_text import OpenClipModel, Overrides, SmallClipModel
from inference.adapters.loading import loader
from inference.adapters.yolo import YoloDetector
from inference.ports import Detector, ImageText
from inference.settings import Settings
from support.inference_fakes import FakeClip, FakeDetector, bottle, picture

SCENE = picture(("red", (80, 60, 130, 200)), ("blue", (150, 60, 190, 200)))


@pytest.fixture(params=["real", "fake"])
def detector(request: pytest.FixtureRequest, untrained_detector: Path) -> Detector:
    made: dict[str, Callable[[], Detector]] = {
        "real": lambda: YoloDetector(untrained_detector, threshold=1e-5, imgsz=320, boxes_max=20),
        "fake": lambda: FakeDetector((bottle(),)),
    }
    return made[request.param]()


@pytest.fixture(params=["real", "fake"])
def clip(request: pytest.FixtureRequest, untrained_clip: Path) -> ImageText:
    made: dict[str, Callable[[], ImageText]] = {"real": lambda: SmallClipModel(untrained_clip), "fake": FakeClip}
    return made[request.param]()


def test_a_detector_returns_boxes_inside_the_picture_best_first(detector: Detector) -> None:
    found = detector.detect(SCENE)
    assert 1 <= len(found) <= 20
    assert {one.label for one in found} <= set(COCO_LABELS)
    assert [one.confidence for one in found] == sorted((one.confidence for one in found), reverse=True)
    boxes = np.array([one.bbox_xyxy for one in found])
    assert (boxes >= 0).all()
    assert (boxes <= 250).all()
    assert (boxes[:, 2:] >= boxes[:, :2]).all()


def test_a_detector_says_what_it_is(detector: Detector) -> None:
    assert detector.name
    assert detector.backend in {"torch", "fake"}
    assert 0.0 < detector.threshold < 1.0


def test_a_picture_of_any_shape_is_looked_at(detector: Detector) -> None:
    for height_px, width_px in ((1, 1), (240, 320), (31, 700)):
        detector.detect(np.zeros((height_px, width_px, 3), np.uint8))


def test_embeddings_are_unit_vectors_of_one_size(clip: ImageText) -> None:
    crops = [clip.crop(SCENE, box) for box in ((80, 60, 130, 200), (-20, -20, 5, 5), (240, 240, 400, 400))]
    assert all(one.size > 0 for one in crops)
    seen, said = clip.embed_image(crops), clip.embed_text(["red bottle", "blue bottle"])
    assert (seen.shape[0], said.shape[0], seen.shape[1]) == (3, 2, said.shape[1])
    assert np.linalg.norm(seen, axis=1) == pytest.approx(1.0, abs=1e-3)
    assert np.linalg.norm(said, axis=1) == pytest.approx(1.0, abs=1e-3)


def test_words_a_model_does_not_know_are_told(clip: ImageText) -> None:
    assert clip.known("shiny red bottle") == ("red bottle", ("shiny",))


def test_the_threshold_is_the_models_own_unless_a_setting_says_otherwise(untrained_clip: Path) -> None:
    own, told = SmallClipModel(untrained_clip), SmallClipModel(untrained_clip, overrides=Overrides(0.6, 0.1, 0.02))
    assert (own.threshold, own.colour_margin, own.vote_margin) == (0.45, 0.08, 0.0)
    assert (told.threshold, told.colour_margin, told.vote_margin) == (0.6, 0.1, 0.02)


@pytest.mark.parametrize("made", [SmallClipModel, OpenClipModel])
def test_missing_weights_are_named(made: Callable[[Path], ImageText], tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="absent"):
        made(tmp_path / "absent.safetensors")


@pytest.mark.parametrize("clip_file", ["absent.safetensors", "damaged.safetensors"])
def test_the_loader_names_every_model_it_could_not_load(tmp_path: Path, untrained_clip: Path, clip_file: str) -> None:
    for name in ("damaged.pt", "damaged.safetensors"):
        (tmp_path / name).write_bytes(b"not weights")
    (tmp_path / "damaged.json").write_bytes(untrained_clip.with_suffix(".json").read_bytes())
    loaded = loader(Settings(detector_path=tmp_path / "damaged.pt", clip_path=tmp_path / clip_file))()
    assert (loaded.detector, loaded.clip) == (None, None)
    assert [problem.split(":")[0] for problem in loaded.problems] == ["detector", "clip"]


def test_a_detector_of_other_classes_is_refused(untrained_detector: Path, tmp_path: Path) -> None:
    from ultralytics import YOLO

    strange = YOLO(str(untrained_detector))
    strange.model.names = dict.fromkeys(range(80), "gizmo")
    strange.save(str(tmp_path / "strange.pt"))
    with pytest.raises(ValueError, match="gizmo"):
        YoloDetector(tmp_path / "strange.pt", threshold=0.3, imgsz=320)
