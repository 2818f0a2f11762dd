"""Procedural textures as PNG bytes; those that follow a home's palette take its colours, the others never change."""

import io
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scipy.ndimage import zoom  # pyright: ignore[reportUnknownVariableType]

from sim.home.shapes import Vec

Array = NDArray[np.float64]


def _png(picture: Array | Image.Image) -> bytes:
    image = picture if isinstance(picture, Image.Image) else Image.fromarray(np.clip(picture, 0, 255).astype(np.uint8))
    buffer = io.BytesIO()
    image.convert("RGB").save(buffer, "png", compress_level=1)
    return buffer.getvalue()


def _noise(rng: np.random.Generator, size: int, stretch: int = 1) -> Array:
    """Fractal noise [size, size] in 0..1; `stretch` > 1 lengthens its grain along x."""
    total = np.zeros((size, size))
    for octave in range(5):
        cells = 2 ** (octave + 2)
        coarse = rng.normal(size=(cells, max(2, cells // stretch)))
        factor = (size / coarse.shape[0], size / coarse.shape[1])
        total += zoom(coarse, factor, order=1, mode="grid-wrap", grid_mode=True)[:size, :size] / 2**octave
    return (total - total.min()) / (total.max() - total.min())


def _cloudy(rgb: Vec, amount: float, seed: int, size: int = 128, stretch: int = 1) -> Array:
    base = np.array(rgb)[None, None] * 255
    return base * (1 + amount * (_noise(np.random.default_rng(seed), size, stretch) - 0.5)[..., None])


@lru_cache(maxsize=64)
def wood(rgb: Vec) -> bytes:
    """Wood grain of a mean colour."""
    return _png(_cloudy(rgb, 0.30, 2, stretch=8))


@lru_cache(maxsize=64)
def planks(rgb: Vec) -> bytes:
    """A plank floor: one repeat holds six boards."""
    rng = np.random.default_rng(5)
    picture = _cloudy(rgb, 0.22, 5, 252, 8)
    for start in range(0, 252, 42):
        picture[start : start + 42] *= rng.uniform(0.92, 1.06)
        picture[start] *= 0.72
        picture[start : start + 42, rng.integers(252)] *= 0.72
    return _png(picture)


@lru_cache(maxsize=64)
def tiles(rgb: Vec) -> bytes:
    """A tiled floor: one repeat holds two by two tiles."""
    picture = _cloudy(rgb, 0.06, 7)
    picture[::64] *= 0.72
    picture[:, ::64] *= 0.72
    return _png(picture)


@lru_cache(maxsize=64)
def carpet(rgb: Vec) -> bytes:
    """A plain woven floor."""
    return _png(_cloudy(rgb, 0.14, 9))


@lru_cache(maxsize=1)
def fabric() -> bytes:
    """Light cloth, to be multiplied with a colour."""
    return _png(_cloudy((0.95, 0.95, 0.95), 0.10, 11))


@lru_cache(maxsize=1)
def fur() -> bytes:
    """Light fur, to be multiplied with a colour."""
    return _png(_cloudy((0.95, 0.95, 0.95), 0.22, 13))


@lru_cache(maxsize=1)
def leaf() -> bytes:
    """A green leaf with a pale midrib."""
    picture = _cloudy((0.20, 0.52, 0.17), 0.45, 15, 64)
    picture[:, 30:34] *= 1.3
    return _png(picture)


@lru_cache(maxsize=1)
def label() -> bytes:
    """A bottle's skin: white, to be multiplied with its colour, with a dark printed label and cap."""
    picture = np.full((128, 64, 3), 255.0)
    picture[58:92] = (236, 228, 206)
    picture[64:72, ::3] *= 0.35
    picture[78:84, 8:56:2] *= 0.5
    return _png(picture)


@lru_cache(maxsize=1)
def screen() -> bytes:
    """A lit screen: a landscape."""
    rows, columns = np.mgrid[:72, :128]
    picture = np.stack([60 + 0.8 * columns, 130 + 0.8 * rows, 235 - 0.6 * rows], axis=-1).astype(float)
    hill = 48 - 14 * np.sin(columns / 21.0)
    picture[rows > hill] = (52, 128, 62)
    picture[(rows - 16) ** 2 + (columns - 98) ** 2 < 90] = (255, 240, 170)
    return _png(picture)


@lru_cache(maxsize=1)
def keys() -> bytes:
    """Light keys on a dark board."""
    picture = np.full((60, 170, 3), 45.0)
    for row in range(4):
        for column in range(13):
            picture[4 + 14 * row : 15 + 14 * row, 2 + 13 * column : 13 + 13 * column] = 225
    picture[46:57, 41:119] = 225
    return _png(picture)


@lru_cache(maxsize=1)
def clock_face() -> bytes:
    """A white clock face with twelve marks, showing ten past ten."""
    image = Image.new("RGB", (160, 160), (250, 250, 248))
    draw = ImageDraw.Draw(image)
    for hour in range(12):
        turn = hour * np.pi / 6
        tip, root = (80 + 72 * np.sin(turn), 80 - 72 * np.cos(turn)), (80 + 58 * np.sin(turn), 80 - 58 * np.cos(turn))
        draw.line([root, tip], fill=(20, 20, 20), width=9 if hour % 3 == 0 else 5)
    for length, width, turn in ((36, 9, -1.0), (54, 6, 1.0)):
        draw.line([(80, 80), (80 + length * np.sin(turn), 80 - length * np.cos(turn))], fill=(15, 15, 15), width=width)
    return _png(image)


@lru_cache(maxsize=1)
def football() -> bytes:
    """Dark spots on white, to be multiplied with a colour."""
    picture = np.full((96, 192, 3), 255.0)
    rows, columns = np.mgrid[:96, :192]
    for row in range(5):
        for column in range(6):
            x = 16 + column * 32 + (row % 2) * 16
            wide = 1 / max(0.35, np.sin(np.pi * (10 + row * 19) / 96))
            picture[((rows - 10 - row * 19) / 6.5) ** 2 + ((columns - x) / (6.5 * wide)) ** 2 < 1] = 40
    return _png(picture)


@lru_cache(maxsize=1)
def basketball() -> bytes:
    """Dark seams on white, to be multiplied with a colour."""
    picture = np.full((96, 192, 3), 255.0)
    picture[46:50] = 35
    for column in range(0, 192, 48):
        picture[:, column : column + 4] = 35
    return _png(picture)


@lru_cache(maxsize=1)
def cover() -> bytes:
    """A book cover: a title block and a picture frame on white, to be multiplied with a colour."""
    image = Image.new("RGB", (72, 96), (255, 255, 255))
    draw = ImageDraw.Draw(image)
    draw.rectangle((3, 3, 68, 92), outline=(170, 170, 170), width=2)
    draw.rectangle((12, 14, 60, 20), fill=(60, 60, 60))
    draw.rectangle((18, 26, 54, 30), fill=(90, 90, 90))
    draw.rectangle((24, 46, 48, 74), outline=(110, 110, 110), width=3)
    return _png(image)


@lru_cache(maxsize=8)
def painting(seed: int) -> bytes:
    """An abstract picture in pale colours for a wall."""
    rng = np.random.default_rng(seed)
    noise = _noise(rng, 64)[..., None]
    low, high = rng.uniform(150, 230, 3), rng.uniform(90, 200, 3)
    return _png(low + (high - low) * noise)
