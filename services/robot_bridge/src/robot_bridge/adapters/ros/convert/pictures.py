"""Pictures in colour and in depth, raw and compressed, to BGR and to metres."""

import re
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CompressedImage, Image

from robot_bridge.adapters.ros.convert.rows import check_size, rows
from robot_bridge.sensing.sensor_readings import ColourImage, DepthImage

DEPTH_M_MIN = 0.05
"""No depth camera measures nearer: a picture all of which is nearer is in another unit."""
MILLIMETRES_FROM_M = 100.0
"""Half of a picture is not further away than this."""
COMPRESSED_DEPTH_HEADER_BYTES = 12
"""compressed_depth_image_transport puts its ConfigHeader before the PNG: an enum and two floats."""


@dataclass(frozen=True, slots=True)
class Encoding:
    """How the bytes of a picture lie, and what OpenCV makes BGR of them with (none: they are BGR)."""

    channels: int
    conversion: int | None
    bytes_each: int = 1
    rows_a_row: float = 1.0
    """The planes of 4:2:0 formats lie below the picture, half as high as it is."""


ENCODINGS: dict[str, Encoding] = {
    "bgr8": Encoding(3, None),
    "8uc3": Encoding(3, None),
    "rgb8": Encoding(3, cv2.COLOR_RGB2BGR),
    "bgra8": Encoding(4, cv2.COLOR_BGRA2BGR),
    "8uc4": Encoding(4, cv2.COLOR_BGRA2BGR),
    "rgba8": Encoding(4, cv2.COLOR_RGBA2BGR),
    "mono8": Encoding(1, cv2.COLOR_GRAY2BGR),
    "8uc1": Encoding(1, cv2.COLOR_GRAY2BGR),
    "bgr16": Encoding(3, None, 2),
    "16uc3": Encoding(3, None, 2),
    "rgb16": Encoding(3, cv2.COLOR_RGB2BGR, 2),
    "bgra16": Encoding(4, cv2.COLOR_BGRA2BGR, 2),
    "16uc4": Encoding(4, cv2.COLOR_BGRA2BGR, 2),
    "rgba16": Encoding(4, cv2.COLOR_RGBA2BGR, 2),
    "mono16": Encoding(1, cv2.COLOR_GRAY2BGR, 2),
    "16uc1": Encoding(1, cv2.COLOR_GRAY2BGR, 2),
    "yuv422": Encoding(2, cv2.COLOR_YUV2BGR_UYVY),
    "uyvy": Encoding(2, cv2.COLOR_YUV2BGR_UYVY),
    "yuv422_yuy2": Encoding(2, cv2.COLOR_YUV2BGR_YUY2),
    "yuyv": Encoding(2, cv2.COLOR_YUV2BGR_YUY2),
    "nv12": Encoding(1, cv2.COLOR_YUV2BGR_NV12, rows_a_row=1.5),
    "nv21": Encoding(1, cv2.COLOR_YUV2BGR_NV21, rows_a_row=1.5),
    "bayer_rggb8": Encoding(1, cv2.COLOR_BayerRGGB2BGR),
    "bayer_bggr8": Encoding(1, cv2.COLOR_BayerBGGR2BGR),
    "bayer_gbrg8": Encoding(1, cv2.COLOR_BayerGBRG2BGR),
    "bayer_grbg8": Encoding(1, cv2.COLOR_BayerGRBG2BGR),
    "bayer_rggb16": Encoding(1, cv2.COLOR_BayerRGGB2BGR, 2),
    "bayer_bggr16": Encoding(1, cv2.COLOR_BayerBGGR2BGR, 2),
    "bayer_gbrg16": Encoding(1, cv2.COLOR_BayerGBRG2BGR, 2),
    "bayer_grbg16": Encoding(1, cv2.COLOR_BayerGRBG2BGR, 2),
}
"""By sensor_msgs/image_encodings, in small letters, and by the names OpenCV gives to bare bytes."""
EVEN = frozenset({"yuv422", "uyvy", "yuv422_yuy2", "yuyv", "nv12", "nv21"})
"""Two neighbouring pixels share their colour."""
DEPTHS: dict[str, str] = {"16uc1": "u2", "mono16": "u2", "32fc1": "f4", "64fc1": "f8"}
"""Integers are millimetres, fractions are metres (REP-118)."""


