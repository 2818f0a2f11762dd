"""Boxes of a picture: x_min, y_min, x_max, y_max in px."""

import math
from collections.abc import Sequence

Box = Sequence[float]


def iou(a: Box, b: Box) -> float:
    """Intersection over union, 0 to 1."""
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    shared = width * height if width > 0.0 and height > 0.0 else 0.0
    return shared / (area(a) + area(b) - shared) if shared > 0.0 else 0.0  # a sliver's area may round to nothing


def area(box: Box) -> float:
    """px²; 0 if the corners are the wrong way round."""
    return max(0.0, box[2] - box[0]) * max(0.0, box[3] - box[1])


def center_distance(a: Box, b: Box) -> float:
    """Between the centers, px."""
    return math.hypot((a[0] + a[2] - b[0] - b[2]) / 2, (a[1] + a[3] - b[1] - b[3]) / 2)
