"""The detector behind ultralytics: a `.pt` file, or an exported OpenVINO folder or ONNX file, by its path."""

import json
import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import structlog
from prometheus_client import Counter
from pydantic import BaseModel, ConfigDict, Field

from contracts.vision import Detection
from inference.perception.classes import label_of
from inference.perception.raw_boxes import Believed, NoBox, Picture, believed
from inference.ports import MODEL_ERRORS, RgbImage
from mesh.errors import UnavailableError

log = structlog.get_logger()

BOXES_REFUSED = Counter("inference_boxes_refused_total", "rows of a detector's answer that are no boxes", ["kind"])
TELL_EVERY_S = 60.0
"""Boxes that are none are logged once in that time."""
QUIET_AND_OFFLINE = {"YOLO_OFFLINE": "true", "YOLO_AUTOINSTALL": "false", "YOLO_VERBOSE": "false"}
"""ultralytics reads these at import: no look at the network, no pip of its own (requirement A18)."""
OPENVINO_FOLDER = "_openvino_model"
"""How ultralytics ends the name of an OpenVINO export."""


class DetectorCard(BaseModel):
    """What belongs to the weights: read from the `.json` beside them, else requirement A7's numbers."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    threshold: float = Field(default=0.30, gt=0.0, lt=1.0)
    imgsz: int = Field(default=320, ge=32, le=4096, description="px, the side of the square the weights look at")


def read_card(weights: Path) -> DetectorCard:
    """Raises ValueError where the `.json` beside the weights is not a card."""
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
        from inference.perception import torchvision_cpu

        torchvision_cpu.install()
        import torch
        from ultralytics import YOLO

        self.name = name or path.stem.removesuffix(OPENVINO_FOLDER)
        self.backend = backend_of(path)
        self.backends_ms = dict(backends_ms or {})
        self.threshold = threshold
        self.trouble = ""
        self._boxes_max = boxes_max
        self._told_s = -TELL_EVERY_S
        self._model: Any = YOLO(str(path), task="detect")
        self._arguments = {"imgsz": imgsz, "conf": threshold, "max_det": boxes_max, "device": "cpu", "verbose": False}
        self._model.predict(np.full((imgsz, imgsz, 3), 127, np.uint8), **self._arguments)  # builds the predictor
        self._inference_mode = torch.inference_mode
        torch.set_num_threads(threads)  # after the first call, which sets it to all cores
        _limit_threads(self._model.predictor.model.backend, path, threads)
        self._labels = _labels(self._model.names, path)

    def detect(self, image: RgbImage) -> tuple[Detection, ...]:
        """Raises `UnavailableError` where the model fails on this image, or its answer has not the shape of boxes.

        So does an answer of which nothing is left, and some of it was no number: that picture was not seen empty.
        """
        picture = Picture(image.shape[1], image.shape[0])
        try:
            found = self._believed(self._looked(np.ascontiguousarray(image[:, :, ::-1])), picture)
        except MODEL_ERRORS as error:
            self.trouble = f"could not look at a picture: {error}"
            raise UnavailableError("detector", self.trouble) from error
        self._tell(found)
        return found.detections

    def _looked(self, bgr: RgbImage) -> Any:
        """What `predict` does of one picture, by its own steps: nothing for files, streams and settings."""
        predictor = self._model.predictor
        with self._inference_mode():
            predictor.batch = [""], [bgr], [""]
            squares = predictor.preprocess([bgr])
            return predictor.postprocess(predictor.inference(squares), squares, [bgr])[0]

    def _believed(self, result: Any, picture: Picture) -> Believed:
        boxes = result.boxes.cpu().numpy()
        found = believed(
            boxes.cls, boxes.conf, boxes.xyxy, labels=self._labels, picture=picture, boxes_max=self._boxes_max
        )
        if NoBox.NOT_FINITE in found.refused and not found.detections:
            raise ValueError("its numbers are not finite")
        return found

    def _tell(self, found: Believed) -> None:
        """In `trouble` until the next picture, in the metrics always, in the log now and then."""
        told = ", ".join(f"{count} {kind}" for kind, count in found.refused.items())
        self.trouble = f"of its boxes some were none: {told}" if told else ""
        for kind, count in found.refused.items():
            BOXES_REFUSED.labels(kind.name.lower()).inc(count)
        if told and time.monotonic() >= self._told_s + TELL_EVERY_S:
            self._told_s = time.monotonic()
            log.warning("a detector gave boxes that are none", model=self.name, refused=told)


def _labels(names: Mapping[int, str] | Sequence[str], path: Path) -> dict[int, str]:
    """COCO's label of each class number. Raises ValueError where a class has none."""
    named = dict(names) if isinstance(names, Mapping) else dict(enumerate(names))
    labels = {number: label_of(str(name)) for number, name in named.items()}
    strange = sorted({str(named[number]) for number, label in labels.items() if label is None})
    if strange:
        raise ValueError(f"{path} knows classes that are not COCO's: {', '.join(strange[:5])}")
    return {number: label for number, label in labels.items() if label is not None}


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
