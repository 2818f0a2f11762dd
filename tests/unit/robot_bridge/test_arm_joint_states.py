"""joint_states as drivers send them."""

import math

import pytest

from robot_bridge.arm.joint_states import RATE_OVER_S, Joints, JointStates

OURS = ("a", "b")


def test_other_joints_and_what_is_no_number_are_left_out() -> None:
    states = Joints(OURS).read(("wheel", "a", "b"), (9.0, 1.0, math.nan), (9.0, 0.1, 0.2), (), now_s=5.0)
    assert states == JointStates({"a": 1.0}, {"a": 0.1}, {}, {"a": 5.0})


def test_the_wheels_own_message_says_nothing_of_the_arm() -> None:
    assert Joints(OURS).read(("wheel",), (9.0,), (), (), now_s=5.0) is None


def test_rates_that_are_not_told_are_the_way_over_the_time() -> None:
    joints = Joints(OURS)
    joints.read(("a",), (1.0,), (), (), now_s=5.0)
    states = joints.read(("a", "b"), (1.2, 0.0), (), (), now_s=5.1)
    assert states is not None
    assert states.velocities == pytest.approx({"a": 2.0})


def test_a_rate_is_a_joints_own_way_whatever_another_publisher_tells_between() -> None:
    """A driver of the arm and one of the jaw, neither with velocities."""
    joints = Joints(OURS)
    for k in range(10):
        joints.read(("a",), (0.1 * k,), (), (), now_s=0.1 * k)
        states = joints.read(("b",), (0.0,), (), (), now_s=0.1 * k + 0.01)
    assert states is not None
    assert states.velocities == pytest.approx({"a": 1.0, "b": 0.0})
    assert states.positions == pytest.approx({"a": 0.9, "b": 0.0})


@pytest.mark.parametrize("velocities", [(), (0.0,), (0.0, math.nan)])
def test_a_joint_left_out_of_the_velocities_has_a_rate_all_the_same(velocities: tuple[float, ...]) -> None:
    joints = Joints(OURS)
    joints.read(("a", "b"), (0.0, 0.0), velocities, (), now_s=0.0)
    states = joints.read(("a", "b"), (0.0, 0.5), velocities, (), now_s=0.5)
    assert states is not None
    assert states.velocities == pytest.approx({"a": 0.0, "b": 1.0})


def test_a_servos_step_in_no_time_is_no_speed() -> None:
    joints = Joints(OURS)
    joints.read(("a",), (0.0,), (), (), now_s=0.0)
    states = joints.read(("a",), (0.0015,), (), (), now_s=0.001)
    assert states is not None
    assert states.velocities == {}
    states = joints.read(("a",), (0.0015,), (), (), now_s=RATE_OVER_S)
    assert states is not None
    assert abs(states.velocities["a"]) < 0.1


def test_a_joint_that_has_fallen_silent_is_not_among_the_fresh_ones() -> None:
    joints = Joints(OURS)
    joints.read(("a",), (1.0,), (0.1,), (0.2,), now_s=1.0)
    states = joints.read(("b",), (2.0,), (0.0,), (), now_s=2.0)
    assert states is not None
    assert states.since(1.5) == JointStates({"b": 2.0}, {"b": 0.0}, {}, {"b": 2.0})
    assert states.since(0.5) == states
    assert states.since(2.5) is None


def test_lists_that_are_too_short_are_taken_as_far_as_they_go() -> None:
    states = Joints(OURS).read(("a", "b"), (1.0,), (), (0.5,), now_s=0.0)
    assert states == JointStates({"a": 1.0}, {}, {"a": 0.5}, {"a": 0.0})
