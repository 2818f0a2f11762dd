"""JPEG pictures of the newest frame: encoded once each, however many look."""

import asyncio
from collections.abc import AsyncGenerator, Callable
from dataclasses import dataclass

import cv2

from mesh.latest_value import LatestValue, Reading
from robot_bridge.sensing.sensor_readings import ColourImage

BOUNDARY = "frame"


@dataclass(frozen=True, slots=True)
class Picture:
    stamp_s: float
    width_px: int
    height_px: int
    jpeg: bytes


class Camera:
    """Encodes lazily and off the event loop; one picture is kept, and one encoding is shared by all who wait for it."""

    def __init__(self, frames: LatestValue[ColourImage], *, jpeg_quality: int) -> None:
        self._frames = frames
        self._quality = jpeg_quality
        self._of: ColourImage | None = None
        self._encoding: asyncio.Task[Picture] | None = None
        self.viewers = 0
        self.encoded = 0

    async def picture(self, *, after_s: float | None, wait_s: float) -> Picture | None:
        """The newest picture stamped later than `after_s`; none when none comes within `wait_s`."""

        def wanted(reading: Reading[ColourImage]) -> bool:
            return after_s is None or reading.value.stamp_s > after_s + 1e-6

        reading = await self._frames.wait_for(wanted, wait_s)
        return await self._encoded(reading.value) if reading is not None else None

    async def stream(self) -> AsyncGenerator[bytes]:
        """MJPEG parts, for as long as the viewer stays; a slow one skips frames."""
        self.viewers += 1
        try:
            shown: Reading[ColourImage] | None = None
            while True:
                reading = await self._frames.wait_for(_other_than(shown), 5.0)
                if reading is None:
                    continue
                shown = reading
                picture = await self._encoded(reading.value)
                head = f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(picture.jpeg)}\r\n"
                yield head.encode() + f"X-Stamp-S: {picture.stamp_s:.6f}\r\n\r\n".encode() + picture.jpeg + b"\r\n"
        finally:
            self.viewers -= 1

    async def _encoded(self, image: ColourImage) -> Picture:
        if self._of is not image or self._encoding is None:
            self._of = image
            self._encoding = asyncio.create_task(asyncio.to_thread(self._encode, image), name="jpeg")
        return await asyncio.shield(self._encoding)

    def _encode(self, image: ColourImage) -> Picture:
        encoded = cv2.imencode(".jpg", image.pixels, [cv2.IMWRITE_JPEG_QUALITY, self._quality])[1]
        self.encoded += 1
        height_px, width_px = image.pixels.shape[:2]
        return Picture(image.stamp_s, width_px, height_px, encoded.tobytes())


def _other_than(shown: Reading[ColourImage] | None) -> Callable[[Reading[ColourImage]], bool]:
    """By which came, not by its stamp: what came later is newer."""
    return lambda newest: newest is not shown
