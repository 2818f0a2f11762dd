"""What was judged, as it was shown to the image-text model: kept for a while under the validation's id."""

import uuid
from collections import OrderedDict

import cv2

from inference.perception.annotate import to_jpeg
from inference.ports import RgbImage
from mesh.errors import NotFoundError

KEPT = 64
SIDE_PX_MAX = 640
JPEG_QUALITY = 90


class Evidence:
    """The newest 64 crops, as JPEG no longer than 640 px a side."""

    def __init__(self) -> None:
        self._by_id: OrderedDict[str, bytes] = OrderedDict()

    def keep(self, crop: RgbImage) -> str:
        """Its id. `crop` is (h, w, 3), RGB."""
        scale = min(1.0, SIDE_PX_MAX / max(crop.shape[:2]))
        size = (max(1, round(crop.shape[1] * scale)), max(1, round(crop.shape[0] * scale)))
        shown = crop if scale == 1.0 else cv2.resize(crop, size, interpolation=cv2.INTER_AREA)
        name = uuid.uuid4().hex
        self._by_id[name] = to_jpeg(shown, JPEG_QUALITY)  # pyright: ignore[reportArgumentType]
        while len(self._by_id) > KEPT:
            self._by_id.popitem(last=False)
        return name

    def jpeg(self, name: str) -> bytes:
        """Raises `NotFoundError`: never kept, or not any more."""
        if (jpeg := self._by_id.get(name)) is None:
            raise NotFoundError(f"no picture of validation {name[:64]} is kept")
        return jpeg
