"""Poses over time, and fixed frames."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from pytransform3d.transformations import pq_from_transform

from contracts.geometry import Point3D, Pose2D
from geometry.poses import compose, inverse, quaternion_xyzw, wrap, yaw_of
from robot_bridge.sensing.transform_buffer import PoseBuffer, TransformBuffer, pq_of
from robot_bridge.sensing.transforms import in_map, matrix, planar, upright

poses = st.builds(
    Pose2D, x=st.floats(-50, 50), y=st.floats(-50, 50), yaw=st.floats(-math.pi, math.pi, exclude_min=True)
)


@given(poses, poses)
def test_a_pose_undone_leaves_nothing(a: Pose2D, b: Pose2D) -> None:
    back = compose(inverse(a), compose(a, b))
    assert math.isclose(back.x, b.x, abs_tol=1e-6)
    assert math.isclose(back.y, b.y, abs_tol=1e-6)
    assert abs(wrap(back.yaw - b.yaw)) < 1e-6


@given(st.floats(-100.0, 100.0))
def test_wrapped_angles_are_the_same_angle_within_half_a_turn(angle: float) -> None:
    assert -math.pi < wrap(angle) <= math.pi
    assert math.isclose(math.cos(wrap(angle)), math.cos(angle), abs_tol=1e-6)


def test_the_pose_between_two_odometry_samples_is_interpolated_across_the_wrap() -> None:
    buffer = PoseBuffer()
    buffer.add_map_to_odom(0.0, Pose2D(x=10.0, y=0.0, yaw=0.0), received_s=0.0)
    buffer.add_odometry(1.0, Pose2D(x=0.0, y=0.0, yaw=3.1))
    buffer.add_odometry(2.0, Pose2D(x=1.0, y=0.0, yaw=-3.1))
    middle = buffer.at(1.5)
    assert middle is not None
    assert (middle.x, abs(middle.yaw)) == (pytest.approx(10.5, abs=0.01), pytest.approx(math.pi))


def test_a_pose_too_far_from_any_sample_is_not_known() -> None:
    buffer = PoseBuffer()
    buffer.add_map_to_odom(0.0, Pose2D(x=0.0, y=0.0, yaw=0.0), received_s=0.0)
    buffer.add_odometry(1.0, Pose2D(x=0.0, y=0.0, yaw=0.0))
    assert buffer.at(1.2) is not None
    assert buffer.at(1.3) is None
    assert buffer.at(0.9) is None


def test_without_a_localiser_there_is_no_pose_in_the_map() -> None:
    buffer = PoseBuffer()
    buffer.add_odometry(1.0, Pose2D(x=0.0, y=0.0, yaw=0.0))
    assert buffer.newest() is None
    assert buffer.age_s(1.0) is None


def test_a_localisers_pose_serves_until_tf_speaks() -> None:
    buffer = PoseBuffer()
    buffer.add_odometry(1.0, Pose2D(x=1.0, y=0.0, yaw=0.0))
    buffer.add_localisation(1.0, Pose2D(x=5.0, y=5.0, yaw=math.pi / 2), received_s=1.0)
    buffer.add_odometry(2.0, Pose2D(x=2.0, y=0.0, yaw=0.0))
    assert (round(buffer.newest().x, 6), round(buffer.newest().y, 6)) == (5.0, 6.0)
    buffer.add_map_to_odom(2.0, Pose2D(x=0.0, y=0.0, yaw=0.0), received_s=2.0)
    buffer.add_localisation(2.0, Pose2D(x=50.0, y=50.0, yaw=0.0), received_s=2.0)
    assert (buffer.newest().x, buffer.newest().y) == (pytest.approx(2.0), pytest.approx(0.0))


HERE, JUMPED = Pose2D(x=0.0, y=0.0, yaw=0.0), Pose2D(x=1.0, y=0.0, yaw=0.0)


def standing(ahead_s: float) -> PoseBuffer:
    """Ten seconds of a standing robot, a correction every tenth, dated ahead; at 9.5 s the localiser jumps 1 m."""
    buffer = PoseBuffer()
    for tenth in range(101):
        now_s = tenth / 10.0
        buffer.add_odometry(now_s, HERE)
        buffer.add_map_to_odom(now_s + ahead_s, JUMPED if now_s >= 9.5 else HERE, received_s=now_s)
    return buffer


@pytest.mark.parametrize("ahead_s", [0.0, 0.2, 1.0, 5.0])
def test_a_jump_of_the_localiser_counts_at_once_for_the_pictures_of_the_last_second(ahead_s: float) -> None:
    buffer = standing(ahead_s)
    for stamp_s in (10.0, 9.6, 9.1):
        assert buffer.at(stamp_s).x == pytest.approx(1.0), stamp_s
    assert buffer.newest().x == pytest.approx(1.0)
    assert buffer.at(8.0).x == pytest.approx(0.0)


def test_of_two_corrections_between_two_odometries_the_newer_counts() -> None:
    buffer = PoseBuffer()
    buffer.add_odometry(1.0, HERE)
    buffer.add_map_to_odom(2.0, HERE, received_s=1.0)
    buffer.add_map_to_odom(2.1, JUMPED, received_s=1.1)
    assert buffer.at(1.0).x == pytest.approx(1.0)


def test_a_correction_that_came_before_the_first_odometry_counts_until_the_next() -> None:
    buffer = PoseBuffer()
    buffer.add_map_to_odom(9.0, JUMPED, received_s=8.0)
    buffer.add_odometry(8.1, HERE)
    assert buffer.at(8.1).x == pytest.approx(1.0)
    buffer.add_map_to_odom(9.2, HERE, received_s=8.2)
    assert buffer.at(8.1).x == pytest.approx(0.0)


def test_a_clock_set_back_starts_a_new_history() -> None:
    buffer = PoseBuffer()
    buffer.add_map_to_odom(0.0, Pose2D(x=0.0, y=0.0, yaw=0.0), received_s=0.0)
    buffer.add_odometry(1000.0, Pose2D(x=1.0, y=0.0, yaw=0.0))
    buffer.add_odometry(5.0, Pose2D(x=2.0, y=0.0, yaw=0.0))
    assert buffer.at(5.0).x == pytest.approx(2.0)


@pytest.mark.parametrize("back_s", [0.2, 3.0, 19.0, 3600.0])
def test_a_clock_set_back_by_little_or_by_much_stops_no_pose(back_s: float) -> None:
    buffer = PoseBuffer()
    buffer.add_map_to_odom(0.0, Pose2D(x=0.0, y=0.0, yaw=0.0), received_s=0.0)
    for tick in range(100):
        buffer.add_odometry(5000.0 + tick * 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0))
    for tick in range(3):
        buffer.add_odometry(5005.0 - back_s + tick * 0.05, Pose2D(x=1.0, y=0.0, yaw=0.0))
    assert buffer.newest().x == pytest.approx(1.0)


def test_one_sample_that_comes_late_changes_nothing() -> None:
    buffer = PoseBuffer()
    buffer.add_map_to_odom(0.0, Pose2D(x=0.0, y=0.0, yaw=0.0), received_s=0.0)
    for stamp_s, x in ((1.0, 0.1), (1.1, 0.2), (1.05, 9.0), (1.15, 0.3), (1.12, 9.0), (1.2, 0.4)):
        buffer.add_odometry(stamp_s, Pose2D(x=x, y=0.0, yaw=0.0))
    assert buffer.newest().x == pytest.approx(0.4)
    assert buffer.at(1.1).x == pytest.approx(0.2)


def test_old_samples_are_forgotten() -> None:
    buffer = PoseBuffer()
    buffer.add_map_to_odom(0.0, Pose2D(x=0.0, y=0.0, yaw=0.0), received_s=0.0)
    for tick in range(20_000):
        buffer.add_odometry(tick * 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0))
    assert len(buffer._odom_to_base) < 1000
    assert buffer.at(990.0) is not None


def test_a_chain_of_fixed_frames_leads_to_the_base_in_any_order_and_from_above() -> None:
    frames = TransformBuffer()
    frames.fix("plate", "camera", matrix((0.0, 0.0, 0.2), (0.0, 0.0, 0.0, 1.0)))
    assert frames.in_base("camera") is None
    frames.fix("base_link", "plate", matrix((0.1, 0.0, 0.0), (0.0, 0.0, 0.5**0.5, 0.5**0.5)))
    frames.fix("base_footprint", "base_link", matrix((0.0, 0.0, 0.05), (0.0, 0.0, 0.0, 1.0)))
    camera = frames.in_base("/camera")
    assert camera is not None
    np.testing.assert_allclose(camera[:3, 3], [0.1, 0.0, 0.2], atol=1e-9)
    assert math.isclose(planar(camera).yaw, math.pi / 2)
    assert frames.in_base("base_footprint")[2, 3] == pytest.approx(-0.05)
    assert frames.in_base("elsewhere") is None


def test_a_loop_of_frames_is_survived() -> None:
    frames = TransformBuffer()
    still = matrix((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    frames.fix("a", "b", still)
    frames.fix("b", "a", still)
    assert frames.in_base("a") is None


@pytest.mark.parametrize("xyzw", [(0.0, 0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 1.0)])
def test_no_rotation_is_refused(xyzw: tuple[float, float, float, float]) -> None:
    with pytest.raises(ValueError, match="not a rotation"):
        matrix((0.0, 0.0, 0.0), xyzw)


def test_a_point_of_the_base_is_placed_in_the_map() -> None:
    point = in_map(Pose2D(x=1.0, y=2.0, yaw=math.pi / 2), Point3D(x=2.0, y=0.0, z=0.3))
    assert (round(point.x, 6), round(point.y, 6), point.z) == (1.0, 4.0, 0.3)


def test_a_camera_on_a_moving_joint_is_where_the_joint_held_it_at_that_time() -> None:
    frames = TransformBuffer()
    frames.fix("head", "camera", matrix((0.1, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    frames.move("base_link", "head", 1.0, upright(Pose2D(x=0.0, y=0.0, yaw=0.0)))
    frames.move("base_link", "head", 2.0, upright(Pose2D(x=0.0, y=0.0, yaw=math.pi / 2)))
    midway = frames.in_base("camera", 1.5)
    assert midway is not None
    np.testing.assert_allclose(midway[:2, 3], [0.1 * math.cos(math.pi / 4), 0.1 * math.sin(math.pi / 4)], atol=1e-9)
    np.testing.assert_allclose(frames.in_base("camera")[:2, 3], [0.0, 0.1], atol=1e-9)
    assert frames.in_base("camera", 0.5) is None
    assert frames.in_base("camera", 9.0) is None
    np.testing.assert_allclose(frames.between("base_link", "camera", 1.0)[:2, 3], [-0.1, 0.0], atol=1e-9)


def test_a_frame_that_changes_its_parent_leaves_the_old_one() -> None:
    frames = TransformBuffer()
    frames.fix("base_link", "camera", matrix((1.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    frames.fix("base_link", "plate", matrix((0.0, 2.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    frames.fix("plate", "camera", matrix((0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    np.testing.assert_allclose(frames.in_base("camera")[:3, 3], [0.0, 3.0, 0.0], atol=1e-9)


def test_a_flood_of_frames_is_bounded() -> None:
    frames = TransformBuffer()
    for number in range(700):
        frames.fix("base_link", f"frame{number}", matrix((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    assert frames.in_base("frame499") is not None
    assert frames.in_base("frame500") is None


@given(st.floats(-math.pi, math.pi))
def test_a_heading_survives_its_way_through_a_quaternion(yaw: float) -> None:
    back = planar(matrix((0.0, 0.0, 0.0), quaternion_xyzw(yaw))).yaw
    assert abs(wrap(back - yaw)) < 1e-9
    assert abs(wrap(yaw_of(*quaternion_xyzw(yaw)) - yaw)) < 1e-9


@given(st.floats(-math.pi, math.pi))
@example(0.0)
@example(math.pi)
@example(-math.pi / 2)
def test_a_pose_on_the_floor_is_kept_to_the_same_bits_as_any_transform(yaw: float) -> None:
    pose = upright(Pose2D(x=1.5, y=-2.25, yaw=yaw))
    assert pq_of(pose).tolist() == pq_from_transform(pose).tolist()


def test_a_tilted_transform_is_kept_too() -> None:
    tilted = matrix((1.0, 2.0, 3.0), (0.1, 0.2, 0.3, 0.9))
    assert pq_of(tilted).tolist() == pq_from_transform(tilted).tolist()
