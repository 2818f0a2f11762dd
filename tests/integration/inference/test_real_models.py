"""The real detector and image-text model behind their ports; one suite over them and the fakes the other tests use."""

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from contracts.coco import COCO_LABELS
from inference.adapters.image_text import OpenClipModel, Overrides, SmallClipModel, read_clip_card
from inference.adapters.loading import loader
from inference.adapters.yolo import YoloDetector, read_card
from inference.ports import Detector, ImageText
from inference.settings import Settings
from mesh.errors import UnavailableError
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


def test_the_detectors_own_steps_give_what_ultralytics_predict_gives(untrained_detector: Path) -> None:
    from ultralytics import YOLO

    ours = YoloDetector(untrained_detector, threshold=1e-5, imgsz=320, boxes_max=20)
    theirs: Any = YOLO(str(untrained_detector), task="detect")
    options = {"imgsz": 320, "conf": 1e-5, "max_det": 20, "device": "cpu", "verbose": False}
    boxes = theirs.predict(SCENE[:, :, ::-1].copy(), **options)[0].boxes
    found = ours.detect(SCENE)
    assert [one.confidence for one in found] == pytest.approx(sorted(boxes.conf.tolist(), reverse=True), abs=1e-6)
    by_confidence = boxes.xyxy[boxes.conf.argsort(descending=True, stable=True)]
    assert np.array([one.bbox_xyxy for one in found]) == pytest.approx(by_confidence.numpy(), abs=0.011)


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


class Played:
    """An answer of ultralytics: what `result.boxes` holds, where there are any."""

    def __init__(self, cls: Any = (), conf: Any = (), xyxy: Any = ()) -> None:
        self.cls, self.conf, self.xyxy = (np.asarray(one, np.float32) for one in (cls, conf, xyxy))
        self.boxes = self

    def cpu(self) -> "Played":
        return self

    def numpy(self) -> "Played":
        return self


class Fails:
    @property
    def boxes(self) -> None:
        raise RuntimeError("out of memory")


@pytest.fixture
def played(untrained_detector: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[object], Detector]:
    """The real adapter over a model that answers what it is given."""
    detector = YoloDetector(untrained_detector, threshold=0.3, imgsz=320)

    def answers(result: object) -> Detector:
        monkeypatch.setattr(detector._model.predictor, "postprocess", lambda *_: [result])
        return detector

    return answers


def test_a_row_that_is_no_box_costs_itself_and_is_told(played: Callable[[object], Detector]) -> None:
    good = (80.0, 60.0, 130.0, 200.0)
    rows = [(39, 0.9, good), (39, 0.8, (np.nan,) * 4), (39, 37.0, good), (99, 0.9, good), (39, 0.7, good[::-1])]
    detector = played(Played(*zip(*rows, strict=True)))
    assert [(one.label, one.bbox_xyxy) for one in detector.detect(SCENE)] == [("bottle", good)]
    assert detector.trouble == (
        "of its boxes some were none: 1 not finite, 1 confidence out of range, 1 unknown class, 1 empty or inverted"
    )
    assert len(played(Played([39], [0.9], [good])).detect(SCENE)) == 1
    assert detector.trouble == ""


@pytest.mark.parametrize(
    ("result", "why"),
    [
        (Played([39], [0.9, 0.8], [(1, 2, 3, 4)]), "shapes"),
        (Played([39], [0.9], [(1, 2, 3)]), "shapes"),
        (Played([39, 39], [np.nan, np.nan], [(80, 60, 130, 200)] * 2), "its numbers are not finite"),
        (SimpleNamespace(boxes=None), "NoneType"),
        (Fails(), "out of memory"),
    ],
)
def test_an_answer_without_the_shape_of_boxes_is_no_answer(
    played: Callable[[object], Detector], result: object, why: str
) -> None:
    detector = played(result)
    with pytest.raises(UnavailableError, match=why):
        detector.detect(SCENE)
    assert "could not look at a picture" in detector.trouble


NAMES = {
    "older": ({"couch": "sofa", "tv": "tvmonitor", "potted plant": "pottedplant", "airplane": "aeroplane"}, str),
    "capitals": ({}, str.title),
}


@pytest.mark.parametrize("tag", NAMES)
def test_weights_with_other_names_of_the_classes_are_read(untrained_detector: Path, tmp_path: Path, tag: str) -> None:
    from ultralytics import YOLO

    older, cased = NAMES[tag]
    model = YOLO(str(untrained_detector))
    model.model.names = {number: cased(older.get(label, label)) for number, label in enumerate(COCO_LABELS)}
    model.save(str(tmp_path / "renamed.pt"))
    detector = YoloDetector(tmp_path / "renamed.pt", threshold=1e-5, imgsz=320, boxes_max=20)
    assert {one.label for one in detector.detect(SCENE)} <= set(COCO_LABELS)


def test_weights_that_number_their_classes_are_refused_in_words(untrained_detector: Path, tmp_path: Path) -> None:
    from ultralytics import YOLO

    model = YOLO(str(untrained_detector))
    model.model.names = {number: str(number) for number in range(80)}
    model.save(str(tmp_path / "numbers.pt"))
    with pytest.raises(ValueError, match="knows classes that are not COCO's: 0, 1, 10"):
        YoloDetector(tmp_path / "numbers.pt", threshold=0.3, imgsz=320)


@pytest.mark.parametrize(
    ("read", "card"),
    [
        (read_card, '{"detector": {"threshold": NaN}}'),
        (read_card, '{"detector": {"threshold": 30}}'),
        (read_card, '{"detector": {"imgsz": 0}}'),
        (read_card, '{"detector": {"confidence": 0.3}}'),
        (read_clip_card, '{"clip": {"threshold": Infinity}}'),
        (read_clip_card, '{"clip": {"colour_margin": -0.1}}'),
    ],
)
def test_a_card_that_makes_no_sense_is_refused(tmp_path: Path, read: Callable[[Path], object], card: str) -> None:
    (tmp_path / "weights.json").write_text(card)
    with pytest.raises(ValueError, match="validation error"):
        read(tmp_path / "weights.pt")
