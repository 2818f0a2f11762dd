"""Pictures of remembered things: the crop each was last seen on, while somebody watched; in this process only."""

import io
from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from PIL import Image

from contracts.memory import RememberedObject
from contracts.vision import Detections
from ui import overlay

SIDE_PX: Final = 96
ROUND_IT: Final = 0.25
"""Of the box's longer side, shown on each side of it."""


@dataclass(frozen=True, slots=True)
class Thumbnail:
    frame: overlay.CameraFrame
    at: tuple[float, float, float, float]
    """The box, in fractions of the picture's sides."""


class Thumbnails:
    """`put` what is seen, `match` it with what memory says was seen then; both keep the newest `kept_max`."""

    def __init__(self, kept_max: int) -> None:
        self._kept_max = kept_max
        self._seen: OrderedDict[tuple[str, float], Thumbnail] = OrderedDict()
        self._of: dict[int, tuple[float, Thumbnail]] = {}

    def put(self, seen: Detections, frame: overlay.CameraFrame) -> None:
        """Things alone of their kind in the picture: of two alike nobody can say here which is which."""
        if not overlay.same_view(frame, seen):
            return
        labels = [one.label for one in seen.detections]
        width, height = seen.image_width_px, seen.image_height_px
        for one in seen.detections:
            if labels.count(one.label) == 1:
                left, top, right, bottom = one.bbox_xyxy
                at = (left / width, top / height, right / width, bottom / height)
                self._seen[one.label, seen.stamp_s] = Thumbnail(frame, at)
        while len(self._seen) > self._kept_max:
            self._seen.popitem(last=False)

    def match(self, things: Iterable[RememberedObject]) -> None:
        of: dict[int, tuple[float, Thumbnail]] = {}
        for one in things:
            newer = self._seen.get((one.label, one.last_seen_s))
            if newer is not None:
                of[one.id] = (one.last_seen_s, newer)
            elif one.id in self._of:
                of[one.id] = self._of[one.id]
        self._of = dict(list(of.items())[: self._kept_max])

    def known(self, label: str, stamp_s: float) -> bool:
        return (label, stamp_s) in self._seen

    def version(self, object_id: int) -> float | None:
        """When it was seen so; none where there is no picture."""
        kept = self._of.get(object_id)
        return kept[0] if kept is not None else None

    def get(self, object_id: int) -> Thumbnail | None:
        kept = self._of.get(object_id)
        return kept[1] if kept is not None else None


def cropped(thumbnail: Thumbnail) -> bytes:
    """A square JPEG of the thing with a little round it. Raises `OSError` when the picture cannot be read."""
    image = Image.open(io.BytesIO(thumbnail.frame.jpeg)).convert("RGB")
    left, top, right, bottom = thumbnail.at
    x, y = (left + right) / 2 * image.width, (top + bottom) / 2 * image.height
    side = max((right - left) * image.width, (bottom - top) * image.height) * (1 + 2 * ROUND_IT)
    half = max(4.0, min(side, image.width, image.height) / 2)
    x = min(max(x, half), image.width - half)
    y = min(max(y, half), image.height - half)
    square = image.crop((round(x - half), round(y - half), round(x + half), round(y + half)))
    out = io.BytesIO()
    square.resize((SIDE_PX, SIDE_PX)).save(out, "JPEG", quality=80)
    return out.getvalue()
