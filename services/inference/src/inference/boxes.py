"""Which of several boxes is meant: overlap, nearness, scaling. Pure; boxes are x_min, y_min, x_max, y_max in px."""

from collections.abc import Sequence

from contracts.base import BboxXyxy
from contracts.vision import Detection, Target
from geometry.boxes import center_distance, iou


def best_target(detections: Sequence[Detection], target: Target) -> Detection | None:
    """The detection to announce: a known right colour first, then confidence; none when no one matches."""
    candidates = [one for one in detections if target.may_be(one.label, one.colour)]
    named = target.colour is not None
    return max(candidates, key=lambda one: (named and one.colour is not None, one.confidence), default=None)


def meant_box(detections: Sequence[Detection], target: Target, bbox_xyxy: BboxXyxy | None) -> Detection | None:
    """The detection of the target's class that the caller means: most overlap with `bbox_xyxy`, then nearest.

    Without a box it is the one that would have been announced, else the surest of the class.
    """
    same_class = [one for one in detections if one.label == target.label]
    if bbox_xyxy is None:
        return best_target(same_class, target) or max(same_class, key=lambda one: one.confidence, default=None)
    return max(
        same_class,
        key=lambda one: (iou(one.bbox_xyxy, bbox_xyxy), -center_distance(one.bbox_xyxy, bbox_xyxy)),
        default=None,
    )


def scaled(detection: Detection, x: float, y: float) -> Detection:
    """The same detection in a frame `x` times as wide and `y` times as high."""
    left, top, right, bottom = detection.bbox_xyxy
    return detection.model_copy(update={"bbox_xyxy": (left * x, top * y, right * x, bottom * y)})
