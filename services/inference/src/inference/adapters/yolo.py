"""The detector behind ultralytics: a `.pt` file, or an exported OpenVINO folder or ONNX file, by its path."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contracts.coco import COCO_LABELS
from contracts.vision import Detection
from inference.ports import RgbImage

QUIET_AND_OFFLINE = {"YOLO_OFFLINE": "true", "YOLO_AUTOINSTALL": "false", "YOLO_VERBOSE": "false"}
"""ultralytics reads these at import: no look at the network, no pip of its own (requirement A18)."""
OPENVINO_FOLDER = "_openvino_model"
"""How ultralytics ends the name of an OpenVINO export."""


@dataclass(frozen=True, slots=True)
class DetectorCard:
    """What belongs to the weights: read from the `.json` beside them, else requirement A7's numbers."""

    threshold: float = 0.30
    imgsz: int = 320
    """px, the side of the square the weights look at."""


def read_card(weights: Path) -> DetectorCard:
    """Raises ValueError or TypeError where the `.json` beside the weights is not a card."""
    path = weights.with_suffix(".json")
    return DetectorCard(**json.loads(path.read_text())["detector"]) if path.is_file() else DetectorCard()


def backend_of(path: Path) -> str:
    """'torch', 'onnx', 'openvino', or what the file's ending says."""
    if path.is_dir():
        return "openvino"
    return {".pt": "torch", ".onnx": "onnx"}.get(path.suffix, path.suffix.lstrip("."))


class YoloDetector:
    """Raises FileNotFoundError when there is nothing at `path`, ValueError when its classes are not COCO's.

    Not thread-safe: one thread loads it and calls it. `threads` holds for every backend: two beside a busy neighbour on
    two cores are many times slower than one.
    """

    def __init__(
        self,
        path: Path,
        *,
        threshold: float,
        imgsz: int,
        boxes_max: int = 100,
        threads: int = 1,
        name: str = "",
        backends_ms: Mapping[str, float] | None = None,
    ) -> None:
        if not path.exists():
            raise FileNotFoundError(f"no detector weights at {path}")
        for key, value in QUIET_AND_OFFLINE.items():
            os.environ.setdefault(key, value)
        from inference import torchvision_cpu

        torchvision_cpu.install()
        import torch
        from ultralytics import YOLO

        self.name = name or path.stem.removesuffix(OPENVINO_FOLDER)
        self.backend = backend_of(path)
        self.backends_ms = dict(backends_ms or {})
        self.threshold = threshold
        self._model: Any = YOLO(str(path), task="detect")
        self._arguments = {"imgsz": imgsz, "conf": threshold, "max_det": boxes_max, "device": "cpu", "verbose": False}
        self.detect(np.full((imgsz, imgsz, 3), 127, np.uint8))  # the first call builds the predictor
        torch.set_num_threads(threads)  # after the first call, which sets it to all cores
        _limit_threads(self._model.predictor.model.backend, path, threads)
        strange = set(self._model.names.values()) - set(COCO_LABELS)
        if strange:
            raise ValueError(f"{path} knows classes that are not COCO's: {', '.join(sorted(strange)[:5])}")

    def detect(self, image: RgbImage) -> tuple[Detection, ...]:
        return _detections(self._model.predict(np.ascontiguousarray(image[:, :, ::-1]), **self._arguments)[0])


def _detections(result: Any) -> tuple[Detection, ...]:
    boxes = result.boxes.cpu().numpy()
    return tuple(
        Detection(
            label=result.names[int(number)],
            confidence=min(1.0, float(confidence)),
            bbox_xyxy=(round(x_min, 2), round(y_min, 2), round(x_max, 2), round(y_max, 2)),
        )
        for number, confidence, (x_min, y_min, x_max, y_max) in zip(
            boxes.cls.tolist(), boxes.conf.tolist(), boxes.xyxy.tolist(), strict=True
        )
    )


def _limit_threads(backend: Any, path: Path, threads: int) -> None:
    """OpenVINO and ONNX Runtime take every core, and ultralytics has no setting for it: built again with `threads`."""
    if hasattr(backend, "ov_compiled_model"):
        import openvino

        core: Any = openvino.Core()
        xml = path if path.is_file() else next(path.glob("*.xml"))
        config = {"PERFORMANCE_HINT": "LATENCY", "INFERENCE_NUM_THREADS": threads}
        backend.ov_compiled_model = core.compile_model(str(xml), "CPU", config)
    elif hasattr(backend, "session"):
        import onnxruntime

        library: Any = onnxruntime
        options = library.SessionOptions()
        options.intra_op_num_threads = threads
        backend.session = library.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
