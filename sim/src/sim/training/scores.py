"""How good a detector is: average precision per kind, recall by distance; pure arithmetic on boxes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from geometry.boxes import iou
from sim.training.records import Box, Frame

IOU_MIN = 0.5
DISTANCES_M: tuple[float, ...] = (0.0, 0.7, 1.2, 1.6, 2.0, 2.5, 3.5, 9.0)


@dataclass(frozen=True)
class Guess:
    """One box a detector reports."""

    kind: str
    confidence: float
    bbox_xyxy: tuple[float, float, float, float]


@dataclass(frozen=True)
class Truth:
    """One labelled box, and the confidence of the guess that hit it (0 if none did)."""

    box: Box
    confidence: float
    guess: Guess | None


@dataclass(frozen=True)
class Matches:
    """Every guess as (kind, confidence, right or wrong), and every labelled box."""

    guesses: list[tuple[str, float, bool]]
    truths: list[Truth]


def match(frames: Sequence[Frame], guesses: Sequence[Sequence[Guess]]) -> Matches:
    """Pair guesses with labels frame by frame: the surest guess first takes the best free label of its kind."""
    judged: list[tuple[str, float, bool]] = []
    truths: list[Truth] = []
    for frame, found in zip(frames, guesses, strict=True):
        hit: dict[int, Guess] = {}
        for guess in sorted(found, key=lambda one: -one.confidence):
            free = [i for i, box in enumerate(frame.boxes) if i not in hit and box.kind == guess.kind]
            best = max(free, key=lambda i: iou(frame.boxes[i].bbox_xyxy, guess.bbox_xyxy), default=None)
            right = best is not None and iou(frame.boxes[best].bbox_xyxy, guess.bbox_xyxy) >= IOU_MIN
            judged.append((guess.kind, guess.confidence, right))
            if best is not None and right:
                hit[best] = guess
        for i, box in enumerate(frame.boxes):
            truths.append(Truth(box, hit[i].confidence if i in hit else 0.0, hit.get(i)))
    return Matches(judged, truths)


def average_precision(matches: Matches, kind: str) -> float:
    """Area under precision over recall for one kind, sampled at 101 recalls as COCO does; NaN without labels."""
    total = sum(truth.box.kind == kind for truth in matches.truths)
    if total == 0:
        return float("nan")
    hits = [right for _, right in sorted(((c, r) for k, c, r in matches.guesses if k == kind), reverse=True)]
    if not hits:
        return 0.0
    found = np.cumsum(hits)
    recall, precision = found / total, found / np.arange(1, len(hits) + 1)
    precision = np.maximum.accumulate(precision[::-1])[::-1]
    grid = np.linspace(0, 1, 101)
    place = np.searchsorted(recall, grid)
    return float(np.mean([precision[i] if i < len(precision) else 0.0 for i in place]))


def recall(truths: Sequence[Truth], confidence: float) -> float:
    """Share of labelled boxes found with at least this confidence; NaN without labels."""
    return float(np.mean([truth.confidence >= confidence for truth in truths])) if truths else float("nan")


def recall_by_distance(truths: Sequence[Truth], confidence: float) -> dict[str, tuple[float, int]]:
    """Recall and number of labels for each ring of distance."""
    rings: dict[str, tuple[float, int]] = {}
    for near_m, far_m in pairwise(DISTANCES_M):
        inside = [truth for truth in truths if near_m <= truth.box.distance_m < far_m]
        if inside:
            rings[f"{near_m:g}-{far_m:g} m"] = (round(recall(inside, confidence), 3), len(inside))
    return rings


def precision(matches: Matches, confidence: float) -> float:
    """Share of right ones among the guesses with at least this confidence; NaN without any."""
    kept = [right for _, sure, right in matches.guesses if sure >= confidence]
    return float(np.mean(kept)) if kept else float("nan")


def mean(values: Sequence[float]) -> float:
    """The mean of those values that are numbers."""
    numbers: npt.NDArray[np.float64] = np.array([value for value in values if not math.isnan(value)])
    return float(numbers.mean()) if len(numbers) else float("nan")
