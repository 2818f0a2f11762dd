"""How far what a box shows is."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from contracts.base import SIGMA_M_MAX
from robot_bridge.sensing.depth import core, depths_in_box, localise, measure, near_mode, scaled_box
from robot_bridge.sensing.sensor_readings import Intrinsics
from robot_bridge.sensing.transforms import matrix
from support.described import NOISE

COLOUR = Intrinsics("colour", 250, 250, 100.0, 100.0, 125.0, 125.0)
DEPTH = Intrinsics("depth", 640, 400, 200.0, 200.0, 320.0, 200.0)
OPTICAL = matrix((0.06, 0.0, 0.24), (-0.5, 0.5, -0.5, 0.5))
RANDOM = np.random.default_rng(7)


def noisy(distance_m: float, count: int) -> np.ndarray:
    return RANDOM.normal(distance_m, NOISE.sigma_m(distance_m), count)


def test_a_thing_in_front_of_a_wall_is_measured_though_the_wall_fills_most_of_the_box() -> None:
    measured = near_mode(np.concatenate([noisy(1.0, 300), noisy(2.5, 700)]), NOISE)
    assert measured.distance_m == pytest.approx(1.0, abs=0.02)
    assert measured.spread_m == pytest.approx(0.012, abs=0.01)


def test_a_few_stray_pixels_in_front_are_not_the_thing() -> None:
    measured = near_mode(np.concatenate([noisy(0.4, 20), noisy(1.2, 980)]), NOISE)
    assert measured.distance_m == pytest.approx(1.2, abs=0.02)


def test_too_few_pixels_measure_nothing_and_say_so() -> None:
    measured = near_mode(noisy(1.0, 5), NOISE)
    assert (measured.distance_m, measured.reason) == (None, "too few depth pixels in the box")


@example(2.5, 230)  # a group whose nearest samples alone are enough to be one
@given(st.floats(0.3, 2.8), st.integers(200, 20_000))
def test_a_plain_surface_is_measured_within_its_noise(distance_m: float, count: int) -> None:
    measured = near_mode(np.random.default_rng(count).normal(distance_m, NOISE.sigma_m(distance_m), count), NOISE)
    assert measured.distance_m == pytest.approx(distance_m, abs=0.02 + NOISE.sigma_m(distance_m))


def test_the_depth_pixels_of_a_colour_box_are_found_by_both_cameras_geometry() -> None:
    depth = np.full((400, 640), 3.0, np.float32)
    depth[160:240, 280:360] = 1.0  # colour pixels 105..145
    inside = depths_in_box(depth, (110, 110, 140, 140), COLOUR, DEPTH, None).depths_m
    assert inside.size > 1000
    assert set(np.unique(inside)) == {1.0}
    assert set(np.unique(depths_in_box(depth, (10, 10, 60, 60), COLOUR, DEPTH, None).depths_m)) == {3.0}


def test_cameras_beside_each_other_are_registered_through_their_transform() -> None:
    """A thing straight ahead of the colour camera is seen left of the middle by one 7.5 cm to its right."""
    depth = np.full((400, 640), 3.0, np.float32)
    depth[160:240, 265:345] = 1.0
    to_the_right = matrix((0.075, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    inside = depths_in_box(depth, (110, 110, 135, 140), COLOUR, DEPTH, to_the_right).depths_m
    assert set(np.unique(inside)) == {1.0}


def test_holes_are_no_distance() -> None:
    depth = np.zeros((400, 640), np.float32)
    depth[:, ::2] = np.nan
    found = depths_in_box(depth, (0, 0, 250, 250), COLOUR, DEPTH, None)
    assert (found.depths_m.size, found.holes) == (0, 1.0)


def test_a_distance_no_depth_picture_can_say_is_a_hole() -> None:
    depth = np.full((400, 640), 1e30, np.float32)
    depth[:, :10] = 2.0
    found = depths_in_box(depth, (0, 0, 250, 250), COLOUR, DEPTH, None)
    assert set(np.unique(found.depths_m)) <= {2.0}
    assert measure(found, NOISE).holes == found.holes
    assert NOISE.sigma_m(1e30) == SIGMA_M_MAX


def test_the_share_of_holes_is_told_beside_the_distance() -> None:
    depth = np.full((400, 640), 1.0, np.float32)
    depth[:, ::4] = 0.0
    measured = measure(depths_in_box(depth, (110, 110, 140, 140), COLOUR, DEPTH, None), NOISE)
    assert measured.distance_m == pytest.approx(1.0)
    assert measured.holes == pytest.approx(0.25, abs=0.02)


def test_a_box_no_depth_pixel_shows_has_neither_depth_nor_holes() -> None:
    narrow = Intrinsics("depth", 640, 400, 2000.0, 2000.0, 320.0, 200.0)
    found = measure(depths_in_box(np.ones((400, 640), np.float32), (0, 0, 20, 20), COLOUR, narrow, None), NOISE)
    assert (found.distance_m, found.holes, found.samples) == (None, None, 0)


def test_a_box_keeps_its_place_in_a_picture_of_another_size() -> None:
    assert scaled_box((10, 20, 30, 40), (320, 240), (640, 480)) == (20, 40, 60, 80)
    assert core((100, 100, 200, 200)) == (125, 120, 175, 180)


def test_a_thing_to_the_left_is_to_the_left() -> None:
    place = localise((50, 100, 100, 150), 2.0, COLOUR, OPTICAL)
    assert place.base_point is not None
    assert place.base_point.x == pytest.approx(2.06)
    assert place.base_point.y == pytest.approx(1.0)
    assert place.base_point.z == pytest.approx(0.24)
    assert place.bearing_rad == pytest.approx(math.atan2(1.0, 2.06))
    assert place.distance_m == pytest.approx(math.hypot(2.0, 1.0))


def test_without_a_distance_there_is_still_a_bearing() -> None:
    place = localise((150, 100, 200, 150), None, COLOUR, OPTICAL)
    assert place.base_point is None
    assert place.bearing_rad < 0.0
