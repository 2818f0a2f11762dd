"""What a trajectory makes the joints do is known before they do it."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from contracts.arm import ArmRefusal, ArmTrajectoryRequest, TrajectoryPoint
from robot_bridge.arm.models import MODELS, SO101, ArmModel
from robot_bridge.arm.trajectories import Refused, between, home, why_refused

NOW = SO101.home_rad
UP = (0.0, -1.0, 1.0, 0.0, 0.0)
STILL = (0.0,) * 5
angle = st.floats(-3.0, 3.0)
rate = st.floats(-4.0, 4.0)


def request(*points: TrajectoryPoint, joints: tuple[str, ...] = SO101.names) -> ArmTrajectoryRequest:
    return ArmTrajectoryRequest(joints=joints, points=points, epoch=1)


def point(time_s: float, positions: tuple[float, ...], velocities: tuple[float, ...] = ()) -> TrajectoryPoint:
    return TrajectoryPoint(time_s=time_s, positions_rad=positions, velocities_rad_s=velocities)


def refusal(*points: TrajectoryPoint, joints: tuple[str, ...] = SO101.names, fastest: float = 2.0) -> Refused | None:
    return why_refused(request(*points, joints=joints), SO101, NOW, speed_rad_s_max=fastest)


def code(*points: TrajectoryPoint, joints: tuple[str, ...] = SO101.names, fastest: float = 2.0) -> ArmRefusal | None:
    refused = refusal(*points, joints=joints, fastest=fastest)
    return refused.code if refused is not None else None


def test_what_keeps_to_range_and_speed_may_be_driven() -> None:
    assert refusal(point(2.0, UP, STILL), point(4.0, NOW, STILL)) is None
    assert refusal(point(2.0, UP)) is None


def test_joints_may_come_in_any_order_and_each_is_judged_by_its_own_range() -> None:
    turned = tuple(reversed(SO101.names))
    wrist_far_over = (2.8, 0.0, 1.0, -1.0, 0.0)
    assert refusal(point(4.0, wrist_far_over), joints=turned) is None
    assert code(point(4.0, tuple(reversed(wrist_far_over))), joints=turned) is ArmRefusal.OUT_OF_LIMITS


@pytest.mark.parametrize("joints", [SO101.names[:4], (*SO101.names[:4], "elbow"), (SO101.names[0],) * 5])
def test_each_joint_is_to_be_named_once(joints: tuple[str, ...]) -> None:
    assert code(point(2.0, UP), joints=joints) is ArmRefusal.WRONG_JOINTS


def test_a_point_has_a_value_for_each_joint() -> None:
    assert code(point(2.0, UP[:4])) is ArmRefusal.BAD_POINT
    assert code(point(2.0, UP, (0.0,))) is ArmRefusal.BAD_POINT


def test_times_rise() -> None:
    assert code(point(2.0, UP), point(2.0, NOW)) is ArmRefusal.BAD_TIMES
    assert code(point(2.0, UP), point(2.0 + 1e-9, UP)) is ArmRefusal.BAD_TIMES
    assert refusal(*(point(2.0 + k / 1000, UP) for k in range(20))) is None


def test_it_ends_at_rest() -> None:
    onwards = (0.0, 0.0, 0.0, 0.5, 0.0)
    assert code(point(4.0, UP, onwards)) is ArmRefusal.ENDS_MOVING
    assert refusal(point(4.0, UP, onwards), point(6.0, UP, STILL)) is None


@pytest.mark.parametrize(
    "cubic",
    [
        (0.5, 0.5, 1e308, 1e308, 10.0),
        (0.5, 0.5, 1e308, -1e308, 10.0),
        (0.0, 1.5, 0.0, 0.0, 1e-310),
        (1e308, -1e308, 0.0, 0.0, 1.0),
        (0.0, math.nan, 0.0, 0.0, 1.0),
    ],
)
def test_what_is_too_large_to_reckon_with_is_too_fast(cubic: tuple[float, float, float, float, float]) -> None:
    found = between(*cubic)
    assert not math.isnan(found.lowest_rad)
    assert not math.isnan(found.highest_rad)
    assert found.fastest_rad_s == math.inf


@pytest.mark.parametrize(
    "wrong",
    [
        {"time_s": 1e-310},
        {"time_s": 0.0009},
        {"velocities_rad_s": (1e308,) * 5},
        {"velocities_rad_s": (-50.1,) * 5},
        {"positions_rad": (1e308,) * 5},
    ],
)
def test_what_no_arm_can_do_is_no_point(wrong: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        TrajectoryPoint.model_validate({"time_s": 10.0, "positions_rad": UP} | wrong)


def test_a_point_outside_the_range_is_refused_with_the_joint_and_the_angle() -> None:
    refused = refusal(point(9.0, (0.0, -1.9, 1.0, 0.0, 0.0)))
    assert refused is not None
    assert refused.code is ArmRefusal.OUT_OF_LIMITS
    assert "shoulder_lift would be at -1.900 rad, outside -1.74 to 1.74 rad" in refused.text


def test_a_cubic_that_leaves_the_range_between_two_good_points_is_refused() -> None:
    """It arrives at the edge of the range with a speed that carries it over, and comes back."""
    edge = (0.0, -1.7, 1.3, 1.6, 0.0)
    onwards, back = (0.0, 0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, -1.0, 0.0)
    assert refusal(point(6.0, edge, STILL)) is None
    over = (point(6.0, edge, onwards), point(8.0, edge, back), point(14.0, NOW, STILL))
    assert code(*over) is ArmRefusal.OUT_OF_LIMITS


def test_the_way_from_where_the_joints_are_counts_too() -> None:
    assert code(point(0.5, UP)) is ArmRefusal.JOINT_TOO_FAST


def test_a_cubics_speed_is_its_peak_and_not_its_mean() -> None:
    """From rest to rest a cubic's peak is 1.5 times its mean: 1.5 rad in 1 s."""
    assert refusal(point(1.0, (1.0, *NOW[1:]), STILL), fastest=1.51) is None
    assert code(point(1.0, (1.0, *NOW[1:]), STILL), fastest=1.45) is ArmRefusal.JOINT_TOO_FAST


