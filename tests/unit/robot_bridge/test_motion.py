"""Turning and driving on odometry, against a base that does what it is told a tick later."""

import math
from typing import Any, TypeVar

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts.geometry import Pose2D, Twist2D
from contracts.motion import DriveReply, MotionEnd, RotateReply
from robot_bridge.motion.motions import GAINS, DriveOnHeading, Ending, Motion, Spin, Tuning
from robot_bridge.sensing.sensor_readings import Odometry


def tuning(**changes: float) -> Tuning:
    return Tuning(GAINS.model_copy(update=changes))


FREE, OBSTACLE = Ending(MotionEnd.HELD_BACK), Ending(MotionEnd.BLOCKED, text="obstacle ahead")
Reply = TypeVar("Reply", RotateReply, DriveReply)


def run(
    motion: Motion[Reply], *, heading: float = 0.0, blocked: bool = False, blind: bool = False
) -> tuple[Reply, float]:
    """The reply, and the heading at rest."""
    x = y = now_s = 0.0
    yaw, sent = heading, Twist2D()
    for _ in range(4000):
        odometry = Odometry(now_s, Pose2D(x=x, y=y, yaw=math.remainder(yaw, math.tau)), sent)
        wanted = motion.step(None if blind else odometry, now_s, sent, OBSTACLE if blocked else FREE)
        x += sent.linear_x * 0.05 * math.cos(yaw)
        y += sent.linear_x * 0.05 * math.sin(yaw)
        yaw += sent.angular_z * 0.05
        if not isinstance(wanted, Twist2D):
            return wanted, yaw - heading
        sent = Twist2D() if blocked else wanted
        now_s += 0.05
    raise AssertionError("it never ended")


@settings(max_examples=60)
@given(st.floats(-7.4, 7.4), st.floats(0.3, 1.9), st.floats(-3.1, 3.1))
def test_any_turn_ends_within_3_degrees_more_than_once_round_too(angle: float, speed: float, heading: float) -> None:
    reply, turned = run(Spin(angle, speed_rad_s=speed, timeout_s=60.0, tuning=tuning()), heading=heading)
    assert reply.end.completed
    assert math.isclose(turned, angle, abs_tol=math.radians(3.0))


@settings(max_examples=40)
@given(st.floats(0.05, 2.0), st.floats(0.05, 0.306), st.floats(-3.1, 3.1))
def test_any_drive_ends_within_2_cm(distance_m: float, speed: float, heading: float) -> None:
    drive = DriveOnHeading(distance_m, speed_m_s=speed, timeout_s=60.0, allow_reverse=False, tuning=tuning())
    reply, turned = run(drive, heading=heading)
    assert reply.end.completed
    assert math.isclose(reply.driven_m, distance_m, abs_tol=0.02)
    assert abs(turned) < 0.01


def test_reversing_a_metre_is_a_metre_back() -> None:
    reply, _ = run(DriveOnHeading(-1.0, speed_m_s=0.2, timeout_s=60.0, allow_reverse=True, tuning=tuning()))
    assert reply.driven_m == pytest.approx(-1.0, abs=0.02)


def test_what_never_moves_is_given_up_with_the_filters_reason() -> None:
    reply, _ = run(
        DriveOnHeading(1.0, speed_m_s=0.2, timeout_s=60.0, allow_reverse=False, tuning=tuning()), blocked=True
    )
    assert (reply.end, reply.text) == (MotionEnd.BLOCKED, "obstacle ahead")


def test_without_odometry_it_is_given_up() -> None:
    reply, _ = run(Spin(1.0, speed_rad_s=1.0, timeout_s=60.0, tuning=tuning()), blind=True)
    assert reply.end is MotionEnd.NO_ODOMETRY


def test_a_turn_too_slow_for_its_time_ends_at_its_time() -> None:
    reply, _ = run(Spin(6.0, speed_rad_s=0.5, timeout_s=2.0, tuning=tuning()))
    assert reply.end is MotionEnd.TIMED_OUT


def first_wish(motion: Motion[Any], now_s: float, yaw: float = 0.0) -> Twist2D:
    wanted = motion.step(Odometry(now_s, Pose2D(x=0.0, y=0.0, yaw=yaw), Twist2D()), now_s, Twist2D(), FREE)
    assert isinstance(wanted, Twist2D)
    return wanted


def test_new_gains_act_on_the_turn_under_way() -> None:
    tuned = tuning()
    turn = Spin(0.4, speed_rad_s=1.9, timeout_s=60.0, tuning=tuned)
    assert first_wish(turn, 0.0).angular_z == pytest.approx(1.0)
    tuned.gains = tuned.gains.model_copy(update={"heading_kp": 1.0})
    assert first_wish(turn, 0.05).angular_z == pytest.approx(0.4)


def test_a_drive_steers_back_to_the_heading_it_began_with() -> None:
    drive = DriveOnHeading(1.0, speed_m_s=0.2, timeout_s=60.0, allow_reverse=False, tuning=tuning())
    assert first_wish(drive, 0.0).angular_z == 0.0
    assert first_wish(drive, 0.05, yaw=0.1).angular_z < -0.2


def test_no_gains_make_it_faster_than_asked() -> None:
    wild = tuning(heading_kp=20.0, heading_ki=20.0, drive_kp=20.0, drive_ki=20.0)
    assert abs(first_wish(Spin(3.0, speed_rad_s=0.5, timeout_s=60.0, tuning=wild), 0.0).angular_z) == 0.5
    drive = DriveOnHeading(1.0, speed_m_s=0.1, timeout_s=60.0, allow_reverse=False, tuning=wild)
    assert first_wish(drive, 0.0).linear_x == pytest.approx(0.1)


def test_a_turn_that_the_base_is_too_sluggish_for_still_ends_near_its_angle() -> None:
    """Odometry three ticks late: what a network and a busy machine make of it."""
    turn = Spin(math.pi, speed_rad_s=1.9, timeout_s=60.0, tuning=tuning())
    yaw, now_s, yaws, sent = 0.0, 0.0, [0.0] * 4, Twist2D()
    while True:
        late = Odometry(now_s, Pose2D(x=0.0, y=0.0, yaw=math.remainder(yaws[-4], math.tau)), sent)
        wanted = turn.step(late, now_s, sent, FREE)
        yaw, now_s = yaw + sent.angular_z * 0.05, now_s + 0.05
        yaws.append(yaw)
        if not isinstance(wanted, Twist2D):
            break
        sent = wanted
    assert wanted.end.completed
    assert yaw == pytest.approx(math.pi, abs=math.radians(3.0))
