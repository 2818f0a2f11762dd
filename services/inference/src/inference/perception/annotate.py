"""Draws what was seen (requirement A7): the target red with "TARGET:", others green, a status line below."""

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from contracts.vision import Detection, Target
from inference.ports import RgbImage

RED, GREEN, WHITE, DARK = (230, 30, 30), (40, 190, 70), (255, 255, 255), (20, 20, 20)
FONT = cv2.FONT_HERSHEY_SIMPLEX
STATUS_HEIGHT_PX = 22


@dataclass
class AnnotatedFrame:
    """A frame and what was seen in it. Drawn off the loop when somebody first looks, once for all who do."""

    image: RgbImage
    found: tuple[Detection, ...]
    target: Target | None
    width_px: int
    quality: int
    _drawing: asyncio.Task[bytes] | None = None

    async def jpeg(self) -> bytes:
        if self._drawing is None:
            self._drawing = asyncio.create_task(asyncio.to_thread(self._drawn), name="annotated")
        return await asyncio.shield(self._drawing)

    def _drawn(self) -> bytes:
        return to_jpeg(annotate(self.image, self.found, self.target, width_px=self.width_px), self.quality)


def annotate(image: RgbImage, detections: Sequence[Detection], target: Target | None, *, width_px: int = 0) -> RgbImage:
    """A copy scaled to `width_px` (0 = as it is) with boxes, and the status line added below the picture."""
    scale = width_px / image.shape[1] if width_px else 1.0
    size = (max(1, round(image.shape[1] * scale)), max(1, round(image.shape[0] * scale)))
    method = cv2.INTER_LINEAR if scale >= 1 else cv2.INTER_AREA
    canvas = np.full((size[1] + STATUS_HEIGHT_PX, size[0], 3), DARK, np.uint8)
    canvas[: size[1]] = cv2.resize(image, size, interpolation=method)
    wanted = [one for one in detections if target is not None and target.may_be(one.label, one.colour)]
    for one in detections:
        if one not in wanted:
            _box(canvas, one, scale, GREEN, caption(one, is_target=False))
    for one in wanted:
        _box(canvas, one, scale, RED, caption(one, is_target=True))
    cv2.putText(canvas, status_line(target), (6, canvas.shape[0] - 7), FONT, 0.45, WHITE, 1, cv2.LINE_AA)
    return canvas


def status_line(target: Target | None) -> str:
    return f"Looking for: {target.description}" if target is not None else "Waiting for next command..."


def caption(detection: Detection, *, is_target: bool) -> str:
    colour = f"{detection.colour} " if detection.colour else ""
    return f"{'TARGET: ' if is_target else ''}{colour}{detection.label} {detection.confidence:.2f}"


def to_jpeg(image: RgbImage, quality: int) -> bytes:
    """JPEG bytes of an RGB image; `quality` 1..100."""
    done, encoded = cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not done:
        raise ValueError(f"no JPEG can be made of an image of shape {image.shape}")
    return encoded.tobytes()


def _box(canvas: RgbImage, one: Detection, scale: float, colour: tuple[int, int, int], text: str) -> None:
    left, top, right, bottom = (round(value * scale) for value in one.bbox_xyxy)
    cv2.rectangle(canvas, (left, top), (right, bottom), colour, 2)
    (width, height), _ = cv2.getTextSize(text, FONT, 0.42, 1)
    x = max(0, min(left, canvas.shape[1] - width - 4))
    y = max(height + 4, top)
    cv2.rectangle(canvas, (x, y - height - 5), (x + width + 4, y), colour, cv2.FILLED)
    cv2.putText(canvas, text, (x + 2, y - 3), FONT, 0.42, WHITE, 1, cv2.LINE_AA)
