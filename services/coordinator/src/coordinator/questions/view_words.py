"""What a picture shows, in words for a person: each thing with its side and its distance. Pure."""

import math
from typing import Final

from contracts.vision import Detection, Detections

TOLD_MAX: Final = 12
CONFIDENCE_MIN: Final = 0.35
MIDDLE: Final = 1.0 / 6.0
"""Of the picture's width, to either side of its middle: straight ahead."""


def view_in_words(seen: Detections) -> str:
    """The surest first. Things that the detector is not sure of are left out."""
    sure = sorted((d for d in seen.detections if d.confidence >= CONFIDENCE_MIN), key=lambda d: -d.confidence)
    if not sure:
        return "I see nothing that I know."
    told = [_thing(one, seen.image_width_px) for one in sure[:TOLD_MAX]]
    more = f"; and {len(sure) - TOLD_MAX} more" if len(sure) > TOLD_MAX else ""
    return f"I see {'; '.join(told)}{more}."


def _thing(one: Detection, width_px: int) -> str:
    name = f"{one.colour} {one.label}" if one.colour else one.label
    off = ((one.bbox_xyxy[0] + one.bbox_xyxy[2]) / 2 - width_px / 2) / width_px
    side = "straight ahead" if abs(off) <= MIDDLE else "to the left" if off < 0.0 else "to the right"
    distance_m = one.measurement.distance_m if one.measurement is not None else None
    far = "" if distance_m is None or not math.isfinite(distance_m) else f", {distance_m:.1f} m away"
    article = "an" if name[0] in "aeiou" else "a"
    return f"{article} {name} {side}{far}"
