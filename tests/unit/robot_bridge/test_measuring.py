"""Boxes to metres through the senses: what was taken when, and from where."""

import math
from dataclasses import replace

import numpy as np
import pytest

from contracts.geometry import Pose2D
from contracts.measuring import LocalizeRequest, NotMeasured
from contracts.robot import BoxQuery
from robot_bridge.sensing.object_localizer import LocalizerLimits, ObjectLocalizer
from robot_bridge.sensing.sensor_readings import DepthImage, Intrinsics, SensorReadings
from robot_bridge.sensing.transforms import matrix
from support.described import NOISE
from support.fake_clock import FakeClock

OPTICAL = matrix((0.06, 0.0, 0.24), (-0.5, 0.5, -0.5, 0.5))
STILL = Pose2D(x=0.0, y=0.0, yaw=0.0)


def senses_turning_at(rad_s: float, *, depth_frame: str = "optical") -> SensorReadings:
    """A robot on the spot at the origin, turning; a wall 3 m away, and 1 m ahead of it at time 10 a thing."""
    senses = SensorReadings()
    senses.frames.fix("base_link", "optical", OPTICAL)
    senses.poses.add_map_to_odom(0.0, STILL, received_s=10.0)
    for tick in range(20):
        at_s = 9.5 + tick * 0.05
        senses.poses.add_odometry(at_s, Pose2D(x=0.0, y=0.0, yaw=rad_s * (at_s - 10.0)))
    depth = np.full((400, 640), 3.0, np.float32)
    depth[160:240, 280:360] = 1.0
    image = DepthImage(10.0, depth_frame, depth)
    senses.depth.put(image, 10.0)
    senses.depth_history.add(image)
    senses.rgb_intrinsics.put(Intrinsics("optical", 250, 250, 100.0, 100.0, 125.0, 125.0), 10.0)
    senses.depth_intrinsics.put(Intrinsics(depth_frame, 640, 400, 200.0, 200.0, 320.0, 200.0), 10.0)
    return senses


def measuring(senses: SensorReadings) -> ObjectLocalizer:
    return ObjectLocalizer(senses, FakeClock(10.2), LocalizerLimits(depth_noise=NOISE))


def box(u_px: float, stamp_s: float | None) -> BoxQuery:
    return BoxQuery(
        bbox_xyxy=(u_px - 15.0, 110.0, u_px + 15.0, 140.0), image_width_px=250, image_height_px=250, stamp_s=stamp_s
    )


def boxes(*us_px: float, stamp_s: float | None) -> LocalizeRequest:
    found = tuple((u_px - 15.0, 110.0, u_px + 15.0, 140.0) for u_px in us_px)
    return LocalizeRequest(boxes_xyxy=found, image_width_px=250, image_height_px=250, stamp_s=stamp_s)


async def test_a_depth_image_taken_before_the_robot_turned_is_registered_to_the_picture_taken_after() -> None:
    """0.2 s at 1 rad/s to the left: the thing has moved 0.2 rad to the right in the picture."""
    measure = measuring(senses_turning_at(1.0))
    u_px = 125.0 + 100.0 * math.tan(0.2 * 1.06 / 1.0)
    after = await measure.depth(box(u_px, 10.2))
    assert after.distance_m == pytest.approx(1.0, abs=0.05)
    where_it_was = await measure.depth(box(125.0 - 20.0, 10.2))
    assert where_it_was.distance_m == pytest.approx(3.0, abs=0.2)


async def test_a_thing_stays_where_it_is_in_the_map_while_the_robot_turns() -> None:
    measure = measuring(senses_turning_at(1.0))
    u_px = 125.0 + 100.0 * math.tan(0.2 * 1.06 / 1.0)
    (place,) = (await measure.localize(boxes(u_px, stamp_s=10.2))).measurements
    assert place.map_point is not None
    assert place.map_point.x == pytest.approx(1.06, abs=0.06)
    assert place.map_point.y == pytest.approx(0.0, abs=0.04)
    assert place.bearing_rad is not None
    assert place.bearing_rad == pytest.approx(-0.2, abs=0.03)


async def test_a_picture_too_far_from_any_depth_image_is_not_measured() -> None:
    reply = await measuring(senses_turning_at(0.0)).depth(box(125.0, 9.0))
    assert reply.distance_m is None
    assert "1.0 s away" in reply.reason


async def test_every_box_of_a_picture_is_measured_or_says_why_not() -> None:
    reply = await measuring(senses_turning_at(0.0)).localize(boxes(125.0, 60.0, 900.0, stamp_s=10.0))
    near, wall, outside = reply.measurements
    assert (near.depth_m, wall.depth_m) == (pytest.approx(1.0, abs=0.02), pytest.approx(3.0, abs=0.2))
    assert near.sigma_m == pytest.approx(0.012, abs=0.001)
    assert (outside.cause, outside.distance_m) == (NotMeasured.OUTSIDE_PICTURE, None)


async def test_without_a_depth_image_of_its_time_a_box_has_a_bearing_and_no_distance() -> None:
    (found,) = (await measuring(senses_turning_at(0.0)).localize(boxes(125.0, stamp_s=9.0))).measurements
    assert (found.cause, found.distance_m, found.sigma_m) == (NotMeasured.NO_DEPTH_IMAGE, None, None)
    assert found.bearing_rad == pytest.approx(0.0, abs=0.01)


async def test_a_robot_lost_in_its_map_still_tells_distances() -> None:
    senses = replace(senses_turning_at(0.0), poses=SensorReadings().poses)
    (found,) = (await measuring(senses).localize(boxes(125.0, stamp_s=10.0))).measurements
    assert (found.cause, found.map_point) == (NotMeasured.NO_POSE, None)
    assert found.distance_m == pytest.approx(1.0, abs=0.02)


async def test_two_cameras_at_different_places_are_registered_through_the_tree() -> None:
    senses = senses_turning_at(0.0, depth_frame="right")
    senses.frames.fix("optical", "right", matrix((0.075, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    reply = await measuring(senses).depth(box(125.0 + 7.5, 10.0))
    assert reply.distance_m == pytest.approx(1.0, abs=0.01)
    assert reply.holes == 0.0
