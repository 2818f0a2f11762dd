"""The hash of the camera's newest picture: whether the view has changed since the model was asked."""

import asyncio
import io
from typing import Final

import numpy as np
from PIL.JpegImagePlugin import JpegImageFile

from coordinator.exploration.views import SIDE, view_hash
from coordinator.ports import Camera
from mesh.errors import MeshError

SIDE_PX_MAX: Final = 4096
"""Read from the header, before a pixel is decoded."""


class CameraEye:
    """The port `Eye`."""

    def __init__(self, camera: Camera) -> None:
        self._camera = camera

    async def view(self) -> int | None:
        try:
            jpeg = await self._camera.frame()
        except MeshError:
            return None
        return await asyncio.to_thread(hash_of, jpeg)


def hash_of(jpeg: bytes) -> int | None:
    """None for what is no picture, or smaller than the hash needs, or larger than a camera's."""
    try:
        with JpegImageFile(io.BytesIO(jpeg)) as picture:
            if min(picture.size) < SIDE or max(picture.size) > SIDE_PX_MAX:
                return None
            pixels = np.asarray(picture.convert("RGB"), np.uint8)
    except (SyntaxError, OSError, ValueError):  # the first: no JPEG
        return None
    return view_hash(pixels)
