"""The look round: in steps that fit the camera, or in one slow turn that fits the detector; and what is in the way."""

import math

import pytest

from contracts.geometry import Pose2D
from contracts.mission import MissionState as S
from contracts.mission import Outcome
from contracts.motion import MotionEnd
from contracts.vision import Detection, Detections, Verdict
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core.obstruction import furniture_before, hindrance
from coordinator.core.plain.searching import sweep_speed_rad_s
from support.mission_script import Script, box, rules_of

SLOW = {"scan_rule": "slow_turn"}


def turned_while_looking(script: Script, angle_rad: float, *boxes: Detection) -> None:
    """The robot has turned by so much, and a frame is taken there."""
    pose = script.mission.robot.pose
    assert pose is not None
    script.robot(Pose2D(x=pose.x, y=pose.y, yaw=math.remainder(pose.yaw + angle_rad, math.tau)))
    script.see(*boxes)


def test_the_steps_overlap_in_the_picture_whatever_the_camera_sees() -> None:
    headings = Script(camera_hfov_rad=0.5).begin().mission.search.headings
    step = headings[1] - headings[0]
    assert step <= 0.5 * 0.85
    assert headings[-1] - headings[0] == pytest.approx(math.radians(420), abs=0.001)


def test_a_wide_camera_keeps_the_step_that_was_set() -> None:
    headings = Script(camera_hfov_rad=1.5).begin().mission.search.headings
    assert headings[1] - headings[0] == pytest.approx(0.7331, abs=0.001)


def test_the_slow_turn_shows_every_bearing_to_the_detector_often_enough() -> None:
    rules = rules_of(detector_period_s=0.5, scan_looks_min=3)
    assert rules.camera_hfov_rad / sweep_speed_rad_s(rules) >= 3 * 0.5
    assert sweep_speed_rad_s(rules_of()) == rules_of().scan_speed_rad_s


def test_a_slow_turn_is_one_turn_of_420_degrees_and_then_the_search_goes_on() -> None:
    script = Script(**SLOW).begin()
    assert [turn.angle_rad for turn in script.asked(do.Rotate)] == [pytest.approx(7.3304, abs=0.001)]
    for _ in range(13):
        turned_while_looking(script, 0.6)
    script.feed(ev.MotionEnded(script.last(do.Rotate).call, MotionEnd.COMPLETED, turned_rad=7.33))
    assert script.mission.state is S.MOVING_TO_SCAN
    assert len(script.asked(do.RecordLook)) == 13


def test_a_sighting_ends_the_slow_turn() -> None:
    script = Script(**SLOW).begin()
    turned_while_looking(script, 0.6)
    turned_while_looking(script, 0.6, box())
    assert script.mission.state is S.CENTERING
    assert script.asked(do.StopMotion)


def test_headings_the_slow_turn_saw_nothing_of_are_looked_at_one_by_one() -> None:
    script = Script(**SLOW).begin()
    script.feed(ev.MotionEnded(script.last(do.Rotate).call, MotionEnd.COMPLETED, turned_rad=7.33))
    assert script.mission.state is S.SCANNING
    assert len(script.asked(do.RecordLook)) == 0
    script.see()
    assert script.mission.state is S.SCANNING
    assert len(script.asked(do.Rotate)) == 2
    assert script.last(do.Rotate).angle_rad < 1.0


def test_a_slow_turn_that_is_cut_off_goes_on_where_it_was() -> None:
    script = Script(**SLOW).begin()
    for _ in range(4):
        turned_while_looking(script, 0.6)
    left = script.mission.search.headings
    script.feed(ev.MotionEnded(script.last(do.Rotate).call, MotionEnd.PREEMPTED, turned_rad=2.4)).wait(2.5)
    assert script.last(do.Rotate).angle_rad <= left[-1] - left[0] + 0.01


def frame(*found: Detection) -> Detections:
    return Detections(stamp_s=1.0, image_width_px=320, image_height_px=240, detections=found)


def table(u0: float, u1: float, low: float) -> Detection:
    return Detection(label="dining table", confidence=0.7, bbox_xyxy=(u0, 120.0, u1, low))


def test_the_furniture_that_carries_the_target_is_named() -> None:
    bottle = box(160.0)
    assert furniture_before(frame(bottle, table(20, 300, 220)), bottle.bbox_xyxy) == "dining table"
    assert furniture_before(frame(bottle, table(200, 300, 220)), bottle.bbox_xyxy) == ""
    assert furniture_before(frame(bottle, table(20, 300, 130)), bottle.bbox_xyxy) == ""
    assert furniture_before(frame(bottle, box(160.0, label="cup")), bottle.bbox_xyxy) == ""


@pytest.mark.parametrize(
    ("blocked", "furniture", "text"),
    [
        (True, "dining table", "the table is in the way"),
        (True, "", "something is in the way"),
        (False, "couch", "the couch is in the way"),
        (False, "", "no nearer place can be reached"),
    ],
)
def test_the_reason_for_the_distance_is_in_words(blocked: bool, furniture: str, text: str) -> None:
    assert hindrance(blocked, furniture) == text


def test_a_find_that_the_table_keeps_at_a_distance_says_so() -> None:
    script = Script(alternatives_max=0).begin().centred().measured(1.3, 3).voted(Verdict.YES).arrived(at=18)
    script.see_at(0.94, 1.36, 0.0, table(20, 300, 220))
    script.drove(MotionEnd.BLOCKED, moved=0.1).wait(2.0)
    assert script.mission.outcome is Outcome.FOUND
    assert script.mission.reason.endswith("(as near as the map allows: the table is in the way)")
    assert script.mission.candidate is not None
    assert script.mission.candidate.distance_m == pytest.approx(0.84, abs=0.03)
