"""No decision drives nearer to anything than it may, whatever was decided and whatever the laser sees."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from contracts.exploration import (
    CheckPathClear,
    DecisionVerdict,
    ExplorationDecision,
    MoveToward,
    NavigateToGoal,
    ObserveScene,
    ReportDiscovery,
    RotateBy,
    StopRobot,
)
from contracts.geometry import Pose2D
from coordinator.exploration.decision_check import Advance, Checked, CheckLimits, GoTo, Knowledge, TurnBy, check, end_of
from coordinator.exploration.frontiers import Chart, Frontier, chart_of
from coordinator.exploration.surroundings import PlaceKind, Surroundings
from geometry.grids import OccupancyGrid

LIMITS = CheckLimits()
NOW_S = 100.0
HERE = Pose2D(x=0.0, y=0.0, yaw=0.0)


def chart() -> Chart:
    cells = np.full((160, 160), -1, np.int8)
    cells[40:120, 40:120] = 0  # 4 m x 4 m round the origin
    cells[40:120, 118:120] = 100
    return chart_of(OccupancyGrid(cells, 0.05, Pose2D(x=-4.0, y=-4.0, yaw=0.0)), HERE, 0.19)


CHART = chart()


def seen(*points_m: tuple[float, float], age_s: float = 0.1) -> Surroundings:
    return Surroundings(NOW_S - age_s, np.array(points_m, float).reshape(-1, 2))


def known(scan: Surroundings | None, *, pose: Pose2D | None = HERE, told: tuple[Frontier, ...] = ()) -> Knowledge:
    return Knowledge(scan, pose, CHART, told, (), NOW_S)


def judged(decision: ExplorationDecision, scan: Surroundings | None) -> Checked:
    return check(decision, known(scan), LIMITS)


AHEAD = MoveToward(bearing_rad=0.0, distance_m=1.5)


# the way


@pytest.mark.parametrize(
    ("wall_m", "verdict", "distance_m", "speed_m_s"),
    [
        (3.0, DecisionVerdict.ACCEPTED, 1.5, LIMITS.speed_m_s),
        (1.5 + LIMITS.slow_m + 0.25, DecisionVerdict.ACCEPTED, 1.5, LIMITS.speed_m_s),
        (1.5 + LIMITS.slow_m + 0.23, DecisionVerdict.SLOWED, 1.5, LIMITS.slow_speed_m_s),
        (1.5, DecisionVerdict.SHORTENED, 1.5 - 0.24 - LIMITS.keep_m, LIMITS.slow_speed_m_s),
        (0.75, DecisionVerdict.SHORTENED, 0.75 - 0.24 - LIMITS.keep_m, LIMITS.slow_speed_m_s),
    ],
)
def test_the_nearer_something_stands_the_shorter_and_slower(
    wall_m: float, verdict: DecisionVerdict, distance_m: float, speed_m_s: float
) -> None:
    checked = judged(AHEAD, seen((wall_m, 0.0)))
    assert checked.verdict is verdict
    assert isinstance(checked.motion, Advance)
    assert checked.motion.distance_m == pytest.approx(distance_m)
    assert checked.motion.speed_m_s == speed_m_s


def test_less_than_half_a_metre_clear_is_refused_and_remembered() -> None:
    checked = judged(AHEAD, seen((0.73, 0.0)))
    assert (checked.verdict, checked.motion) == (DecisionVerdict.BLOCKED, None)
    assert [one.heading_rad for one in checked.tries] == [0.0]


def test_what_stands_beside_the_path_of_the_footprint_is_not_in_the_way() -> None:
    assert judged(AHEAD, seen((1.0, 0.26), (1.0, -0.26))).verdict is DecisionVerdict.ACCEPTED
    assert judged(AHEAD, seen((0.5, 0.23))).verdict is DecisionVerdict.BLOCKED


@pytest.mark.parametrize("age_s", [LIMITS.scan_age_s_max + 0.01, 60.0, -0.1])
@pytest.mark.parametrize("decision", [AHEAD, RotateBy(angle_rad=1.0), NavigateToGoal(x_m=0.5, y_m=0.5)], ids=str)
def test_nothing_moves_on_an_old_scan_or_on_one_from_the_future(decision: ExplorationDecision, age_s: float) -> None:
    assert judged(decision, seen((3.0, 0.0), age_s=age_s)) == Checked(DecisionVerdict.NO_SCAN)
    assert judged(decision, None) == Checked(DecisionVerdict.NO_SCAN)


@pytest.mark.parametrize(("bearing_rad", "refused"), [(0.0, True), (0.6, True), (1.2, False), (-0.6, True)])
def test_nothing_drives_where_the_laser_says_nothing(bearing_rad: float, refused: bool) -> None:
    scan = Surroundings(NOW_S, np.empty((0, 2)), ((-0.4, 0.4),))
    verdict = judged(MoveToward(bearing_rad=bearing_rad, distance_m=0.5), scan).verdict
    assert (verdict is DecisionVerdict.BLIND) == refused


def test_without_a_pose_nothing_drives_but_it_may_turn() -> None:
    lost = Knowledge(seen((3.0, 0.0)), None, CHART, now_s=NOW_S)
    assert check(AHEAD, lost, LIMITS).verdict is DecisionVerdict.NO_POSE
    assert check(NavigateToGoal(x_m=0.0, y_m=0.0), lost, LIMITS).verdict is DecisionVerdict.NO_POSE
    assert check(RotateBy(angle_rad=0.5), lost, LIMITS).motion == TurnBy(0.5)


# tries


def test_a_blocked_direction_is_tried_twice_in_15_s_and_then_again() -> None:
    wall, tries = (0.6, 0.0), ()
    verdicts = []
    for after_s in (0.0, 1.0, 2.0, 14.9, 15.5):
        scan = Surroundings(NOW_S + after_s, np.array([wall]))
        checked = check(AHEAD, Knowledge(scan, HERE, None, (), tries, NOW_S + after_s), LIMITS)
        tries = checked.tries
        verdicts.append(checked.verdict)
    blocked, often = DecisionVerdict.BLOCKED, DecisionVerdict.TRIED_TOO_OFTEN
    assert verdicts == [blocked, blocked, often, often, blocked]


def test_a_direction_is_the_maps_not_the_robots() -> None:
    tries = judged(AHEAD, seen((0.6, 0.0))).tries * 2
    turned = Pose2D(x=0.0, y=0.0, yaw=math.pi / 2)
    wall_all_round = seen(*((0.6 * math.cos(a), 0.6 * math.sin(a)) for a in np.arange(0, 6.3, 0.1)))
    same = MoveToward(bearing_rad=-math.pi / 2, distance_m=1.0)
    for decision, verdict in ((same, DecisionVerdict.TRIED_TOO_OFTEN), (AHEAD, DecisionVerdict.BLOCKED)):
        assert check(decision, Knowledge(wall_all_round, turned, None, (), tries, NOW_S), LIMITS).verdict is verdict


# goals


def test_a_goal_must_be_known_free_and_reachable() -> None:
    verdicts = [judged(NavigateToGoal(x_m=x, y_m=0.0), seen((3.0, 0.0))).verdict for x in (1.0, 1.9, 3.0, 900.0)]
    assert verdicts == [DecisionVerdict.ACCEPTED, *[DecisionVerdict.GOAL_NOT_FREE] * 3]


def test_a_goal_on_which_the_laser_sees_something_is_refused() -> None:
    turned = Pose2D(x=0.0, y=0.0, yaw=math.pi / 2)
    there = Knowledge(seen((0.0, -1.1)), turned, CHART, now_s=NOW_S)  # at (1.1, 0) in the map
    assert check(NavigateToGoal(x_m=1.0, y_m=0.0), there, LIMITS).verdict is DecisionVerdict.GOAL_NOT_FREE
    assert check(NavigateToGoal(x_m=-1.0, y_m=0.0), there, LIMITS).verdict is DecisionVerdict.ACCEPTED


@pytest.mark.parametrize(("beside_m", "refused"), [(0.73, True), (0.75, False)])
def test_a_place_must_be_as_far_from_what_the_laser_sees_as_a_drive_may_come(beside_m: float, refused: bool) -> None:
    verdict = judged(NavigateToGoal(x_m=1.0, y_m=0.0), seen((1.0, beside_m))).verdict
    assert (verdict is DecisionVerdict.GOAL_NOT_FREE) == refused


@pytest.mark.parametrize(("y_m", "refused"), [(0.0, True), (-0.6, True), (1.5, False)])
def test_a_place_is_no_way_round_what_the_laser_does_not_see(y_m: float, refused: bool) -> None:
    scan = Surroundings(NOW_S, np.empty((0, 2)), ((-0.4, 0.4),))
    verdict = judged(NavigateToGoal(x_m=1.0, y_m=y_m), scan).verdict
    assert verdict is (DecisionVerdict.BLIND if refused else DecisionVerdict.ACCEPTED)


def test_a_place_is_no_way_round_a_direction_that_was_blocked_twice() -> None:
    tries = judged(AHEAD, seen((0.6, 0.0))).tries * 2
    turned = Pose2D(x=0.0, y=0.0, yaw=math.pi / 2)
    there = Knowledge(seen(), turned, CHART, tries=tries, now_s=NOW_S)
    assert check(NavigateToGoal(x_m=1.5, y_m=0.2), there, LIMITS).verdict is DecisionVerdict.TRIED_TOO_OFTEN
    assert check(NavigateToGoal(x_m=0.0, y_m=1.5), there, LIMITS).verdict is DecisionVerdict.ACCEPTED


def test_a_frontier_is_one_that_was_told_and_still_is_one() -> None:
    told = CHART.frontiers[:1]
    first = NavigateToGoal(frontier=1)
    assert check(first, known(seen((3.0, 0.0)), told=told), LIMITS).motion == GoTo(told[0].pose)
    assert check(first, known(seen((3.0, 0.0))), LIMITS).verdict is DecisionVerdict.NO_SUCH_FRONTIER
    gone = Frontier(1, Pose2D(x=1.5, y=0.0, yaw=0.0), 1.0, 1.0, 1.0)
    assert check(first, known(seen((3.0, 0.0)), told=(gone,)), LIMITS).verdict is DecisionVerdict.NO_SUCH_FRONTIER


# what moves nothing


@pytest.mark.parametrize("decision", [StopRobot(), ObserveScene(), ReportDiscovery(label="cup")], ids=str)
def test_what_moves_nothing_needs_no_scan(decision: ExplorationDecision) -> None:
    assert judged(decision, None) == Checked(DecisionVerdict.ACCEPTED)


def test_looking_whether_a_path_is_clear_moves_nothing_and_counts_as_no_try() -> None:
    scan = seen((1.0, 0.0))
    for distance_m, verdict in ((0.5, DecisionVerdict.ACCEPTED), (0.6, DecisionVerdict.BLOCKED)):
        checked = judged(CheckPathClear(bearing_rad=0.0, distance_m=distance_m), scan)
        assert (checked.verdict, checked.motion, checked.tries) == (verdict, None, ())
        assert checked.clear_m == pytest.approx(0.76)


# properties

FLOATS = st.floats(-4.0, 4.0)
POINTS = st.lists(st.tuples(FLOATS, FLOATS), max_size=30)
BEARINGS = st.floats(-math.pi, math.pi)
DISTANCES = st.floats(0.01, 2.0)


def swept_m(points_m: NDArray[np.float64], pose: Pose2D, motion: Advance) -> float:
    """The nearest that a point lies to base_link on its way, of those that do not lie behind or beside at the start."""
    along = np.linspace(0.0, motion.distance_m, 200)
    way = pose.yaw + motion.bearing_rad
    path = np.stack([pose.x + along * math.cos(way), pose.y + along * math.sin(way)], 1)
    ahead = (points_m - (pose.x, pose.y)) @ np.array([math.cos(way), math.sin(way)]) > 0.0
    if not ahead.any():
        return math.inf
    return float(np.linalg.norm(path[:, None] - points_m[ahead][None], axis=2).min())


@settings(deadline=None)
@given(POINTS, BEARINGS, DISTANCES)
def test_no_accepted_drive_comes_nearer_than_the_side_margin_and_none_ends_nearer_than_it_must_keep(
    points: list[tuple[float, float]], bearing_rad: float, distance_m: float
) -> None:
    scan = seen(*points)
    checked = judged(MoveToward(bearing_rad=bearing_rad, distance_m=distance_m), scan)
    if checked.motion is None:
        assert not checked.verdict.moves
        return
    assert isinstance(checked.motion, Advance)
    assert checked.motion.distance_m <= distance_m
    assert swept_m(scan.points_m, HERE, checked.motion) >= LIMITS.half_width_m - 1e-6
    end = end_of(HERE, checked.motion)
    after = Surroundings(NOW_S, scan.points_m - (end.x, end.y))
    assert after.clear_m(bearing_rad, LIMITS.half_width_m) >= LIMITS.keep_m - 1e-6
    near = scan.clear_m(bearing_rad, LIMITS.half_width_m)
    assert near >= LIMITS.reject_m
    slow = near - checked.motion.distance_m < LIMITS.slow_m
    assert checked.motion.speed_m_s == (LIMITS.slow_speed_m_s if slow else LIMITS.speed_m_s)


DECISION = st.one_of(
    st.builds(MoveToward, bearing_rad=BEARINGS, distance_m=DISTANCES),
    st.builds(CheckPathClear, bearing_rad=BEARINGS, distance_m=DISTANCES),
    st.builds(RotateBy, angle_rad=BEARINGS),
    st.builds(NavigateToGoal, x_m=FLOATS, y_m=FLOATS),
    st.builds(NavigateToGoal, frontier=st.integers(1, 4)),
)


@settings(deadline=None)
@given(DECISION, POINTS, st.floats(-1.0, 2.0), st.none() | st.builds(Pose2D, x=FLOATS, y=FLOATS, yaw=BEARINGS))
def test_what_is_not_accepted_moves_nothing_and_an_old_scan_moves_nothing(
    decision: ExplorationDecision, points: list[tuple[float, float]], age_s: float, pose: Pose2D | None
) -> None:
    scan = seen(*points, age_s=age_s)
    checked = check(decision, known(scan, pose=pose, told=CHART.frontiers), LIMITS)
    fresh = 0.0 <= NOW_S - scan.stamp_s <= LIMITS.scan_age_s_max
    assert checked.motion is None or (checked.verdict.moves and fresh)
    assert not isinstance(checked.motion, GoTo) or CHART.has_room_at(checked.motion.pose.x, checked.motion.pose.y)
    assert checked == check(decision, known(scan, pose=pose, told=CHART.frontiers), LIMITS)


# the place


def walls(*segments: tuple[float, float, float, float]) -> Surroundings:
    """Points every 2 cm along segments x, y to x, y."""
    lines = [
        np.linspace((x0, y0), (x1, y1), 1 + round(math.hypot(x1 - x0, y1 - y0) / 0.02)) for x0, y0, x1, y1 in segments
    ]
    return Surroundings(NOW_S, np.concatenate(lines))


BOX = ((-2.5, -2.5, 2.5, -2.5), (2.5, -2.5, 2.5, 2.5), (2.5, 2.5, -2.5, 2.5), (-2.5, 2.5, -2.5, -2.5))
CORRIDOR = ((-4.0, 1.0, 4.0, 1.0), (-4.0, -1.0, 4.0, -1.0))


@pytest.mark.parametrize(
    ("scan", "kind"),
    [
        (walls(*BOX), PlaceKind.ROOM),
        (walls(*CORRIDOR), PlaceKind.ROOM),
        (walls((0.0, 0.45, 0.0, 3.0), (0.0, -0.45, 0.0, -3.0)), PlaceKind.DOORWAY),
        (walls(*CORRIDOR, (0.8, -1.0, 0.8, 1.0)), PlaceKind.DEAD_END),
        (
            walls((-4, 0.8, -0.8, 0.8), (0.8, 0.8, 4, 0.8), (-0.8, 0.8, -0.8, 4), (0.8, 0.8, 0.8, 4), (-4, -1, 4, -1)),
            PlaceKind.JUNCTION,
        ),
    ],
    ids=["room", "corridor", "doorway", "dead end", "junction"],
)
def test_the_shape_of_the_scan_says_what_place_it_is(scan: Surroundings, kind: PlaceKind) -> None:
    assert scan.place_kind(LIMITS.half_width_m) is kind
