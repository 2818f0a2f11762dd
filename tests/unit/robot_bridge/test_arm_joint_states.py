"""joint_states as drivers send them."""

import math

from robot_bridge.arm.joint_states import JointStates, read

OURS = ("a", "b")


def test_other_joints_and_what_is_no_number_are_left_out() -> None:
    states = read(
        ("wheel", "a", "b"), (9.0, 1.0, math.nan), (9.0, 0.1, 0.2), (), ours=OURS, before=None, elapsed_s=None
    )
    assert states == JointStates({"a": 1.0}, {"a": 0.1, "b": 0.2}, {})


def test_the_wheels_own_message_says_nothing_of_the_arm() -> None:
    assert read(("wheel",), (9.0,), (), (), ours=OURS, before=None, elapsed_s=None) is None


def test_rates_that_are_not_told_are_the_way_over_the_time() -> None:
    before = JointStates({"a": 1.0}, {}, {})
    states = read(("a", "b"), (1.2, 0.0), (), (), ours=OURS, before=before, elapsed_s=0.1)
    assert states is not None
    assert states.velocities.keys() == {"a"}
    assert math.isclose(states.velocities["a"], 2.0)


def test_without_time_between_there_are_no_rates() -> None:
    before = JointStates({"a": 1.0}, {}, {})
    states = read(("a",), (1.2,), (), (), ours=OURS, before=before, elapsed_s=0.0)
    assert states == JointStates({"a": 1.2}, {}, {})


def test_lists_that_are_too_short_are_taken_as_far_as_they_go() -> None:
    states = read(("a", "b"), (1.0,), (), (0.5,), ours=OURS, before=None, elapsed_s=None)
    assert states == JointStates({"a": 1.0}, {}, {"a": 0.5})
