"""The hash of the camera's newest picture: whether the view has changed since the model was asked."""

import asyncio
import io

import numpy as np
from PIL import Image, UnidentifiedImageError

from coordinator.exploration.views import SIDE, view_hash
from coordinator.ports import Camera
from mesh.errors import MeshError


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
    """None for what is no picture, or smaller than the hash needs."""
    try:
        with Image.open(io.BytesIO(jpeg)) as picture:
            pixels = np.asarray(picture.convert("RGB"), np.uint8)
    except (UnidentifiedImageError, OSError, Image.DecompressionBombError):
        return None
    return view_hash(pixels) if min(pixels.shape[:2]) >= SIDE else None
