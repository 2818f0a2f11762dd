"""Training images put together and disturbed: mosaics of four, scaling, mirroring, light."""

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

Image = npt.NDArray[np.uint8]
Labels = npt.NDArray[np.float32]
"""(n, 5): class number, x_min, y_min, x_max, y_max in pixels."""

GREY = 114
KEPT_AREA_MIN = 0.3
SHORT_SIDE_MIN_PX = 4.0


@dataclass(frozen=True)
class Sample:
    """An RGB image (h, w, 3) and its labels."""

    image: Image
    labels: Labels


class Picker:
    """Draws samples, and in them a label to aim at, rare kinds more often than their number alone would give."""

    def __init__(self, samples: list[Sample]) -> None:
        self._samples = samples
        self._of_kind: dict[int, list[tuple[int, int]]] = {}
        for index, sample in enumerate(samples):
            for row, kind in enumerate(sample.labels[:, 0].astype(int).tolist()):
                self._of_kind.setdefault(kind, []).append((index, row))
        self._kinds = sorted(self._of_kind)
        chances = np.array([len(self._of_kind[kind]) ** 0.5 for kind in self._kinds])
        self._chances = chances / chances.sum() if self._kinds else chances

    def draw(self, aim_share: float, rng: np.random.Generator) -> tuple[Sample, int | None]:
        """A sample and the row of the label to aim at; without a row it is any sample, to be shown anyhow."""
        if not self._kinds or rng.random() >= aim_share:
            return self._samples[int(rng.integers(len(self._samples)))], None
        places = self._of_kind[self._kinds[int(rng.choice(len(self._kinds), p=self._chances))]]
        index, row = places[int(rng.integers(len(places)))]
        return self._samples[index], row


def compose(picker: Picker, size_px: int, mosaic_share: float, aim_share: float, rng: np.random.Generator) -> Sample:
    """One training sample of `size_px`: one picture, or a mosaic of four windows into as many pictures."""
    if rng.random() < mosaic_share:
        sample = _mosaic([picker.draw(aim_share, rng) for _ in range(4)], size_px, rng)
    else:
        sample = _single(*picker.draw(aim_share, rng), size_px, rng)
    if rng.random() < 0.5:
        sample = _mirrored(sample)
    return Sample(_relit(sample.image, rng), sample.labels)


def _single(sample: Sample, row: int | None, size_px: int, rng: np.random.Generator) -> Sample:
    scale = size_px / sample.image.shape[0] * float(np.exp(rng.uniform(np.log(0.8), np.log(1.45))))
    canvas = np.full((size_px, size_px, 3), GREY, np.uint8)
    labels = _paste(canvas, (0, 0, size_px, size_px), sample, row, scale, rng)
    return Sample(canvas, labels)


def _mosaic(picked: list[tuple[Sample, int | None]], size_px: int, rng: np.random.Generator) -> Sample:
    canvas = np.full((size_px, size_px, 3), GREY, np.uint8)
    x, y = (int(v) for v in rng.uniform(0.35, 0.65, 2) * size_px)
    tiles = [(0, 0, x, y), (x, 0, size_px, y), (0, y, x, size_px), (x, y, size_px, size_px)]
    parts: list[Labels] = []
    for (sample, row), tile in zip(picked, tiles, strict=True):
        scale = size_px / sample.image.shape[0] * float(rng.uniform(0.7, 1.4))
        if row is not None:  # something larger than its tile is shown smaller, so that most of it can be seen
            longest_px = float((sample.labels[row, 3:5] - sample.labels[row, 1:3]).max())
            scale = min(scale, min(tile[2] - tile[0], tile[3] - tile[1]) / longest_px * float(rng.uniform(0.8, 1.4)))
        parts.append(_paste(canvas, tile, sample, row, scale, rng))
    return Sample(canvas, np.concatenate(parts))


def _paste(
    canvas: Image, tile: tuple[int, int, int, int], sample: Sample, row: int | None, scale: float,
    rng: np.random.Generator,
) -> Labels:  # fmt: skip
    """Scale the sample and show a part of it in the tile, around the label in `row` if given; labels follow."""
    left, top, right, bottom = tile
    side_px = max(1, round(sample.image.shape[0] * scale))
    method = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    scaled = cv2.resize(sample.image, (side_px, side_px), interpolation=method)
    middle = (sample.labels[row, 1:3] + sample.labels[row, 3:5]) / 2 * scale if row is not None else (None, None)
    x, x_from, width = _place(side_px, right - left, middle[0], rng)
    y, y_from, height = _place(side_px, bottom - top, middle[1], rng)
    canvas[top + y : top + y + height, left + x : left + x + width] = scaled[
        y_from : y_from + height, x_from : x_from + width
    ]
    shift = (left + x - x_from, top + y - y_from)
    window = (left + x, top + y, left + x + width, top + y + height)
    return clip_labels(_moved(sample.labels, scale, shift), window)


def _place(side_px: int, room_px: int, middle_px: float | None, rng: np.random.Generator) -> tuple[int, int, int]:
    """Offset in the room, offset in the image, and length shown, along one axis."""
    if side_px <= room_px:
        return int(rng.integers(room_px - side_px + 1)), 0, side_px
    if middle_px is None:
        return 0, int(rng.integers(side_px - room_px + 1)), room_px
    wanted = middle_px - room_px * (0.5 + rng.uniform(-0.4, 0.4))
    return 0, int(np.clip(wanted, 0, side_px - room_px)), room_px


def _moved(labels: Labels, scale: float, shift: tuple[int, int]) -> Labels:
    moved = labels.copy()
    moved[:, 1:] = moved[:, 1:] * scale + np.array([*shift, *shift], np.float32)
    return moved


def clip_labels(labels: Labels, window: tuple[int, int, int, int]) -> Labels:
    """Labels cut to the window; those of which too little is left are dropped."""
    cut = labels.copy()
    cut[:, [1, 3]] = cut[:, [1, 3]].clip(window[0], window[2])
    cut[:, [2, 4]] = cut[:, [2, 4]].clip(window[1], window[3])
    sides, before = cut[:, 3:5] - cut[:, 1:3], labels[:, 3:5] - labels[:, 1:3]
    enough = sides.prod(axis=1) >= KEPT_AREA_MIN * before.prod(axis=1)
    return cut[enough & (sides.min(axis=1, initial=1e9) >= SHORT_SIDE_MIN_PX)]


def _mirrored(sample: Sample) -> Sample:
    labels = sample.labels.copy()
    labels[:, [1, 3]] = sample.image.shape[1] - labels[:, [3, 1]]
    return Sample(np.ascontiguousarray(sample.image[:, ::-1]), labels)


def _relit(image: Image, rng: np.random.Generator) -> Image:
    """Another brightness, contrast and warmth, by one look-up table a channel."""
    levels = np.arange(256, dtype=np.float32)
    contrast, brightness = rng.uniform(0.75, 1.25), rng.normal(0, 12)
    table = np.empty((256, 1, 3), np.uint8)
    for channel in range(3):
        gain = contrast * rng.uniform(0.93, 1.07)
        table[:, 0, channel] = np.clip((levels - 118) * gain + 118 + brightness, 0, 255).astype(np.uint8)
    return cv2.LUT(image, table)
