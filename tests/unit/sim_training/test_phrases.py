"""What the small CLIP is taught to read."""

import random
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pytest

from contracts.colours import Colour
from inference.perception.small_clip import ClipConfig, crop, letterbox, tokenize
from sim.training.phrases import Meaning, compared, phrase, vocabulary
from sim.training.thresholds import calibrate

CONFIG = ClipConfig(name="test", words=("bottle", "blue", "red"), threshold=0.5)


def test_the_vocabulary_reads_every_phrase_it_is_taught() -> None:
    words = set(vocabulary()) | {"qqq"}
    draw = random.Random(0)
    said = {word for _ in range(500) for word in phrase(Meaning("teddy bear", "purple"), draw).split()}
    assert said <= words


def test_a_plain_phrase_is_colour_and_kind() -> None:
    assert Meaning("bottle", "red").plain == "red bottle"
    assert Meaning("bottle").plain == "bottle"


def test_a_kind_that_comes_in_colours_is_told_from_itself_in_every_colour_a_vote_compares() -> None:
    told = compared([Meaning("book", "red"), Meaning("book"), Meaning("clock")])
    assert told == {Meaning("book", colour.value) for colour in Colour}


def test_the_threshold_is_measured_against_colours_a_kind_never_has() -> None:
    """ "pink book" lies nearer to the picture of a red one than "red book" does, and no book of the set is pink."""

    def embed_text(texts: Sequence[str]) -> npt.NDArray[np.float32]:
        return np.array([[1.0, 0.0] if text in {"pink book", "book"} else [0.8, 0.6] for text in texts], np.float32)

    found = calibrate(np.array([[1.0, 0.0]], np.float32), [Meaning("book", "red")], embed_text)
    assert found.colour_accuracy == 0.0


def test_a_word_nobody_knows_becomes_the_unknown_token() -> None:
    assert tokenize(["Red zebra!"], CONFIG)[0, :4].tolist() == [1, 5, 2, CONFIG.end_token]


def test_a_long_text_is_cut_to_the_context() -> None:
    tokens = tokenize(["red " * 50], CONFIG)
    assert tokens.shape == (1, 16)
    assert tokens[0, -1] == CONFIG.end_token


def test_a_letterbox_keeps_proportions_and_fills_with_grey() -> None:
    square = letterbox(np.full((60, 20, 3), 255, np.uint8), 64)
    assert square.shape == (64, 64, 3)
    assert (square[32, 0] == 127).all()
    assert (square[32, 32] == 255).all()


def test_a_crop_outside_the_picture_is_never_empty() -> None:
    assert crop(np.zeros((10, 10, 3), np.uint8), (20, 20, 30, 30)).size > 0


def test_a_perfect_model_gets_a_threshold_that_parts_right_from_wrong() -> None:
    meanings = [Meaning("cup", "red"), Meaning("cup", "blue"), Meaning("bowl", "red")]
    names = [one.plain for one in sorted(set(meanings))]

    def embed_text(texts: object) -> np.ndarray:
        return np.array([np.eye(5, dtype=np.float32)[names.index(t) if t in names else 4] for t in texts])

    found = calibrate(embed_text([one.plain for one in meanings]), meanings, embed_text)
    assert found.colour_accuracy == pytest.approx(1.0)
    assert found.accepted_right == pytest.approx(1.0)
    assert found.accepted_other_colour == pytest.approx(0.0)
