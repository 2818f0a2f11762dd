"""Real models: the shape of the real ones, untrained where the test is about well-formedness."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from contracts.coco import COCO_LABELS

os.environ.setdefault("YOLO_OFFLINE", "true")


@pytest.fixture(scope="session")
def untrained() -> Callable[[str, Path], Path]:
    """Makes a YOLO of COCO's classes as ultralytics saves it, with random weights."""

    def make(architecture: str, path: Path) -> Path:
        from inference.perception import torchvision_cpu

        torchvision_cpu.install()
        from ultralytics import YOLO

        model = YOLO(architecture, task="detect")
        model.model.names = dict(enumerate(COCO_LABELS))
        model.save(str(path))
        return path

    return make


@pytest.fixture(scope="session")
def untrained_detector(untrained: Callable[[str, Path], Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    return untrained("yolov8n.yaml", tmp_path_factory.mktemp("weights") / "untrained.pt")


@pytest.fixture(scope="session")
def untrained_clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small CLIP of the real architecture and file format, with random weights."""
    from inference.perception import small_clip

    path = tmp_path_factory.mktemp("weights") / "untrained.safetensors"
    config = small_clip.ClipConfig(name="untrained", words=("bottle", "cup", "red", "blue", "green"), threshold=0.45)
    small_clip.save(path, small_clip.build(config), config, {})
    return path
