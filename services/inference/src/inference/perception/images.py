"""Bytes to RGB pixels: only what a camera sends is read, and everything else is refused by name."""

import io
import struct

import numpy as np
from PIL import Image, JpegImagePlugin, PngImagePlugin

from inference.ports import RgbImage
from mesh.errors import TooLargeError, UnprocessableError

SIDE_PX_MAX = 4096
PLUGINS = {b"\xff\xd8\xff": JpegImagePlugin.JpegImageFile, b"\x89PNG\r\n\x1a\n": PngImagePlugin.PngImageFile}
"""First bytes of a file and who reads it."""
ORIENTATION = 0x0112
UPRIGHT = {
    2: Image.Transpose.FLIP_LEFT_RIGHT, 3: Image.Transpose.ROTATE_180, 4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE, 6: Image.Transpose.ROTATE_270, 7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}  # fmt: skip
"""What undoes each EXIF orientation. (`ImageOps.exif_transpose` also rewrites the EXIF, and fails on a damaged one.)"""
PNG_BIT_DEPTH_AT = 24
"""Offset of the bit depth in a PNG's header (PNG specification, IHDR)."""


def decode(data: bytes) -> RgbImage:
    """The (height, width, 3) pixels of a JPEG or PNG, turned upright by its EXIF tag.

    Raises `UnprocessableError` (not an image, truncated, CMYK, 16 bit, animated) or `TooLargeError` (a side over
    4096 px); the size is read before any pixel is decoded, so a decompression bomb costs nothing.
    """
    # The plugins are called directly: ultralytics replaces PIL.Image.open by one that wants to install packages.
    kind = next((plugin for start, plugin in PLUGINS.items() if data.startswith(start)), None)
    if kind is None:
        raise UnprocessableError("the body is neither a JPEG nor a PNG image")
    try:
        image = kind(io.BytesIO(data))
        _refuse_unusual(image, data)
        image.load()
        turn = UPRIGHT.get(image.getexif().get(ORIENTATION, 1))
        upright = image if turn is None else image.transpose(turn)
        return np.asarray(upright if upright.mode == "RGB" else upright.convert("RGB"))
    except (OSError, SyntaxError, ValueError, EOFError, IndexError, struct.error) as error:
        raise UnprocessableError("the image is truncated or damaged") from error


def _refuse_unusual(image: Image.Image, data: bytes) -> None:
    if max(image.size) > SIDE_PX_MAX:
        raise TooLargeError(f"the image is {image.width} x {image.height} px; the limit is {SIDE_PX_MAX} px a side")
    if image.mode in {"CMYK", "YCCK"}:
        raise UnprocessableError("the image is CMYK (for print); send RGB or grey")
    if image.mode.startswith(("I", "F")) or (image.format == "PNG" and data[PNG_BIT_DEPTH_AT] > 8):
        raise UnprocessableError("the image has 16 bits a channel; send 8")
    if getattr(image, "n_frames", 1) > 1:
        raise UnprocessableError("the image is animated; send one frame")
    if image.mode == "P" and image.palette is None:
        raise UnprocessableError("the image has lost its palette")
