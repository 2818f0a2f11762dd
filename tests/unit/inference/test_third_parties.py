"""Other people's numbers and names: what a detector and an image-text model may get wrong costs a box, and no more."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts.coco import COCO_LABELS
from contracts.vision import Detection, Detections
from inference.perception.classes import OLDER_NAMES, label_of
from inference.perception.embeddings import NoEmbeddingError, cosines, embedded
from inference.perception.raw_boxes import Believed, NoBox, Picture, believed

LABELS = dict(enumerate(COCO_LABELS))
PICTURE = Picture(320, 240)
GOOD = (10.0, 20.0, 110.0, 220.0)
BOTTLE = COCO_LABELS.index("bottle")
NAN, INF = math.nan, math.inf


def judged(*rows: tuple[float, float, tuple[float, ...]], boxes_max: int = 100) -> Believed:
    classes, confidences, boxes = ([one[part] for one in rows] for part in range(3))
    return believed(classes, confidences, boxes, labels=LABELS, picture=PICTURE, boxes_max=boxes_max)


@pytest.mark.parametrize(
    ("number", "confidence", "box", "wrong"),
    [
        (BOTTLE, 0.9, (NAN, 20.0, 110.0, 220.0), NoBox.NOT_FINITE),
        (BOTTLE, 0.9, (10.0, 20.0, INF, 220.0), NoBox.NOT_FINITE),
        (BOTTLE, 0.9, (-INF, 20.0, 110.0, 220.0), NoBox.NOT_FINITE),
        (BOTTLE, NAN, GOOD, NoBox.NOT_FINITE),
        (NAN, 0.9, GOOD, NoBox.NOT_FINITE),
        (BOTTLE, 37.0, GOOD, NoBox.CONFIDENCE),
        (BOTTLE, 1.01, GOOD, NoBox.CONFIDENCE),
        (BOTTLE, -0.1, GOOD, NoBox.CONFIDENCE),
        (80, 0.9, GOOD, NoBox.CLASS),
        (-1, 0.9, GOOD, NoBox.CLASS),
        (39.5, 0.9, GOOD, NoBox.CLASS),
        (1e300, 0.9, GOOD, NoBox.CLASS),
        (BOTTLE, 0.9, (110.0, 20.0, 10.0, 220.0), NoBox.EMPTY),
        (BOTTLE, 0.9, (10.0, 220.0, 110.0, 20.0), NoBox.EMPTY),
        (BOTTLE, 0.9, (10.0, 20.0, 10.0, 220.0), NoBox.EMPTY),
        (BOTTLE, 0.9, (10.0, 20.0, 10.001, 220.0), NoBox.EMPTY),
        (BOTTLE, 0.9, (-5.0, 20.0, -1.0, 220.0), NoBox.EMPTY),
        (BOTTLE, 0.9, (10.0, 20.0, 1e9, 220.0), NoBox.OUTSIDE),
        (BOTTLE, 0.9, (-1e308, -1e308, 1e308, 1e308), NoBox.OUTSIDE),
        (BOTTLE, 0.9, (400.0, 20.0, 500.0, 220.0), NoBox.OUTSIDE),
        (BOTTLE, 0.9, (-100.0, 20.0, 110.0, 220.0), NoBox.OUTSIDE),
    ],
)
def test_a_bad_box_costs_itself_alone(number: float, confidence: float, box: tuple[float, ...], wrong: NoBox) -> None:
    found = judged((number, confidence, box), (BOTTLE, 0.5, GOOD))
    assert found.detections == (Detection(label="bottle", confidence=0.5, bbox_xyxy=GOOD),)
    assert found.refused == {wrong: 1}


def test_what_rounding_does_is_forgiven_and_the_best_come_first() -> None:
    found = judged((BOTTLE, 0.4, GOOD), (BOTTLE, 1.0000001, (-2.0, 0.0, 321.5, 240.004)), (0, 0.7, GOOD), boxes_max=2)
    assert [(one.label, one.confidence) for one in found.detections] == [("bottle", 1.0), ("person", 0.7)]
    assert found.detections[0].bbox_xyxy == (0.0, 0.0, 320.0, 240.0)
    assert found.refused == {}


@pytest.mark.parametrize(
    ("classes", "confidences", "boxes"),
    [
        ([0], [0.5], [[1, 2, 3]]),
        ([0], [0.5], [1, 2, 3, 4]),
        ([0, 1], [0.5], [GOOD]),
        ([[0]], [0.5], [GOOD]),
        ([0], [[0.5]], [GOOD]),
        (["bottle"], [0.5], [GOOD]),
        ([0], [0.5], []),
    ],
)
def test_what_has_not_the_shape_of_boxes_is_no_empty_picture(
    classes: object, confidences: object, boxes: object
) -> None:
    with pytest.raises(ValueError, match=r"shapes|convert"):
        believed(classes, confidences, boxes, labels=LABELS, picture=PICTURE, boxes_max=9)


def test_no_boxes_are_no_boxes() -> None:
    nothing = np.zeros((0,)), np.zeros((0,)), np.zeros((0, 4))
    assert believed(*nothing, labels=LABELS, picture=PICTURE, boxes_max=9) == Believed()


NUMBERS = st.floats(width=32) | st.sampled_from((-0.0, 1e308, -1e308)) | st.floats(-10.0, 330.0)


@given(st.lists(st.tuples(NUMBERS, NUMBERS, st.tuples(*[NUMBERS] * 4)), min_size=1, max_size=20))
def test_whatever_a_detector_gives_what_is_left_is_boxes_of_the_picture(
    rows: list[tuple[float, float, tuple[float, ...]]],
) -> None:
    found = judged(*rows)
    assert len(found.detections) + sum(found.refused.values()) == len(rows)
    told = Detections(stamp_s=0.0, image_width_px=320, image_height_px=240, detections=found.detections)
    for one in Detections.model_validate_json(told.model_dump_json()).detections:
        left, top, right, bottom = one.bbox_xyxy
        assert 0.0 <= left < right <= 320.0
        assert 0.0 <= top < bottom <= 240.0
        assert one.label in COCO_LABELS


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("sofa", "couch"),
        ("tvmonitor", "tv"),
        ("TV Monitor", "tv"),
        ("pottedplant", "potted plant"),
        ("diningtable", "dining table"),
        ("aeroplane", "airplane"),
        ("motorbike", "motorcycle"),
        ("Cell_Phone", "cell phone"),
        ("mobile phone", "cell phone"),
        ("hair dryer", "hair drier"),
        ("Bottle", "bottle"),
        ("wine-glass", "wine glass"),
        ("0", None),
        ("class 39", None),
        ("gizmo", None),
        ("", None),
    ],
)
def test_an_older_name_of_a_class_is_a_name_of_it(name: str, label: str | None) -> None:
    assert label_of(name) == label


def test_every_label_names_itself_and_every_older_name_a_label() -> None:
    assert [label_of(label) for label in COCO_LABELS] == list(COCO_LABELS)
    assert set(OLDER_NAMES.values()) <= set(COCO_LABELS)


UNIT = np.eye(3, dtype=np.float32)


@pytest.mark.parametrize("bad", [NAN, INF, 0.0, 5.0, 1e38])
def test_a_row_that_is_no_unit_vector_gives_no_cosine(bad: float) -> None:
    spoiled = UNIT.copy()
    spoiled[1] = bad
    for images, texts in ((spoiled, UNIT), (UNIT, spoiled)):
        with pytest.raises(NoEmbeddingError, match="no unit vectors"):
            cosines(images, texts)


def test_embeddings_of_another_size_or_number_give_none_either() -> None:
    with pytest.raises(NoEmbeddingError, match=r"\(3, 3\) and \(3, 2\)"):
        cosines(UNIT, UNIT[:, :2])
    with pytest.raises(NoEmbeddingError, match="for 2 asked for"):
        embedded(lambda: UNIT, 2)
    with pytest.raises(NoEmbeddingError, match="for 3 asked for"):
        embedded(lambda: UNIT[0], 3)


def test_a_model_that_fails_says_why() -> None:
    def fails() -> np.ndarray:
        raise RuntimeError("out of memory")

    with pytest.raises(NoEmbeddingError, match="out of memory"):
        embedded(fails, 1)
