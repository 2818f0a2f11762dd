"""What the safety filter leaves of a velocity."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from contracts.causes import SafetyCause
from contracts.geometry import Twist2D
from contracts.motion import Hazard
from robot_bridge.motion.words import restraint_in_words
from robot_bridge.safety.collision_monitor import (
    SafetyInput,
    SafetyLimits,
    apply_safety,
    free_travel_m,
    seen_from_here,
    slowdown,
)
from robot_bridge.safety.obstacles import ObstacleLimits, obstacles
from robot_bridge.sensing.blindness import ALL_ROUND
from robot_bridge.sensing.sensor_readings import Scan

LIMITS = SafetyLimits()
RADIUS_M = LIMITS.footprint_radius_m + LIMITS.side_margin_m
FORWARD = Twist2D(linear_x=0.3)
TURN = Twist2D(angular_z=1.0)


def points(*xy: tuple[float, float]) -> NDArray[np.float64]:
    return np.array(xy, dtype=np.float64).reshape(-1, 2)


def around(*xy: tuple[float, float], **changes: object) -> SafetyInput:
    values: dict[str, object] = {"points_m": points(*xy), "scan_age_s": 0.0, "odometry_age_s": 0.0} | changes
    return SafetyInput(**values)  # type: ignore[arg-type]


def limited(twist: Twist2D, around: SafetyInput, limits: SafetyLimits = LIMITS) -> tuple[Twist2D, SafetyCause | None]:
    left, restraint = apply_safety(twist, around, limits)
    return left, restraint.cause if restraint is not None else None


def blind(middle_deg: float, width_rad: float) -> NDArray[np.float64]:
    """One arc in which the laser knows nothing."""
    return np.array([[math.radians(middle_deg) - width_rad / 2, width_rad]])


def door(width_m: float, distance_m: float = 0.5) -> NDArray[np.float64]:
    """A wall across the way, with a gap in the middle."""
    y = np.arange(width_m / 2, 2.0, 0.02)
    x = np.full_like(y, distance_m)
    return np.concatenate([np.stack([x, y], 1), np.stack([x, -y], 1)])


def test_a_free_way_is_left_alone() -> None:
    assert apply_safety(FORWARD, around((3.0, 0.0)), LIMITS) == (FORWARD, None)


@pytest.mark.parametrize("twist", [FORWARD, TURN, Twist2D(linear_x=-0.1)])
@pytest.mark.parametrize(
    ("changes", "cause"),
    [
        ({"base_stopped": True}, SafetyCause.BASE_STOPPED),
        ({"foreign_velocity_age_s": 0.0}, SafetyCause.STRANGER),
        ({"foreign_velocity_age_s": 1.0}, SafetyCause.STRANGER),
        ({"base_stopped": True, "scan_age_s": None}, SafetyCause.BASE_STOPPED),
    ],
)
def test_nothing_moves_on_a_base_that_is_stopped_or_driven_by_another(
    twist: Twist2D, changes: dict[str, object], cause: SafetyCause
) -> None:
    assert limited(twist, around((3.0, 0.0), **changes)) == (Twist2D(), cause)


def test_a_base_that_another_has_left_alone_for_a_second_is_driven_again() -> None:
    assert apply_safety(FORWARD, around((3.0, 0.0), foreign_velocity_age_s=1.01), LIMITS) == (FORWARD, None)


def test_it_slows_in_proportion_and_stops_inside_the_stop_distance() -> None:
    half_way = RADIUS_M + (LIMITS.stop_distance_m + LIMITS.slow_distance_m) / 2
    slowed, why = limited(FORWARD, around((half_way, 0.0)))
    assert math.isclose(slowed.linear_x, 0.15, abs_tol=1e-9)
    assert why is SafetyCause.SLOWED
    stopped, why = limited(FORWARD, around((RADIUS_M + 0.079, 0.0)))
    assert (stopped.linear_x, why) == (0.0, SafetyCause.OBSTACLE)


def test_at_the_stop_distance_it_stands() -> None:
    limits = SafetyLimits(footprint_radius_m=0.25, side_margin_m=0.0, stop_distance_m=0.25)
    assert limited(FORWARD, around((0.5, 0.0)), limits)[1] is SafetyCause.OBSTACLE
    assert apply_safety(FORWARD, around((0.5001, 0.0)), limits)[0].linear_x > 0.0


def test_the_factor_has_a_floor_and_never_exceeds_one() -> None:
    assert slowdown(LIMITS.stop_distance_m, LIMITS) == LIMITS.slow_factor_min
    assert slowdown(10.0, LIMITS) == 1.0


def test_a_door_of_0_9_m_is_passed_at_full_speed_and_one_too_narrow_is_not_passed() -> None:
    assert free_travel_m(door(0.9), FORWARD, RADIUS_M) == math.inf
    assert free_travel_m(door(0.40), FORWARD, RADIUS_M) < 0.5


def test_what_stands_beside_or_behind_does_not_hinder_driving_forward() -> None:
    assert apply_safety(FORWARD, around((0.0, 0.25), (0.0, -0.25), (-0.25, 0.0)), LIMITS)[0] == FORWARD


def test_reversing_minds_the_rear_and_not_the_front() -> None:
    back = Twist2D(linear_x=-0.2)
    assert apply_safety(back, around((0.25, 0.0)), LIMITS)[0] == back
    stopped, why = limited(back, around((-0.25, 0.0)))
    assert (stopped.linear_x, why) == (0.0, SafetyCause.OBSTACLE)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_turning_with_a_translation_minds_the_side_it_turns_to(side: float) -> None:
    curve = Twist2D(linear_x=0.2, angular_z=side * 1.0)
    assert free_travel_m(points((0.2, side * 0.35)), FORWARD, RADIUS_M) == math.inf
    assert free_travel_m(points((0.2, side * 0.35)), curve, RADIUS_M) < 0.3
    assert free_travel_m(points((0.2, -side * 0.5)), curve, RADIUS_M) == math.inf


@pytest.mark.parametrize("turn", [0.0, 1.0, -1.0])
def test_what_touches_already_counts_only_where_the_way_leads_to_it(turn: float) -> None:
    way = Twist2D(linear_x=0.2, angular_z=turn)
    assert free_travel_m(points((0.15, 0.1)), way, RADIUS_M) == 0.0
    assert free_travel_m(points((-0.15, 0.1)), way, RADIUS_M) == math.inf
    assert free_travel_m(points((0.0, 0.2), (0.0, -0.2)), way, RADIUS_M) == math.inf


def test_turning_on_the_spot_is_always_possible_beside_a_wall() -> None:
    assert apply_safety(TURN, around((0.2, 0.0), (0.0, 0.2), (-0.2, 0.0)), LIMITS)[0] == TURN


def test_an_old_scan_forbids_translation_and_a_very_old_one_turning_too() -> None:
    assert apply_safety(FORWARD, around(scan_age_s=0.5), LIMITS)[0] == FORWARD
    assert limited(FORWARD, around(scan_age_s=0.51)) == (Twist2D(), SafetyCause.OLD_SCAN)
    assert apply_safety(TURN, around(scan_age_s=2.0), LIMITS)[0] == TURN
    assert apply_safety(TURN, around(scan_age_s=0.6), LIMITS)[0] == TURN
    assert limited(TURN, around(scan_age_s=2.1)) == (Twist2D(), SafetyCause.NO_SCAN)
    assert apply_safety(TURN, around(scan_age_s=None), LIMITS)[0] == Twist2D()


def test_a_blind_laser_and_silent_odometry_forbid_translation() -> None:
    back = Twist2D(linear_x=-0.2)
    ahead, behind = blind(0.0, 3.0), blind(180.0, 3.0)
    assert limited(FORWARD, around(blind=ahead))[1] is SafetyCause.BLIND
    assert apply_safety(FORWARD, around(blind=behind), LIMITS)[0] == FORWARD
    assert limited(back, around(blind=behind))[1] is SafetyCause.BLIND
    assert apply_safety(back, around(blind=ahead), LIMITS)[0] == back
    assert apply_safety(TURN, around(blind=ALL_ROUND), LIMITS)[0] == TURN
    assert limited(FORWARD, around(odometry_age_s=None))[1] is SafetyCause.NO_ODOMETRY
    assert limited(FORWARD, around(odometry_age_s=0.6))[1] is SafetyCause.NO_ODOMETRY


@pytest.mark.parametrize(("dropped", "left_m_s"), [(1, 0.3), (3, 0.3), (4, 0.156), (6, 0.0), (12, 0.0)])
def test_unknown_beams_ahead_slow_and_stop_it_as_soon_as_they_may_hide_the_leg_of_a_chair(
    dropped: int, left_m_s: float
) -> None:
    """Beams of 1 degree: one that drops out hides a leg 1.7 m away, six hide one at the footprint."""
    left, cause = limited(FORWARD, around(blind=blind(0.0, dropped * math.radians(1.0))))
    assert left.linear_x == pytest.approx(left_m_s, abs=0.01)
    assert (cause is SafetyCause.BLIND) == (left_m_s == 0.0)


def test_unknown_beams_count_in_the_way_and_nowhere_else() -> None:
    assert apply_safety(FORWARD, around(blind=blind(100.0, 0.2)), LIMITS)[0] == FORWARD
    aside = around(blind=blind(60.0, 0.1))
    left, right = Twist2D(linear_x=0.2, angular_z=0.5), Twist2D(linear_x=0.2, angular_z=-0.5)
    assert apply_safety(FORWARD, aside, LIMITS)[0] == FORWARD
    assert limited(left, aside)[1] is SafetyCause.SLOWED
    assert apply_safety(right, aside, LIMITS)[0] == right


def test_what_is_seen_in_the_way_is_told_before_what_is_not() -> None:
    assert limited(FORWARD, around((0.25, 0.0), blind=ALL_ROUND))[1] is SafetyCause.OBSTACLE


@given(
    st.sampled_from([1.0, -1.0]),
    st.floats(-0.5, 0.5),
    st.floats(-60.0, 60.0),
    st.floats(0.3, math.tau),
    st.floats(-0.4, 0.4),
    st.floats(0.22, 0.3),
)
def test_a_leg_that_the_laser_does_not_see_holds_the_robot_back_as_a_seen_one_does(
    way: float, z: float, off_deg: float, width_rad: float, part: float, distance_m: float
) -> None:
    """A leg of 6 cm anywhere in an unknown arc that is wide enough for it."""
    middle_deg = off_deg + (0.0 if way > 0.0 else 180.0)
    at = math.radians(middle_deg) + part * (width_rad - 0.06 / distance_m)
    twist = Twist2D(linear_x=0.2 * way, angular_z=z)
    leg = points((distance_m * math.cos(at), distance_m * math.sin(at)))
    seen_m = free_travel_m(leg, twist, RADIUS_M - 0.03)
    _, restraint = apply_safety(twist, around(blind=blind(middle_deg, width_rad)), LIMITS)
    held_m = restraint.free_m if restraint is not None else math.inf
    assert held_m <= max(seen_m, 0.0) or seen_m > LIMITS.slow_distance_m - 0.06


def test_a_scan_that_is_not_understood_forbids_translation_and_says_why() -> None:
    left, restraint = apply_safety(FORWARD, around(scan_age_s=0.6, scan_trouble="its range_max is 0 m"), LIMITS)
    assert left == Twist2D()
    assert restraint is not None
    assert restraint_in_words(restraint) == "the laser scan is not understood: its range_max is 0 m"
    never = apply_safety(TURN, around(scan_age_s=None, scan_trouble="its range_max is 0 m"), LIMITS)[1]
    assert never is not None
    assert never.cause is SafetyCause.NOT_UNDERSTOOD


def test_what_is_seen_inside_the_footprint_is_named() -> None:
    restraint = apply_safety(FORWARD, around((0.1, 0.1)), LIMITS)[1]
    assert restraint is not None
    assert restraint_in_words(restraint) == "obstacle ahead: something inside the footprint is seen at 45 degrees"
    beside = apply_safety(FORWARD, around((0.25, 0.0)), LIMITS)[1]
    assert beside is not None
    assert restraint_in_words(beside) == "obstacle ahead"


@pytest.mark.parametrize(
    ("hazard", "twist", "left"),
    [
        (Hazard.BUMP, Twist2D(linear_x=0.2, angular_z=0.5), Twist2D(angular_z=0.5)),
        (Hazard.CLIFF, FORWARD, Twist2D()),
        (Hazard.BUMP, Twist2D(linear_x=-0.2), Twist2D(linear_x=-0.2)),
        (Hazard.BACKUP_LIMIT, Twist2D(linear_x=-0.2), Twist2D()),
        (Hazard.BACKUP_LIMIT, FORWARD, FORWARD),
        (Hazard.STALL, FORWARD, Twist2D()),
        (Hazard.STALL, Twist2D(linear_x=-0.2), Twist2D()),
        (Hazard.WHEEL_DROP, TURN, Twist2D()),
        (Hazard.OBJECT_PROXIMITY, FORWARD, FORWARD),
    ],
)
def test_each_hazard_forbids_what_would_make_it_worse(hazard: Hazard, twist: Twist2D, left: Twist2D) -> None:
    assert apply_safety(twist, around(hazards=frozenset({hazard})), LIMITS)[0] == left


def test_what_was_driven_since_the_scan_counts() -> None:
    near = RADIUS_M + LIMITS.stop_distance_m + 0.05
    assert apply_safety(FORWARD, around((near, 0.0)), LIMITS)[0].linear_x > 0.0
    moved_on = around((near, 0.0), scan_age_s=0.3, measured=Twist2D(linear_x=0.3))
    assert apply_safety(FORWARD, moved_on, LIMITS)[0].linear_x == 0.0


def test_what_was_turned_since_the_scan_counts() -> None:
    """What stood to the left when the laser saw it stands ahead by now."""
    left = (0.35 * math.cos(0.7), 0.35 * math.sin(0.7))
    assert apply_safety(FORWARD, around(left), LIMITS)[0] == FORWARD
    turned = around(left, scan_age_s=0.4, measured=Twist2D(angular_z=1.75))
    assert apply_safety(FORWARD, turned, LIMITS)[0].linear_x < FORWARD.linear_x


@given(st.floats(-0.3, 0.3), st.floats(-1.9, 1.9), st.floats(0.0, 0.5))
def test_points_are_carried_along_as_the_robot_moves(v: float, w: float, age_s: float) -> None:
    """Against stepping the robot along in small steps."""
    x = y = yaw = 0.0
    for _ in range(500):
        x, y, yaw = x + v * age_s / 500 * math.cos(yaw), y + v * age_s / 500 * math.sin(yaw), yaw + w * age_s / 500
    dx, dy = 1.0 - x, 0.5 - y
    expected = (dx * math.cos(yaw) + dy * math.sin(yaw), -dx * math.sin(yaw) + dy * math.cos(yaw))
    moved = seen_from_here(points((1.0, 0.5)), Twist2D(linear_x=v, angular_z=w), age_s)
    assert np.allclose(moved[0], expected, atol=0.007)  # a chord for an arc


@given(
    st.floats(-0.306, 0.306),
    st.floats(-1.9, 1.9),
    st.lists(st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0)), max_size=30),
)
@example(-2e-313, 1.0, [(-0.125, 0.0)])  # a speed too small to divide by
@example(5e-324, -1.9, [(0.209, 0.0)])
def test_it_never_speeds_up_nor_turns_round_a_velocity(x: float, z: float, xy: list[tuple[float, float]]) -> None:
    left, why = apply_safety(Twist2D(linear_x=x, angular_z=z), around(*xy), LIMITS)
    assert abs(left.linear_x) <= abs(x)
    assert abs(left.angular_z) <= abs(z)
    assert left.linear_x * x >= 0.0
    assert left.angular_z * z >= 0.0
    assert why is not None or (left.linear_x, left.angular_z) == (x, z)


@given(
    st.floats(0.02, 0.306),
    st.floats(-1.9, 1.9).filter(lambda z: abs(z) > 0.031),  # a smaller turn is taken as none
    st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)).filter(lambda p: math.hypot(*p) > RADIUS_M + 0.02),
)
def test_the_free_travel_is_where_a_simulated_disc_first_touches(x: float, z: float, p: tuple[float, float]) -> None:
    """The closed form against stepping along the arc, up to half a turn."""
    free_m = free_travel_m(points(p), Twist2D(linear_x=x, angular_z=z), RADIUS_M)
    reach_m = min(free_m - 0.005, 1.0, math.pi * x / max(abs(z), 1e-9))
    s = np.arange(0.0, max(reach_m, 0.0), 0.002)
    heading = s * z / x
    centre_x, centre_y = x / z * np.sin(heading), x / z * (1.0 - np.cos(heading))
    assert not (np.hypot(p[0] - centre_x, p[1] - centre_y) < RADIUS_M - 0.001).any()
    if math.isfinite(free_m):  # and there it does touch
        at = free_m * z / x
        assert math.hypot(p[0] - x / z * math.sin(at), p[1] - x / z * (1.0 - math.cos(at))) <= RADIUS_M + 0.001


def test_sectors_are_measured_from_the_footprint_and_named() -> None:
    scan = Scan(0.0, points((0.5, 0.0), (0.0, 1.0), (-0.7, 0.0)))
    found = obstacles(scan, ObstacleLimits())
    assert found.sectors_m["front"] == pytest.approx(0.311)
    assert found.sectors_m["left"] == pytest.approx(0.811)
    assert found.sectors_m["back"] == pytest.approx(0.511)
    assert found.sectors_m["right"] is None
    assert not found.emergency
    assert obstacles(Scan(0.0, points((0.25, 0.0))), ObstacleLimits()).emergency
