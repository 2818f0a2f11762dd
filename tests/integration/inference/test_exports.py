"""Exports of the committed detector: made once, kept, timed, chosen, and seeing what the weights see."""

import asyncio
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from contracts.vision import Detection
from geometry.boxes import iou
from inference.adapters.exports import FILES, TIMINGS, Exports
from inference.adapters.loading import FasterDetector, load_detector
from inference.adapters.yolo import YoloDetector
from inference.settings import Backend, Settings
from support.rendered_bottle import bottle_scene
from support.source import ROOT

WEIGHTS = ROOT / "sim/weights/detector.pt"
UNSEEN_SEED = 900_101


@pytest.fixture(scope="module")
def kept_in(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("exports")


def settings(kept_in: Path, backend: Backend = Backend.AUTO) -> Settings:
    return Settings(detector_path=WEIGHTS, detector_backend=backend, exports_dir=kept_in, export_timeout_s=900.0)


@pytest.fixture(scope="module")
def made(kept_in: Path) -> Path:
    """The folder of the exports, after the first use."""
    assert load_detector(settings(kept_in)).backend == "torch"
    assert asyncio.run(FasterDetector(settings(kept_in)).prepare()) == ""
    (folder,) = kept_in.iterdir()
    return folder


def agree(a: Detection, b: Detection) -> bool:
    alike = a.label == b.label and abs(a.confidence - b.confidence) < 0.03
    return alike and iou(a.bbox_xyxy, b.bbox_xyxy) > 0.95


@pytest.mark.timeout(1000)
def test_every_backend_sees_what_the_weights_see(made: Path) -> None:
    scene = bottle_scene(UNSEEN_SEED).picture("red")
    by_weights = YoloDetector(WEIGHTS, threshold=0.4, imgsz=320).detect(scene)
    assert "bottle" in {one.label for one in by_weights}
    for file in FILES.values():
        found = YoloDetector(made / file, threshold=0.4, imgsz=320).detect(scene)
        assert len(found) == len(by_weights)
        assert all(agree(one, other) for one, other in zip(found, by_weights, strict=True))


@pytest.mark.timeout(1000)
def test_the_fastest_is_chosen_and_the_others_are_told(made: Path, kept_in: Path) -> None:
    timings = json.loads((made / TIMINGS).read_text())
    invented = timings | {"ms": {"torch": 30.0, "openvino": 10.0, "onnx": 20.0}}
    (made / TIMINGS).write_text(json.dumps(invented))
    detector = load_detector(settings(kept_in))
    assert (detector.name, detector.backend, detector.backends_ms) == ("detector", "openvino", invented["ms"])
    (made / TIMINGS).write_text(json.dumps(invented | {"ms": {"torch": 1.0, "openvino": 10.0, "onnx": 20.0}}))
    assert load_detector(settings(kept_in)).backend == "torch"
    assert load_detector(settings(kept_in, Backend.ONNX)).backend == "onnx"
    (made / TIMINGS).write_text(json.dumps(timings))


@pytest.mark.timeout(1000)
def test_nothing_is_made_twice(made: Path, kept_in: Path) -> None:
    before = {file: file.stat().st_mtime_ns for file in made.rglob("*")}
    assert asyncio.run(FasterDetector(settings(kept_in)).prepare()) == ""
    assert {file: file.stat().st_mtime_ns for file in made.rglob("*")} == before
    assert set(timings_of(made)) == {"torch", "openvino", "onnx"}
    assert all(value > 0.0 for value in timings_of(made).values())


def timings_of(folder: Path) -> dict[str, float]:
    return json.loads((folder / TIMINGS).read_text())["ms"]


@pytest.mark.timeout(1000)
def test_timings_of_another_machine_are_taken_again(made: Path, kept_in: Path) -> None:
    elsewhere = json.loads((made / TIMINGS).read_text())
    elsewhere["circumstances"]["cores"] = 1000
    before = (made / TIMINGS).read_text()
    (made / TIMINGS).write_text(json.dumps(elsewhere))
    exports = exports_of(kept_in)
    assert (exports.missing(), exports.choice().path) == (True, WEIGHTS)
    (made / TIMINGS).write_text(before)
    assert not exports_of(kept_in).missing()


def exports_of(
    kept_in: Path, weights: Path = WEIGHTS, backend: Backend = Backend.AUTO, timeout_s: float = 300.0
) -> Exports:
    return Exports(weights=weights, backend=backend, imgsz=320, threads=1, kept_in=kept_in, timeout_s=timeout_s)


async def test_damaged_weights_are_a_named_trouble(tmp_path: Path) -> None:
    (tmp_path / "damaged.pt").write_bytes(b"not weights")
    trouble = await exports_of(tmp_path / "exports", tmp_path / "damaged.pt").make()
    assert trouble
    assert exports_of(tmp_path / "exports", tmp_path / "damaged.pt").missing()


async def test_an_export_that_takes_too_long_is_given_up(tmp_path: Path) -> None:
    assert await exports_of(tmp_path, timeout_s=0.01).make() == "it took longer than 0.01 s"


def test_an_export_cannot_be_asked_to_be_another(made_up_export: Path, tmp_path: Path) -> None:
    exports_of(tmp_path, made_up_export).check()
    exports_of(tmp_path, made_up_export, Backend.ONNX).check()
    with pytest.raises(ValueError, match="cannot run on openvino"):
        exports_of(tmp_path, made_up_export, Backend.OPENVINO).check()
    assert not exports_of(tmp_path, made_up_export).missing()


@pytest.fixture
def made_up_export(tmp_path: Path) -> Path:
    (tmp_path / "some.onnx").write_bytes(b"")
    return tmp_path / "some.onnx"


def test_a_library_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("inference.adapters.exports.installed", lambda _: False)
    assert exports_of(tmp_path, backend=Backend.OPENVINO).trouble() == "openvino needs the package openvino"
    assert exports_of(tmp_path).trouble() == ""
    assert (exports_of(tmp_path).missing(), exports_of(tmp_path).choice().path) == (False, WEIGHTS)


@pytest.mark.parametrize("family", ["yolo11n.yaml", "yolo26n.yaml"])
def test_other_families_of_yolo_are_one_setting_away(
    family: str, untrained: Callable[[str, Path], Path], tmp_path: Path
) -> None:
    path = untrained(family, tmp_path / family.replace("yaml", "pt"))
    detector = load_detector(
        Settings(detector_path=path, detector_backend=Backend.TORCH, detector_confidence_min=0.01, exports_dir=tmp_path)
    )
    found = detector.detect(np.random.default_rng(0).integers(0, 256, (240, 320, 3), np.uint8))
    assert detector.name == family.removesuffix(".yaml")
    assert all(0.01 <= one.confidence <= 1.0 for one in found)
