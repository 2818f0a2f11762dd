"""Boxes over the live picture."""

import math

import pytest

from contracts.geometry import Pose2D
from contracts.vision import Detection, Detections, Target
from ui.overlay import CameraFrame, boxes

HERE = Pose2D(x=0.0, y=0.0, yaw=0.0)
RED_BOTTLE = Target(label="bottle", description="red bottle")


def frame(pose: Pose2D | None = HERE, stamp_s: float = 10.0) -> CameraFrame:
    return CameraFrame(stamp_s, b"", 250, 250, pose)


def seen(*detections: Detection, pose: Pose2D | None = HERE) -> Detections:
    return Detections(stamp_s=9.6, image_width_px=250, image_height_px=250, pose=pose, detections=detections)


def bottle(colour: str | None = None, confidence: float = 0.8) -> Detection:
    return Detection(label="bottle", confidence=confidence, bbox_xyxy=(25.0, 50.0, 50.0, 100.0), colour=colour)


def test_a_box_is_in_fractions_of_the_picture_with_its_words() -> None:
    (box,) = boxes(frame(), seen(bottle("red")), None)
    assert box == {"at": [0.1, 0.2, 0.2, 0.4], "text": "red bottle 0.80", "target": False}


@pytest.mark.parametrize(("colour", "wanted"), [("red", True), (None, True), ("green", False)])
def test_the_target_is_its_class_in_no_other_colour(colour: str | None, wanted: bool) -> None:
    (box,) = boxes(frame(), seen(bottle(colour)), RED_BOTTLE)
    assert box["target"] is wanted
    assert box["text"].startswith("TARGET: ") is wanted


def test_the_target_is_drawn_last() -> None:
    drawn = boxes(frame(), seen(bottle("red", 0.9), bottle("green", 0.3)), RED_BOTTLE)
    assert [box["target"] for box in drawn] == [False, True]


@pytest.mark.parametrize(
    "now",
    [
        frame(Pose2D(x=0.0, y=0.0, yaw=math.radians(10.0))),
        frame(Pose2D(x=0.3, y=0.0, yaw=0.0)),
        frame(stamp_s=12.0),
    ],
)
def test_boxes_of_another_view_are_not_drawn(now: CameraFrame) -> None:
    assert boxes(now, seen(bottle()), None) == []


def test_a_robot_that_does_not_know_where_it_is_still_shows_what_it_sees() -> None:
    assert len(boxes(frame(None), seen(bottle(), pose=None), None)) == 1


def test_nothing_seen_is_nothing_drawn() -> None:
    assert boxes(frame(), None, RED_BOTTLE) == []
