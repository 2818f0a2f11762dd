"""Loads the models a set names: slow, blocking, done once in the worker thread."""

import pickle
from collections.abc import Callable
from dataclasses import dataclass

import structlog
from safetensors import SafetensorError

from inference.adapters.exports import Exports
from inference.adapters.image_text import OpenClipModel, Overrides, SmallClipModel
from inference.adapters.yolo import OPENVINO_FOLDER, YoloDetector, read_card
from inference.perception.models import Loaded
from inference.ports import Detector, ImageText
from inference.settings import ModelSet, Settings

log = structlog.get_logger()

UNLOADABLE = (
    *(OSError, ValueError, RuntimeError, ImportError, LookupError, TypeError, AttributeError),
    *(pickle.UnpicklingError, SafetensorError),
)
"""What missing, damaged or foreign weights raise in torch, ultralytics and open_clip."""


def detector_exports(settings: Settings) -> Exports:
    return Exports(
        weights=settings.detector_file,
        backend=settings.detector_backend,
        imgsz=settings.imgsz or read_card(settings.detector_file).imgsz,
        threads=settings.model_threads,
        kept_in=settings.exports_dir,
        timeout_s=settings.export_timeout_s,
    )


def load_detector(settings: Settings) -> YoloDetector:
    """The detector `settings` name, on the best backend for which it was exported before."""
    exports = detector_exports(settings)
    exports.check()
    chosen = exports.choice()
    return YoloDetector(
        chosen.path,
        threshold=settings.detector_confidence_min or read_card(exports.weights).threshold,
        imgsz=exports.imgsz,
        boxes_max=settings.detector_boxes_max,
        threads=exports.threads,
        name=exports.weights.stem.removesuffix(OPENVINO_FOLDER),
        backends_ms=chosen.backends_ms,
    )


@dataclass(frozen=True)
class FasterDetector:
    """The detector on a backend for which an export has yet to be made."""

    settings: Settings

    async def prepare(self) -> str:
        exports = detector_exports(self.settings)
        return exports.trouble() or (await exports.make() if exports.missing() else "")

    def load(self) -> Detector:
        return load_detector(self.settings)


def load_clip(settings: Settings) -> ImageText:
    overrides = Overrides(settings.clip_threshold, settings.colour_margin, settings.vote_margin)
    if settings.model_set is ModelSet.SIM:
        return SmallClipModel(settings.clip_file, overrides=overrides)
    return OpenClipModel(settings.clip_file, precision=settings.clip_precision, overrides=overrides)


def loader(settings: Settings) -> Callable[[], Loaded]:
    """A function that loads what `settings` name; what cannot be loaded is named in `Loaded.problems`."""

    def load() -> Loaded:
        problems: list[str] = []
        detector: Detector | None = None
        clip: ImageText | None = None
        try:
            detector = load_detector(settings)
        except UNLOADABLE as error:
            problems.append(f"detector: {error}")
        try:
            clip = load_clip(settings)
        except UNLOADABLE as error:
            problems.append(f"clip: {error}")
        for problem in problems:
            log.error("a model could not be loaded", problem=problem)
        exports = detector_exports(settings) if detector is not None else None
        faster = FasterDetector(settings) if exports is not None and (exports.missing() or exports.trouble()) else None
        return Loaded(detector=detector, clip=clip, problems=tuple(problems), faster=faster)

    return load
