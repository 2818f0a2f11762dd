"""Training images: boxes follow what is done to the picture."""

import numpy as np
import pytest

from sim.training.augment import Picker, Sample, clip_labels, compose


def picture_with_a_white_square() -> Sample:
    image = np.zeros((250, 250, 3), np.uint8)
    image[100:150, 60:120] = 255
    return Sample(image, np.array([[39, 60, 100, 120, 150]], np.float32))


@pytest.mark.parametrize("seed", range(12))
def test_a_label_stays_on_its_thing(seed: int) -> None:
    composed = compose(Picker([picture_with_a_white_square()]), 256, 0.5, 0.7, np.random.default_rng(seed))
    bright = composed.image.mean(axis=2) > 190
    inside = np.zeros_like(bright)
    for _, x_min, y_min, x_max, y_max in composed.labels:
        inside[int(y_min) - 1 : int(np.ceil(y_max)) + 1, int(x_min) - 1 : int(np.ceil(x_max)) + 1] = True
    labelled = (bright & inside).sum()
    assert labelled >= 0.95 * inside.sum() * 0.85
    assert composed.image.shape == (256, 256, 3)


def test_a_label_of_which_little_is_left_is_dropped() -> None:
    labels = np.array([[39, 0, 0, 100, 100], [41, 80, 80, 180, 180]], np.float32)
    kept = clip_labels(labels, (0, 0, 100, 100))
    assert kept[:, 0].tolist() == [39]


def test_no_labels_stay_no_labels() -> None:
    assert clip_labels(np.zeros((0, 5), np.float32), (0, 0, 10, 10)).shape == (0, 5)