def colour_image(message: Image | CompressedImage, at_s: float) -> ColourImage:
    bgr = _decoded(message, cv2.IMREAD_COLOR) if isinstance(message, CompressedImage) else _bgr(message)
    return ColourImage(at_s, message.header.frame_id, bgr)


def depth_image(message: Image | CompressedImage, at_s: float, depth_m_max: float) -> DepthImage:
    """What is further than `depth_m_max` is a hole. Raises `ValueError` where the picture is in another unit."""
    if isinstance(message, CompressedImage):
        values, millimetres = _compressed_depth(message)
    else:
        values, millimetres = _depth(message)
    with np.errstate(invalid="ignore", over="ignore"):
        metres = values.astype(np.float32) * np.float32(0.001 if millimetres else 1.0)
        measured = metres[np.isfinite(metres) & (metres > 0.0)]
        beyond = metres > depth_m_max
    typical_m = float(np.median(measured)) if measured.size else 0.0
    if typical_m > MILLIMETRES_FROM_M:  # integers end at 65.535 m, which says "nothing measured"
        raise ValueError(f"its depths are about {typical_m:g} m: they are millimetres, not metres")
    if measured.size and float(measured.max()) < DEPTH_M_MIN:
        raise ValueError(f"its depths are {measured.max():.3f} m at most: they are in another unit")
    return DepthImage(at_s, message.header.frame_id, np.where(beyond, np.float32(np.nan), metres))


def _bgr(message: Image) -> NDArray[np.uint8]:
    name = message.encoding.lower()
    encoding = ENCODINGS.get(name)
    if encoding is None:
        raise ValueError(f"cannot read {message.encoding or 'an unnamed encoding'} as a colour picture")
    if name in EVEN and (message.width % 2 or (encoding.rows_a_row != 1.0 and message.height % 2)):
        raise ValueError(f"no {message.encoding} picture is {message.width} x {message.height} pixels large")
    dtype = np.dtype(f"{'>' if message.is_bigendian else '<'}u{encoding.bytes_each}")
    pixels = rows(message, dtype, encoding.channels, rows_a_row=encoding.rows_a_row)
    if encoding.bytes_each == 2:
        pixels = (pixels >> 8).astype(np.uint8)
    if encoding.conversion is None:
        return np.asarray(pixels, np.uint8)
    try:
        return np.asarray(cv2.cvtColor(np.ascontiguousarray(pixels), encoding.conversion), np.uint8)
    except cv2.error as error:
        raise ValueError(f"cannot read its {message.width} x {message.height} pixels of {message.encoding}") from error


def _depth(message: Image) -> tuple[NDArray[Any], bool]:
    """Values (height, width), and whether they are millimetres."""
    kind = DEPTHS.get(message.encoding.lower())
    if kind is None:
        raise ValueError(f"cannot read {message.encoding or 'an unnamed encoding'} as depth")
    return rows(message, np.dtype(f"{'>' if message.is_bigendian else '<'}{kind}"), 1)[:, :, 0], kind == "u2"


def _compressed_depth(message: CompressedImage) -> tuple[NDArray[Any], bool]:
    """As compressed_depth_image_transport packs it: millimetres as they are, metres as quantised inverse depths."""
    kind = message.format.lower().partition(";")[0].strip()
    if kind not in {"16uc1", "32fc1"} or "rvl" in re.split(r"\W+", message.format.lower()):
        raise ValueError(f"cannot read {message.format or 'an unnamed format'} as compressed depth")
    raw = bytes(message.data)
    packed = _decoded(message, cv2.IMREAD_UNCHANGED, skip=COMPRESSED_DEPTH_HEADER_BYTES)
    if packed.dtype != np.uint16 or packed.ndim != 2:
        raise ValueError("its compressed depth holds no picture of 16 bits")
    if kind == "16uc1":
        return packed, True
    scale, offset = np.frombuffer(raw, "<f4", count=2, offset=4).astype(np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        metres = scale / (packed.astype(np.float64) - offset)
    return np.where(packed > 0, metres, np.nan), False


def _decoded(message: CompressedImage, flags: int, *, skip: int = 0) -> "NDArray[Any]":
    packed = np.frombuffer(message.data, np.uint8)[skip:]
    try:
        picture = cv2.imdecode(packed, flags) if packed.size else None
    except cv2.error:  # of more pixels than OpenCV takes
        picture = None
    if picture is None:
        raise ValueError(f"cannot read {message.format or 'an unnamed format'}: neither a JPEG nor a PNG is in it")
    check_size(picture.shape[1], picture.shape[0])
    return picture
