"""Loads the models a set names: slow, blocking, done once in the worker thread."""

import pickle
from collections.abc import Callable

import structlog
from safetensors import SafetensorError

from inference.adapters.image_text import OpenClipModel, SmallClipModel
from inference.adapters.yolo import YoloDetector
from inference.models import Loaded
from inference.ports import Detector, ImageText
from inference.settings import ModelSet, Settings

log = structlog.get_logger()

UNLOADABLE = (
    *(OSError, ValueError, RuntimeError, ImportError, LookupError, TypeError, AttributeError),
    *(pickle.UnpicklingError, SafetensorError),
)
"""What missing, damaged or foreign weights raise in torch, ultralytics and open_clip."""


def loader(settings: Settings) -> Callable[[], Loaded]:
    """A function that loads what `settings` name; what cannot be loaded is named in `Loaded.problems`."""

    def load() -> Loaded:
        problems: list[str] = []
        detector: Detector | None = None
        clip: ImageText | None = None
        try:
            detector = YoloDetector(
                settings.detector_file,
                threshold=settings.detector_confidence_min,
                imgsz=settings.imgsz,
                boxes_max=settings.detector_boxes_max,
                torch_threads=settings.torch_threads,
            )
        except UNLOADABLE as error:
            problems.append(f"detector: {error}")
        kind = SmallClipModel if settings.model_set is ModelSet.SIM else OpenClipModel
        try:
            clip = kind(settings.clip_file, threshold=settings.clip_threshold, colour_margin=settings.colour_margin)
        except UNLOADABLE as error:
            problems.append(f"clip: {error}")
        for problem in problems:
            log.error("a model could not be loaded", problem=problem)
        return Loaded(detector=detector, clip=clip, problems=tuple(problems))

    return load
