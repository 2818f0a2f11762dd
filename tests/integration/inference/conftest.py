"""Real models: the shape of the real ones, untrained where the test is about well-formedness."""

import os
from pathlib import Path

import pytest

from contracts.coco import COCO_LABELS

os.environ.setdefault("YOLO_OFFLINE", "true")


@pytest.fixture(scope="session")
def untrained_detector(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A YOLOv8n of COCO's classes as ultralytics saves it, with random weights."""
    from inference import torchvision_cpu

    torchvision_cpu.install()
    from ultralytics import YOLO

    path = tmp_path_factory.mktemp("weights") / "untrained.pt"
    model = YOLO("yolov8n.yaml", task="detect")
    model.model.names = dict(enumerate(COCO_LABELS))
    model.save(str(path))
    return path


@pytest.fixture(scope="session")
def untrained_clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small CLIP of the real architecture and file format, with random weights."""
    from inference import small_clip

    path = tmp_path_factory.mktemp("weights") / "untrained.safetensors"
    config = small_clip.ClipConfig(name="untrained", words=("bottle", "cup", "red", "blue", "green"), threshold=0.45)
    small_clip.save(path, small_clip.build(config), config, {})
    return path