def test_the_settings_limit_and_the_joints_own_both_hold() -> None:
    slow = point(2.0, (1.0, *NOW[1:]))
    assert code(slow, fastest=0.4) is ArmRefusal.JOINT_TOO_FAST
    assert code(point(0.4, (1.0, *NOW[1:])), fastest=99.0) is ArmRefusal.JOINT_TOO_FAST


def test_out_of_a_place_outside_the_range_it_may_come_back() -> None:
    beyond = (0.0, -1.76, 1.3, -1.5, 0.0)
    back = request(point(2.0, NOW, STILL))
    assert why_refused(back, SO101, beyond, speed_rad_s_max=2.0) is None


@pytest.mark.parametrize("lift", [-1.75, -1.9, 2.0])
def test_home_may_be_driven_from_outside_the_range(lift: float) -> None:
    beyond = (0.0, lift, 1.3, -1.5, 0.0)
    way = request(*home(SO101, beyond, speed_rad_s_max=0.5))
    assert why_refused(way, SO101, beyond, speed_rad_s_max=0.5) is None


def test_outside_the_range_no_joint_goes_farther_out() -> None:
    beyond = (0.0, -1.8, 1.3, -1.5, 0.0)
    for points in (
        (point(5.0, (0.0, -1.81, 1.3, -1.5, 0.0)),),
        (point(5.0, (0.0, -1.77, 1.3, -1.5, 0.0)), point(9.0, (0.0, -1.79, 1.3, -1.5, 0.0))),
    ):
        refused = why_refused(request(*points), SO101, beyond, speed_rad_s_max=2.0)
        assert refused is not None
        assert refused.code is ArmRefusal.OUT_OF_LIMITS


@given(angle, angle, rate, rate, st.floats(0.05, 5.0))
def test_no_sample_of_a_cubic_lies_beyond_its_extremes(
    one: float, other: float, v_one: float, v_other: float, span_s: float
) -> None:
    found = between(one, other, v_one, v_other, span_s)
    a = 2 * (one - other) + span_s * (v_one + v_other)
    b = 3 * (other - one) - span_s * (2 * v_one + v_other)
    for k in range(51):
        s = k / 50
        at = a * s**3 + b * s**2 + span_s * v_one * s + one
        assert min(found.lowest_rad, one) - 1e-6 <= at <= max(found.highest_rad, one) + 1e-6
        assert abs((3 * a * s**2 + 2 * b * s) / span_s + v_one) <= found.fastest_rad_s + 1e-6


@given(st.tuples(*(st.floats(joint.lower_rad, joint.upper_rad) for joint in SO101.joints)), st.floats(0.1, 2.0))
def test_the_way_home_is_one_that_may_be_driven_and_ends_there_at_rest(now: tuple[float, ...], fastest: float) -> None:
    points = home(SO101, now, speed_rad_s_max=fastest)
    if points[-1].time_s <= 120.0:
        way = request(*points)
        assert why_refused(way, SO101, now, speed_rad_s_max=fastest) is None
    assert points[-1].positions_rad == pytest.approx(SO101.home_rad)
    assert points[-1].velocities_rad_s == pytest.approx(STILL, abs=1e-9)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_home_is_in_the_range_of_every_joint_of_every_model(model: ArmModel) -> None:
    for at, joint in zip(model.home_rad, model.joints, strict=True):
        assert joint.lower_rad <= at <= joint.upper_rad


def test_a_jaw_knows_its_opening() -> None:
    jaw = SO101.jaw
    assert jaw.position(0.0) == jaw.closed
    assert jaw.position(1.0) == jaw.opened
    assert jaw.opening(jaw.position(0.3)) == pytest.approx(0.3)
    assert jaw.opening(-math.pi) == 0.0
