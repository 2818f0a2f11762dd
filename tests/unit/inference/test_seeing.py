"""Colours, boxes, drawing, decoding: the pure parts of seeing."""

import asyncio
import contextlib
import io
import struct
import zlib

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from PIL import Image, ImageOps

from contracts.colours import Colour
from contracts.vision import Detection, Target
from geometry.boxes import iou
from inference.boxes import best_target, meant_box, scaled
from inference.colours import colour_prompts, phrase, pick_colour, with_colour
from inference.language.breaker import Breaker
from inference.perception.annotate import RED, STATUS_HEIGHT_PX, AnnotatedFrame, annotate, caption, status_line, to_jpeg
from inference.perception.images import decode
from mesh.errors import MeshError, TooLargeError, UnprocessableError
from support.inference_fakes import picture

RED_BOTTLE = Target(label="bottle", description="red bottle")


def seen(
    label: str, confidence: float, bbox: tuple[float, float, float, float] = (0, 0, 10, 10), colour: str | None = None
) -> Detection:
    return Detection(label=label, confidence=confidence, bbox_xyxy=bbox, colour=colour)


def encoded(image: Image.Image, kind: str = "PNG", **more: object) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, kind, **more)
    return buffer.getvalue()


def png_header_only(width_px: int, height_px: int, bit_depth: int = 8) -> bytes:
    """A PNG that promises any size in 57 bytes."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width_px, height_px, bit_depth, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")


def test_a_contrast_prompt_differs_in_the_colour_alone() -> None:
    assert with_colour("small red bottle", Colour.RED, "blue") == "small blue bottle"
    assert with_colour("gray cup", Colour.GREY, "red") == "red cup"
    assert with_colour("orange orange", Colour.ORANGE, "green") == "green orange"


def test_prompts_follow_the_models_template() -> None:
    assert phrase("{}", "orange cup") == "orange cup"
    assert phrase("a photo of {}", "orange cup") == "a photo of an orange cup"
    assert colour_prompts("{}", "cup", (Colour.RED, Colour.BLUE)) == ["red cup", "blue cup"]


def test_a_colour_is_believed_only_when_it_leads() -> None:
    colours = tuple(Colour)
    scores = [0.1] * len(colours)
    scores[2], scores[5] = 0.50, 0.46
    assert pick_colour(colours, scores, 0.03) is colours[2]
    assert pick_colour(colours, scores, 0.05) is None
    assert pick_colour((), [], 0.05) is None


def test_the_announced_one_is_of_the_right_colour_where_that_is_known() -> None:
    unsure, blue, red = seen("bottle", 0.9), seen("bottle", 0.95, colour="blue"), seen("bottle", 0.5, colour="red")
    assert best_target([unsure, blue, red], RED_BOTTLE) == red
    assert best_target([unsure, blue], RED_BOTTLE) == unsure
    assert best_target([blue, seen("cup", 0.9, colour="red")], RED_BOTTLE) is None


def test_the_meant_box_overlaps_most_and_else_is_nearest() -> None:
    left, right = seen("bottle", 0.9, (0, 0, 20, 20)), seen("bottle", 0.4, (100, 0, 120, 20))
    cup = seen("cup", 0.9, (60, 0, 80, 20))
    assert meant_box([left, cup, right], RED_BOTTLE, (95, 0, 115, 20)) == right
    assert meant_box([left, cup, right], RED_BOTTLE, (70, 0, 90, 20)) == right
    assert meant_box([left, cup, right], RED_BOTTLE, None) == left
    assert meant_box([cup], RED_BOTTLE, (0, 0, 1, 1)) is None


def test_the_wrong_colour_is_meant_when_nothing_else_is_there() -> None:
    blue = seen("bottle", 0.9, colour="blue")
    assert meant_box([blue], RED_BOTTLE, None) == blue


BOX = st.tuples(*[st.floats(0, 100)] * 2, *[st.floats(0, 100)] * 2).map(
    lambda b: (min(b[0], b[2]), min(b[1], b[3]), max(b[0], b[2]), max(b[1], b[3]))
)


@given(BOX, BOX)
@example((0.0, 0.0, 1e-170, 1e-170), (0.0, 0.0, 1e-170, 1e-170))
def test_overlap_is_symmetric_and_bounded(a: tuple[float, ...], b: tuple[float, ...]) -> None:
    assert iou(a, b) == pytest.approx(iou(b, a))
    assert 0.0 <= iou(a, b) <= 1.0 + 1e-9


def test_boxes_are_brought_back_to_the_frames_pixels() -> None:
    assert scaled(seen("cup", 0.5, (10, 20, 30, 40)), 2.0, 0.5).bbox_xyxy == (20, 10, 60, 20)


def test_the_target_is_drawn_red_and_the_status_line_below() -> None:
    bottle, cup = seen("bottle", 0.9, (20, 40, 60, 90)), seen("cup", 0.8, (70, 40, 90, 90))
    drawn = annotate(picture(width_px=100, height_px=100), [bottle, cup], RED_BOTTLE, width_px=200)
    assert drawn.shape == (200 + STATUS_HEIGHT_PX, 200, 3)
    assert tuple(drawn[150, 40]) == RED
    assert tuple(drawn[150, 140]) != RED
    assert to_jpeg(drawn, 60).startswith(b"\xff\xd8")


async def test_a_frame_is_drawn_once_for_all_who_look() -> None:
    frame = AnnotatedFrame(picture(), (seen("bottle", 0.9, (20, 40, 60, 90)),), RED_BOTTLE, width_px=200, quality=60)
    first, second = await asyncio.gather(frame.jpeg(), frame.jpeg())
    assert first.startswith(b"\xff\xd8")
    assert second is first
    assert await frame.jpeg() is first


def test_nothing_is_red_while_nothing_is_looked_for() -> None:
    drawn = annotate(picture(), [seen("bottle", 0.9, (20, 40, 60, 90))], None)
    assert not (drawn == np.array(RED)).all(axis=2).any()


def test_the_lines_read_as_the_requirement_says() -> None:
    assert status_line(RED_BOTTLE) == "Looking for: red bottle"
    assert status_line(None) == "Waiting for next command..."
    assert caption(seen("bottle", 0.9, colour="red"), is_target=True) == "TARGET: red bottle 0.90"


@pytest.mark.parametrize("mode", ["RGB", "L", "P", "RGBA", "LA", "1"])
def test_every_ordinary_png_becomes_rgb(mode: str) -> None:
    assert decode(encoded(Image.new(mode, (30, 20)))).shape == (20, 30, 3)


def exif(orientation: int) -> Image.Exif:
    told = Image.Exif()
    told[0x0112] = orientation
    told[0x010E] = "held so"
    return told


@pytest.mark.parametrize("kind", ["JPEG", "PNG"])
@pytest.mark.parametrize("orientation", range(10))
def test_an_image_is_turned_upright(orientation: int, kind: str) -> None:
    body = encoded(Image.effect_noise((30, 20), 50.0), kind, exif=exif(orientation))
    upright = ImageOps.exif_transpose(Image.open(io.BytesIO(body))).convert("RGB")
    assert np.array_equal(decode(body), np.asarray(upright))


@pytest.mark.filterwarnings("ignore")  # Pillow warns of what it skips
@pytest.mark.parametrize("at", range(6, 52))
def test_an_image_is_read_whatever_became_of_its_exif(at: int) -> None:
    body = bytearray(encoded(Image.new("RGB", (30, 20)), "JPEG", exif=exif(6)))
    body[body.index(b"Exif") + at] ^= 0x0F
    assert sorted(decode(bytes(body)).shape) == [3, 20, 30]


def without_palette() -> bytes:
    body = encoded(Image.new("P", (8, 8)))
    at = body.index(b"PLTE") - 4
    return body[:at] + body[at + 12 + struct.unpack_from(">I", body, at)[0] :]


@pytest.mark.parametrize(
    ("body", "error", "word"),
    [
        (b"not an image", UnprocessableError, "neither"),
        (encoded(Image.new("RGB", (8, 8)), "GIF"), UnprocessableError, "neither"),
        (encoded(Image.new("RGB", (64, 64)), "JPEG")[:300], UnprocessableError, "truncated"),
        (encoded(Image.effect_noise((64, 64), 50.0))[:900], UnprocessableError, "truncated"),
        (encoded(Image.new("CMYK", (8, 8)), "JPEG"), UnprocessableError, "CMYK"),
        (encoded(Image.new("I;16", (8, 8))), UnprocessableError, "16 bits"),
        (png_header_only(8, 8, bit_depth=16), UnprocessableError, "16 bits"),
        (without_palette(), UnprocessableError, "palette"),
        (png_header_only(5000, 10), TooLargeError, "4096"),
        (png_header_only(60000, 60000), TooLargeError, "4096"),
        (png_header_only(12000, 12000), TooLargeError, "4096"),
        (
            encoded(Image.new("RGB", (8, 8)), save_all=True, append_images=[Image.new("RGB", (8, 8), "red")]),
            UnprocessableError,
            "animated",
        ),
    ],
)
def test_an_image_no_camera_sends_is_refused_by_name(body: bytes, error: type[MeshError], word: str) -> None:
    with pytest.raises(error, match=word):
        decode(body)


SOUND = [
    encoded(Image.new("RGB", (16, 16), "red"), "JPEG"),
    encoded(Image.new("L", (16, 16)), "JPEG", exif=exif(6)),
    *(encoded(Image.new(mode, (16, 16)), exif=exif(8)) for mode in ("RGB", "P", "RGBA", "LA", "1")),
]


@pytest.mark.filterwarnings("ignore")  # Pillow warns of what it skips
@given(st.sampled_from(SOUND), st.binary(max_size=300), st.integers(0, 250))
def test_damaged_bytes_are_a_named_error_or_an_image(good: bytes, noise: bytes, at: int) -> None:
    with contextlib.suppress(MeshError):
        assert decode(good[:at] + noise + good[at + len(noise) :]).shape[2] == 3


def test_a_breaker_leaves_alone_what_failed_and_tries_again_later() -> None:
    breaker = Breaker(retry_after_s=30.0)
    assert breaker.allows(0.0)
    breaker.failed(10.0, "away")
    assert (breaker.allows(39.9), breaker.allows(40.0), breaker.last_error) == (False, True, "away")
    breaker.succeeded()
    assert (breaker.allows(10.0), breaker.last_error) == (True, "")
