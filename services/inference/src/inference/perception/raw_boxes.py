"""A detector's numbers, judged box by box: what is none is left out and counted, and nothing is bent right. Pure."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np
import numpy.typing as npt

from contracts.base import BboxXyxy
from contracts.vision import Detection

STICKS_OUT_MAX = 0.05
"""Share of the picture's side by which a box may stick out of it, and is cut there; beyond, it is of no picture."""
OVER_ONE_MAX = 1e-3
"""What rounding adds to a confidence."""


class NoBox(StrEnum):
    """What is wrong with a row."""

    NOT_FINITE = "not finite"
    CONFIDENCE = "confidence out of range"
    CLASS = "unknown class"
    EMPTY = "empty or inverted"
    OUTSIDE = "outside of the picture"


@dataclass(frozen=True, slots=True)
class Believed:
    detections: tuple[Detection, ...] = ()
    """Best first."""
    refused: Mapping[NoBox, int] = field(default_factory=dict[NoBox, int])


@dataclass(frozen=True, slots=True)
class Picture:
    width_px: int
    height_px: int


def believed(
    classes: Any, confidences: Any, boxes: Any, *, labels: Mapping[int, str], picture: Picture, boxes_max: int
) -> Believed:
    """n class numbers, n confidences (0..1) and n boxes (x_min, y_min, x_max, y_max in pixels of `picture`).

    Raises `ValueError` where they are not n, n and n x 4 numbers.
    """
    rows = _rows(classes, confidences, boxes)
    judged = [_judged(row, labels, picture) for row in rows.tolist()]
    found = [one for one in judged if isinstance(one, Detection)]
    found.sort(key=lambda one: -one.confidence)
    return Believed(tuple(found[:boxes_max]), Counter(one for one in judged if isinstance(one, NoBox)))


def _rows(classes: Any, confidences: Any, boxes: Any) -> npt.NDArray[np.float64]:
    """(n, 6): class, confidence, box."""
    numbers, sure, corners = (np.asarray(one, np.float64) for one in (classes, confidences, boxes))
    count = numbers.size
    if numbers.shape != (count,) or sure.shape != (count,) or corners.shape != (count, 4):
        shapes = ", ".join(str(one.shape) for one in (numbers, sure, corners))
        raise ValueError(f"classes, confidences and boxes of the shapes {shapes}")
    return np.column_stack((numbers, sure, corners))


def _judged(row: Sequence[float], labels: Mapping[int, str], picture: Picture) -> Detection | NoBox:
    if not all(map(math.isfinite, row)):
        return NoBox.NOT_FINITE
    number, confidence, *corners = row
    box = _inside(corners, picture)
    if box is None:
        return NoBox.OUTSIDE
    faults = {
        NoBox.CONFIDENCE: not 0.0 <= confidence <= 1.0 + OVER_ONE_MAX,
        NoBox.CLASS: number not in labels,
        NoBox.EMPTY: box[0] >= box[2] or box[1] >= box[3],
    }
    wrong = next((kind for kind, is_so in faults.items() if is_so), None)
    return wrong or Detection(label=labels[int(number)], confidence=min(1.0, confidence), bbox_xyxy=box)


def _inside(corners: Sequence[float], picture: Picture) -> BboxXyxy | None:
    """In hundredths of a pixel and cut to the picture; none where a corner sticks out too far."""
    sides_px = np.array((picture.width_px, picture.height_px) * 2, np.float64)
    cut = np.clip(corners, 0.0, sides_px)
    if (np.abs(corners - cut) > STICKS_OUT_MAX * sides_px).any():
        return None
    left, top, right, bottom = np.round(cut, 2).tolist()
    return left, top, right, bottom
