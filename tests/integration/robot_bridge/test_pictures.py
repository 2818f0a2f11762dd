"""Pictures in every encoding that OpenCV converts, raw and compressed, show what the camera saw."""

import struct
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from sensor_msgs.msg import CompressedImage, Image

from robot_bridge.adapters.ros import convert
from robot_bridge.adapters.ros.subscriptions import image_type
from robot_bridge.settings import Channel
from support.ros_messages import camera_info, compressed, depth, picture

WIDTH, HEIGHT = 64, 48
BGR = np.full((HEIGHT, WIDTH, 3), (40, 90, 200), np.uint8)
"""A red wall."""
GREY = cv2.cvtColor(BGR, cv2.COLOR_BGR2GRAY)


def packed(encoding: str) -> NDArray[Any]:
    """The rows of the red wall as a camera with this encoding sends them."""
    i420 = cv2.cvtColor(BGR, cv2.COLOR_BGR2YUV_I420)
    luma, chroma = i420[:HEIGHT], i420[HEIGHT:].reshape(2, -1)
    y, u, v = luma[0, 0], chroma[0, 0], chroma[1, 0]
    cells = {"r": BGR[0, 0, 2], "g": BGR[0, 0, 1], "b": BGR[0, 0, 0]}

    def bayer(pattern: str, kind: str, factor: int) -> NDArray[Any]:
        tile = np.array([cells[one] for one in pattern], kind).reshape(2, 2) * factor
        return np.tile(tile, (HEIGHT // 2, WIDTH // 2))

    wide = BGR.astype("<u2") << 8
    alpha = np.full((HEIGHT, WIDTH, 1), 255, np.uint8)
    made: dict[str, NDArray[Any]] = {
        "bgr8": BGR, "8UC3": BGR, "rgb8": BGR[:, :, ::-1],
        "bgra8": np.dstack([BGR, alpha]), "8UC4": np.dstack([BGR, alpha]), "rgba8": np.dstack([BGR[:, :, ::-1], alpha]),
        "mono8": GREY, "8UC1": GREY, "mono16": GREY.astype("<u2") << 8, "16UC1": GREY.astype("<u2") << 8,
        "bgr16": wide, "rgb16": wide[:, :, ::-1],
        "bgra16": np.dstack([wide, alpha.astype("<u2") << 8]),
        "rgba16": np.dstack([wide[:, :, ::-1], alpha.astype("<u2") << 8]),
        "yuv422": np.tile(np.array([u, y, v, y], np.uint8), (HEIGHT, WIDTH // 2)),
        "uyvy": np.tile(np.array([u, y, v, y], np.uint8), (HEIGHT, WIDTH // 2)),
        "yuv422_yuy2": np.tile(np.array([y, u, y, v], np.uint8), (HEIGHT, WIDTH // 2)),
        "yuyv": np.tile(np.array([y, u, y, v], np.uint8), (HEIGHT, WIDTH // 2)),
        "nv12": np.vstack([luma, chroma.T.reshape(HEIGHT // 2, WIDTH)]),
        "nv21": np.vstack([luma, chroma[::-1].T.reshape(HEIGHT // 2, WIDTH)]),
        "bayer_rggb8": bayer("rggb", "u1", 1), "bayer_bggr8": bayer("bggr", "u1", 1),
        "bayer_gbrg8": bayer("gbrg", "u1", 1), "bayer_grbg8": bayer("grbg", "u1", 1),
        "bayer_rggb16": bayer("rggb", "<u2", 256), "bayer_bggr16": bayer("bggr", "<u2", 256),
        "bayer_gbrg16": bayer("gbrg", "<u2", 256), "bayer_grbg16": bayer("grbg", "<u2", 256),
    }  # fmt: skip
    rows = np.ascontiguousarray(made[encoding])
    return rows.reshape(rows.shape[0], -1)


COLOURED = ["bgr8", "8UC3", "rgb8", "bgra8", "8UC4", "rgba8", "bgr16", "rgb16", "bgra16", "rgba16", "yuv422", "uyvy",
            "yuv422_yuy2", "yuyv", "nv12", "nv21",
            *(f"bayer_{order}{bits}" for order in ("rggb", "bggr", "gbrg", "grbg") for bits in (8, 16))]  # fmt: skip
GREYS = ["mono8", "8UC1", "mono16", "16UC1"]


def seen(message: Image | CompressedImage) -> NDArray[np.uint8]:
    """The pixel in the middle."""
    image = convert.colour_image(message, 1.0)
    assert image.size_px == (WIDTH, HEIGHT)
    return image.pixels[HEIGHT // 2, WIDTH // 2]


@pytest.mark.parametrize("encoding", COLOURED)
def test_a_red_wall_is_red_in_every_encoding(encoding: str) -> None:
    np.testing.assert_allclose(seen(picture(encoding, packed(encoding))), BGR[0, 0], atol=4)


@pytest.mark.parametrize("encoding", GREYS)
def test_a_red_wall_is_grey_in_a_picture_without_colour(encoding: str) -> None:
    np.testing.assert_allclose(seen(picture(encoding, packed(encoding))), [GREY[0, 0]] * 3, atol=1)


@pytest.mark.parametrize("encoding", ["rgb8", "rgb16", "nv12", "yuv422", "bayer_rggb8", "mono16"])
def test_padding_at_the_end_of_each_row_is_cut_off(encoding: str) -> None:
    rows = packed(encoding)
    padded = np.hstack([rows, np.full((rows.shape[0], 8), 255, rows.dtype)])
    expected = seen(picture(encoding, rows))
    np.testing.assert_array_equal(seen(picture(encoding, padded)), expected)


@pytest.mark.parametrize("encoding", ["rgb16", "mono16"])
def test_bytes_may_come_in_the_other_order(encoding: str) -> None:
    rows = packed(encoding)
    message = picture(encoding, rows.astype(">u2"))
    message.is_bigendian = 1
    np.testing.assert_array_equal(seen(message), seen(picture(encoding, rows)))


@pytest.mark.parametrize(("encoding", "width", "height"), [("yuv422", 63, 48), ("nv12", 64, 47), ("nv21", 63, 48)])
def test_formats_whose_pixels_share_their_colour_have_even_sides(encoding: str, width: int, height: int) -> None:
    message = picture(encoding, packed(encoding), width=width, height=height)
    with pytest.raises(ValueError, match=f"no {encoding} picture is {width} x {height} pixels large"):
        convert.colour_image(message, 1.0)


@pytest.mark.parametrize(
    ("format_", "suffix"),
    [("jpeg", ".jpg"), ("rgb8; jpeg compressed bgr8", ".jpg"), ("png", ".png"), ("bgr8; png compressed bgr8", ".png")],
)
def test_a_compressed_picture_is_read_whatever_its_format_is_called(format_: str, suffix: str) -> None:
    np.testing.assert_allclose(seen(compressed(format_, BGR, suffix=suffix)), BGR[0, 0], atol=4)


@pytest.mark.parametrize("data", [b"", b"no picture", b"\xff\xd8\xff\xe0torn"])
def test_a_compressed_picture_that_is_none_is_refused_in_words(data: bytes) -> None:
    message = CompressedImage(format="jpeg")
    message.data = data
    with pytest.raises(ValueError, match="cannot read jpeg: neither a JPEG nor a PNG is in it"):
        convert.colour_image(message, 1.0)


def test_compressed_topics_are_known_by_their_names() -> None:
    names = ("rgb/image_raw", "rgb/image_raw/compressed", "stereo/image_raw/compressedDepth")
    assert [image_type(Channel(name=name)) for name in names] == [Image, CompressedImage, CompressedImage]


HEAD = struct.pack("<iff", 0, 100.0, 1.0)
"""compressed_depth_image_transport's: depth = 100 / (value - 1)."""


def test_compressed_depth_is_millimetres_or_quantised_inverse_metres() -> None:
    whole = np.full((HEIGHT, WIDTH), 1500, np.uint16)
    whole[0, 0] = 0
    for format_, value in (("16UC1; compressedDepth png", 1.5), ("32FC1; compressedDepth png", 100.0 / 1499.0)):
        image = convert.depth_image(compressed(format_, whole, suffix=".png", head=HEAD), 1.0, 20.0)
        assert image.depth_m[5, 5] == pytest.approx(value, rel=1e-5)
        assert not image.depth_m[0, 0] > 0.0


@pytest.mark.parametrize("format_", ["16UC1; compressedDepth rvl", "jpeg", ""])
def test_compressed_depth_of_another_kind_is_refused_in_words(format_: str) -> None:
    with pytest.raises(ValueError, match="as compressed depth"):
        convert.depth_image(compressed(format_, BGR, suffix=".png", head=HEAD), 1.0, 20.0)


def test_a_depth_picture_in_the_other_byte_order_with_padding_and_holes_is_right() -> None:
    values = np.full((HEIGHT, WIDTH + 4), 1500, ">u2")
    values[:, ::3] = 65535
    message = depth()
    message.data, message.step, message.is_bigendian = values.tobytes(), values.shape[1] * 2, 1
    metres = convert.depth_image(message, 1.0, 20.0).depth_m
    assert metres.shape == (HEIGHT, WIDTH)
    assert np.nanmedian(metres) == pytest.approx(1.5)
    assert np.isnan(metres[:, ::3]).all()


@pytest.mark.parametrize(
    ("width", "height", "fits"), [(64, 48, True), (320, 240, True), (640, 360, False), (48, 48, False)]
)
def test_a_camera_info_is_that_of_its_picture_in_any_size_and_of_no_other_cut(
    width: int, height: int, fits: bool
) -> None:
    assert (convert.intrinsics(camera_info()).why_not_of(width, height) == "") == fits
