"""The detector behind ultralytics: a `.pt` file, or an exported OpenVINO folder or ONNX file, by its path."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from contracts.coco import COCO_LABELS
from contracts.vision import Detection
from inference.ports import RgbImage

BACKENDS = {".pt": "torch", ".onnx": "onnxruntime", ".torchscript": "torchscript"}
QUIET_AND_OFFLINE = {"YOLO_OFFLINE": "true", "YOLO_AUTOINSTALL": "false", "YOLO_VERBOSE": "false"}
"""ultralytics reads these at import: no look at the network, no pip of its own (requirement A18)."""

IMGSZ_MAX = 320
"""px: COCO weights say 640, for which a 250 px camera has no use (requirement A7 works at 320 x 240)."""


class YoloDetector:
    """Raises FileNotFoundError when there is nothing at `path`, ValueError when its classes are not COCO's.

    Not thread-safe: one thread loads it and calls it.
    """

    def __init__(
        self, path: Path, *, threshold: float, imgsz: int | None = None, boxes_max: int = 100, torch_threads: int = 1
    ) -> None:
        if not path.exists():
            raise FileNotFoundError(f"no detector weights at {path}")
        for name, value in QUIET_AND_OFFLINE.items():
            os.environ.setdefault(name, value)
        from inference import torchvision_cpu

        torchvision_cpu.install()
        import torch
        from ultralytics import YOLO

        self._model: Any = YOLO(str(path), task="detect")
        self._threshold = threshold
        own: int | list[int] = self._model.overrides.get("imgsz", IMGSZ_MAX)
        self._imgsz = imgsz or min(own if isinstance(own, int) else max(own), IMGSZ_MAX)
        self._boxes_max = boxes_max
        self.name = path.stem.removesuffix("_openvino_model")
        self.backend = "openvino" if path.is_dir() else BACKENDS.get(path.suffix, path.suffix.lstrip("."))
        self.detect(np.full((self._imgsz, self._imgsz, 3), 127, np.uint8))
        torch.set_num_threads(torch_threads)  # after the first call, which sets it to all cores
        strange = set(self._model.names.values()) - set(COCO_LABELS)
        if strange:
            raise ValueError(f"{path} knows classes that are not COCO's: {', '.join(sorted(strange)[:5])}")

    @property
    def threshold(self) -> float:
        return self._threshold

    def detect(self, image: RgbImage) -> tuple[Detection, ...]:
        bgr = np.ascontiguousarray(image[:, :, ::-1])
        result = self._model.predict(
            bgr, imgsz=self._imgsz, conf=self._threshold, max_det=self._boxes_max, device="cpu", verbose=False
        )[0]
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
