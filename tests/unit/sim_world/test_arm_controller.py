"""The simulated arm's controllers behave as ros2_control's do."""

import math

import pytest

from sim.world.arm.controller import GripperController, Outcome, Tolerances, TrajectoryController
from sim.world.arm.trajectory import Knot, Trajectory

JOINTS = ("a", "b")
START = (0.0, 0.0)
LINE = Trajectory(JOINTS, (Knot(1.0, (1.0, -1.0)), Knot(2.0, (1.0, 0.0))))


def test_without_velocities_it_goes_on_straight_lines() -> None:
    assert LINE.at(0.5, START) == (0.5, -0.5)
    assert LINE.at(1.5, START) == (1.0, -0.5)
    assert LINE.at(9.0, START) == (1.0, 0.0)


def test_with_velocities_it_leaves_and_arrives_at_them() -> None:
    cubic = Trajectory(JOINTS, (Knot(2.0, (1.0, 1.0), (0.0, 0.0)),))
    assert cubic.at(1.0, START) == pytest.approx((0.5, 0.5))
    assert cubic.at(0.02, START)[0] < 0.001
    assert 1.0 - cubic.at(1.98, START)[0] < 0.001


def test_a_first_point_at_no_time_is_where_it_jumps_to() -> None:
    assert Trajectory(JOINTS, (Knot(0.0, (0.2, 0.1)),)).at(0.0, START) == (0.2, 0.1)


def test_joints_may_come_in_another_order() -> None:
    turned = Trajectory(("b", "a"), (Knot(1.0, (-1.0, 1.0), (0.1, 0.2)),))
    assert turned.in_order(JOINTS) == Trajectory(JOINTS, (Knot(1.0, (1.0, -1.0), (0.2, 0.1)),))


@pytest.mark.parametrize(
    ("trajectory", "why"),
    [
        (Trajectory(("a",), (Knot(1.0, (1.0,)),)), "not all of a, b"),
        (Trajectory(("a", "a"), (Knot(1.0, (1.0, 1.0)),)), "not all of a, b"),
        (Trajectory(JOINTS, ()), "no point"),
        (Trajectory(JOINTS, (Knot(1.0, (1.0,)),)), "one value for each joint"),
        (Trajectory(JOINTS, (Knot(1.0, (1.0, 1.0), (0.0,)),)), "one value for each joint"),
        (Trajectory(JOINTS, (Knot(1.0, (math.nan, 1.0)),)), "not finite"),
        (Trajectory(JOINTS, (Knot(-1.0, (1.0, 1.0)),)), "do not rise"),
        (Trajectory(JOINTS, (Knot(1.0, (1.0, 1.0)), Knot(1.0, (0.0, 0.0)))), "do not rise"),
    ],
)
def test_what_the_controller_rejects_is_told(trajectory: Trajectory, why: str) -> None:
    assert why in trajectory.why_invalid(JOINTS)


def test_a_trajectory_whose_joints_follow_succeeds() -> None:
    controller = TrajectoryController(START)
    controller.follow(LINE, Tolerances(), now_s=10.0)
    controller.tick(10.5, (0.5, -0.5))
    assert controller.wanted == (0.5, -0.5)
    assert controller.outcome is Outcome.RUNNING
    controller.tick(12.0, (1.0, 0.01))
    assert controller.outcome is Outcome.SUCCEEDED
    assert controller.wanted == (1.0, 0.0)


def test_a_held_trajectory_stays_where_the_joints_were_and_does_not_go_on() -> None:
    controller = TrajectoryController(START)
    controller.follow(LINE, Tolerances(), now_s=0.0)
    controller.hold((0.3, -0.3))
    controller.tick(2.0, (0.3, -0.3))
    assert (controller.wanted, controller.outcome) == ((0.3, -0.3), Outcome.HELD)


def test_holding_what_already_stands_moves_nothing() -> None:
    controller = TrajectoryController(START)
    controller.hold((0.02, 0.02))
    assert (controller.wanted, controller.outcome) == (START, Outcome.IDLE)


def test_a_joint_that_does_not_arrive_ends_it_where_it_stands() -> None:
    controller = TrajectoryController(START)
    controller.follow(LINE, Tolerances(goal_time_s=1.0), now_s=0.0)
    controller.tick(2.5, (0.5, 0.0))
    assert controller.outcome is Outcome.RUNNING
    controller.tick(3.1, (0.5, 0.0))
    assert (controller.wanted, controller.outcome) == ((0.5, 0.0), Outcome.GOAL_TOLERANCE)


def test_a_joint_held_off_its_path_ends_it() -> None:
    controller = TrajectoryController(START)
    controller.follow(LINE, Tolerances(path_rad=(0.2, 0.0)), now_s=0.0)
    controller.tick(0.5, (0.1, -0.5))
    assert controller.outcome is Outcome.PATH_TOLERANCE


def test_a_negative_tolerance_is_none() -> None:
    controller = TrajectoryController(START)
    controller.follow(LINE, Tolerances(goal_rad=(-1.0, -1.0)), now_s=0.0)
    controller.tick(2.0, (0.0, 0.0))
    assert controller.outcome is Outcome.SUCCEEDED


def test_a_jaw_that_arrives_has_succeeded() -> None:
    gripper = GripperController(0.0)
    gripper.grip(0.5, 0.0, now_s=0.0)
    gripper.tick(0.1, 0.2, 2.0)
    assert gripper.outcome is Outcome.RUNNING
    gripper.tick(0.3, 0.49, 0.5)
    assert gripper.outcome is Outcome.SUCCEEDED


def test_a_jaw_that_stalls_says_so_and_presses_on() -> None:
    gripper = GripperController(1.0)
    gripper.grip(0.0, 0.0, now_s=0.0)
    gripper.tick(0.2, 0.4, 1.0)
    gripper.tick(0.8, 0.4, 0.0)
    gripper.hold(0.4)
    assert (gripper.outcome, gripper.wanted) == (Outcome.STALLED, 0.0)


def test_a_jaw_under_way_is_held_where_it_is() -> None:
    gripper = GripperController(1.0)
    gripper.grip(0.0, 0.0, now_s=0.0)
    gripper.hold(0.6)
    assert (gripper.outcome, gripper.wanted) == (Outcome.HELD, 0.6)
