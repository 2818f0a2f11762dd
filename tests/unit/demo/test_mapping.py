"""What the mapping tour tells memory of a picture, and which places it tells at all."""

import math

import numpy as np
import pytest

from contracts.geometry import Point3D, Pose2D
from contracts.memory import Observation
from contracts.vision import Detection, Detections
from demo.mapping import TourEyes, agreed, batches
from sim.world.robot import DEPTH_CAMERA, RGB_CAMERA
from sim.world.tour import TourFrame
from sim.world.types import PoseEstimate

THERE = Pose2D(x=2.0, y=1.0, yaw=math.pi / 2)
AWAY_M = 1.5


def frame(depth_m: float) -> TourFrame:
    """A wall across the whole picture; 0: nothing was measured."""
    depths = np.full((DEPTH_CAMERA.height_px, DEPTH_CAMERA.width_px), depth_m, np.float32)
    return TourFrame(PoseEstimate(0.0, THERE, 0.03, 0.03, 0.01), np.zeros((250, 250, 3), np.uint8), depths)


def seen(*boxes: Detection) -> Detections:
    return Detections(stamp_s=1.0, image_width_px=250, image_height_px=250, detections=boxes, model="a detector")


def bottle(x_px: float = 110.0, confidence: float = 0.8) -> Detection:
    return Detection(label="bottle", confidence=confidence, bbox_xyxy=(x_px, 100.0, x_px + 30.0, 150.0))


@pytest.fixture
def eyes() -> TourEyes:
    return TourEyes(RGB_CAMERA, DEPTH_CAMERA)


def test_a_box_is_told_with_the_place_that_its_depth_and_the_robots_pose_give(eyes: TourEyes) -> None:
    (told,) = eyes.observations(frame(AWAY_M), seen(bottle()), 7.0)
    assert (told.pose, told.stamp_s) == (THERE, 7.0)
    assert told.position is not None
    ahead_m = RGB_CAMERA.x_m + AWAY_M - (RGB_CAMERA.x_m - DEPTH_CAMERA.x_m)
    assert (told.position.x, told.position.y) == pytest.approx((THERE.x, THERE.y + ahead_m), abs=0.03)
    assert told.sigma_m == pytest.approx(0.012 * AWAY_M**3.461, rel=0.1)


def test_where_no_depth_was_measured_a_view_is_told(eyes: TourEyes) -> None:
    (told,) = eyes.observations(frame(0.0), seen(bottle()), 7.0)
    assert (told.position, told.sigma_m) == (None, None)


def test_what_memory_would_not_keep_of_a_frame_is_not_told(eyes: TourEyes) -> None:
    person = Detection(label="person", confidence=0.9, bbox_xyxy=(10.0, 10.0, 60.0, 200.0))
    told = eyes.observations(frame(AWAY_M), seen(bottle(), bottle(112.0), person, bottle(20.0, confidence=0.1)), 7.0)
    assert [one.label for one in told] == ["bottle"]


def at(x: float, stamp_s: float, label: str = "bottle") -> Observation:
    return Observation(
        label=label,
        confidence=0.8,
        pose=Pose2D(x=x - 1.5, y=0.0, yaw=0.0),
        stamp_s=stamp_s,
        position=Point3D(x=x, y=0.0, z=0.2),
        sigma_m=0.05,
    )


def placed(*told: Observation) -> list[bool]:
    assert [(one.label, one.pose) for one in agreed(told)] == [(one.label, one.pose) for one in told]
    return [one.position is not None for one in agreed(told)]


def test_a_place_is_told_where_two_pictures_agree_on_it() -> None:
    assert placed(at(3.0, 1.0), at(3.1, 2.0), at(6.0, 3.0)) == [True, True, False]


def test_two_boxes_of_one_picture_do_not_confirm_one_another() -> None:
    assert placed(at(3.0, 1.0), at(3.1, 1.0)) == [False, False]


def test_another_kind_of_thing_there_confirms_nothing() -> None:
    assert placed(at(3.0, 1.0), at(3.0, 2.0, "cup")) == [False, False]


def test_a_place_too_far_off_to_be_measured_confirms_nothing() -> None:
    far = at(3.0, 2.0).model_copy(update={"pose": Pose2D(x=-2.0, y=0.0, yaw=0.0)})
    assert placed(at(3.0, 1.0), far) == [False, False]


def test_all_is_told_in_batches_that_memory_takes() -> None:
    told = [at(3.0, float(k)) for k in range(1201)]
    assert [len(batch.observations) for batch in batches(told)] == [500, 500, 201]
