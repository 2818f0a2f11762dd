"""Crops for the small CLIP: every labelled thing cut out of its image, with what it is."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from inference.perception.small_clip import crop, letterbox
from sim.training.phrases import Meaning
from sim.training.records import Box, read_frames

SHORT_SIDE_MIN_PX = 7


@dataclass(frozen=True)
class Crops:
    """Squares (n, s, s, 3) as the model sees them, what each shows, and its box in the image."""

    squares: npt.NDArray[np.uint8]
    meanings: list[Meaning]
    boxes: list[Box]


def read_crops(data: Path, size_px: int, copies: int, seed: int) -> Crops:
    """Cut out every box; with `copies` > 0 that many times, each a little off, as a detector's boxes are.

    With `copies` 0 the boxes are taken as they are, once.
    """
    rng = np.random.default_rng(seed)
    squares: list[npt.NDArray[np.uint8]] = []
    meanings: list[Meaning] = []
    boxes: list[Box] = []
    for frame in read_frames(data):
        image = cv2.cvtColor(cv2.imread(str(data / frame.image)), cv2.COLOR_BGR2RGB)
        for box in frame.boxes:
            if box.short_side_px < SHORT_SIDE_MIN_PX:
                continue
            for _ in range(max(1, copies)):
                bbox = shaken(box.bbox_xyxy, rng) if copies else box.bbox_xyxy
                squares.append(letterbox(crop(image, bbox), size_px))
                meanings.append(Meaning(box.kind, box.colour))
                boxes.append(box)
    return Crops(np.stack(squares), meanings, boxes)


def shaken(bbox_xyxy: tuple[int, int, int, int], rng: np.random.Generator) -> tuple[float, float, float, float]:
    """The box with each side moved by a few per cent of the box's size."""
    x_min, y_min, x_max, y_max = bbox_xyxy
    width, height = x_max - x_min, y_max - y_min
    off = rng.normal(0, 0.06, 4)
    return (x_min + off[0] * width, y_min + off[1] * height, x_max + off[2] * width, y_max + off[3] * height)
