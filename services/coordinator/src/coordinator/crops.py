"""Cutting what a box shows out of a picture, as evidence for a person."""

import io

from PIL import Image, UnidentifiedImageError

from contracts.robot import BoxQuery
from mesh.errors import UpstreamError

MARGIN = 0.35
QUALITY = 80


def crop(jpeg: bytes, box: BoxQuery, side_px_max: int) -> bytes:
    """The box with some room round it, as JPEG. Raises `UpstreamError` when the picture is none."""
    try:
        with Image.open(io.BytesIO(jpeg)) as picture:
            picture.load()
            whole = picture.convert("RGB")
    except (UnidentifiedImageError, OSError, ValueError, Image.DecompressionBombError) as error:
        raise UpstreamError("robot_bridge", 200, f"the frame is no picture: {type(error).__name__}") from error
    across, down = whole.width / box.image_width_px, whole.height / box.image_height_px
    x0, y0, x1, y1 = box.bbox_xyxy
    room_px = MARGIN * max(x1 - x0, y1 - y0) + 8
    edges = (
        max(0, int((x0 - room_px) * across)),
        max(0, int((y0 - room_px) * down)),
        min(whole.width, int((x1 + room_px) * across) + 1),
        min(whole.height, int((y1 + room_px) * down) + 1),
    )
    cut = whole.crop(edges) if edges[0] < edges[2] and edges[1] < edges[3] else whole
    cut.thumbnail((side_px_max, side_px_max))
    out = io.BytesIO()
    cut.save(out, "JPEG", quality=QUALITY)
    return out.getvalue()
