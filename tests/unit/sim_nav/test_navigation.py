"""The stand-in for Nav2, driven on a simulated clock by a robot that is nothing but its equations of motion."""

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts.geometry import Pose2D, Twist2D
from sim.nav.codes import Code, NavigationError
from sim.nav.costmap import Costmap
from sim.nav.follower import Limits, blocked, wrap
from sim.nav.navigator import Navigator, Outcome, Patience, Progress
from sim.nav.obstacles import ObstacleLayer
from sim.nav.planner import plan
from sim.world.types import OccupancyGrid, Scan

RESOLUTION_M = 0.05
NO_SCAN = np.empty((0, 2))


def rooms(width_m: float = 6.0, height_m: float = 4.0, door_m: float = 0.9) -> np.ndarray:
    """Two rooms side by side with a door in the middle of the wall between them."""
    data = np.zeros((round(height_m / RESOLUTION_M), round(width_m / RESOLUTION_M)), dtype=np.int8)
    data[[0, -1], :] = 100
    data[:, [0, -1]] = 100
    data[:, round(3.0 / RESOLUTION_M)] = 100
    half = round(door_m / 2 / RESOLUTION_M)
    middle = data.shape[0] // 2
    data[middle - half : middle + half, round(3.0 / RESOLUTION_M)] = 0
    return data


def costmap(data: np.ndarray) -> Costmap:
    return Costmap.from_map(OccupancyGrid(data, RESOLUTION_M, 0.0, 0.0))


@dataclass
class Laser:
    """Casts 360 rays through an occupancy array, half a cell at a time."""

    occupied: np.ndarray

    def scan(self, pose: Pose2D) -> Scan:
        angles = np.arange(360) * (math.tau / 360) - math.pi
        steps = np.arange(0.1, 6.0, RESOLUTION_M / 2)
        x = pose.x + steps * np.cos(angles + pose.yaw)[:, None]
        y = pose.y + steps * np.sin(angles + pose.yaw)[:, None]
        rows = np.clip((y / RESOLUTION_M).astype(int), 0, self.occupied.shape[0] - 1)
        columns = np.clip((x / RESOLUTION_M).astype(int), 0, self.occupied.shape[1] - 1)
        hits = self.occupied[rows, columns]
        ranges = np.where(hits.any(axis=1), steps[hits.argmax(axis=1)], np.inf).astype(np.float32)
        return Scan(0.0, ranges, -math.pi, math.tau / 360, 0.1, 12.0)


@dataclass
class Drive:
    """A robot that does what it is told (unless it is held), in a world of `occupied` cells."""

    navigator: Navigator
    laser: Laser
    pose: Pose2D
    held: bool = False
    time_s: float = 0.0
    trail: list[Pose2D] = field(default_factory=list)

    def tick(self) -> Progress:
        if round(self.time_s / 0.05) % 3 == 0:
            self.navigator.observe(self.laser.scan(self.pose), self.pose)
        progress = self.navigator.step(self.pose, self.time_s)
        self.time_s += 0.05
        if not self.held:
            self.pose = moved(self.pose, progress.twist, 0.05)
        self.trail.append(self.pose)
        return progress

    def to_the_end(self, limit_s: float = 120.0) -> Progress:
        while (progress := self.tick()).outcome is Outcome.RUNNING:
            assert self.time_s < limit_s
        return progress

    def length_m(self) -> float:
        points = np.array([(p.x, p.y) for p in self.trail])
        return float(np.hypot(*np.diff(points, axis=0).T).sum())


def moved(pose: Pose2D, twist: Twist2D, dt_s: float) -> Pose2D:
    yaw = pose.yaw + twist.angular_z * dt_s / 2
    return Pose2D(
        x=pose.x + twist.linear_x * dt_s * math.cos(yaw),
        y=pose.y + twist.linear_x * dt_s * math.sin(yaw),
        yaw=wrap(pose.yaw + twist.angular_z * dt_s),
    )


def drive(
    data: np.ndarray, start: Pose2D, *, real: np.ndarray | None = None, patience: Patience | None = None
) -> Drive:
    return Drive(Navigator(costmap(data), patience=patience), Laser((data if real is None else real) > 50), start)


def test_a_path_leads_through_the_door_and_keeps_clear_of_its_posts() -> None:
    map_ = costmap(rooms())
    path = plan(map_, Pose2D(x=1.0, y=0.8, yaw=0.0), Pose2D(x=5.0, y=3.2, yaw=1.0))
    rows, columns = map_.grid.cells(path.points_m)
    assert map_.clearance_m[rows, columns].min() > 0.3
    assert path.length_m == pytest.approx(math.hypot(4.0, 2.4), rel=0.15)
    assert tuple(path.points_m[-1]) == (5.0, 3.2)
    assert path.poses()[-1].yaw == 1.0


@pytest.mark.parametrize(
    ("start", "goal", "code"),
    [
        ((-1.0, 1.0), (2.0, 2.0), Code.START_OUTSIDE_MAP),
        ((1.0, 1.0), (50.0, 2.0), Code.GOAL_OUTSIDE_MAP),
        ((3.02, 0.6), (1.0, 2.0), Code.NO_VALID_PATH),
        ((1.0, 1.0), (2.9, 0.6), Code.NONE),
    ],
)
def test_each_bad_goal_has_nav2s_own_code(start: tuple[float, float], goal: tuple[float, float], code: Code) -> None:
    assert planning_code(rooms(), start, goal) is code


def test_a_start_inside_an_obstacle_is_told_as_if_the_goal_were_to_blame() -> None:
    data = rooms()
    data[10:40, 10:40] = 100
    assert planning_code(data, (1.25, 1.25), (2.0, 3.0)) is Code.NO_VALID_PATH


def test_only_the_one_cell_under_the_robot_is_cleared() -> None:
    data = np.zeros((40, 40), dtype=np.int8)
    free = costmap(data)
    assert plan(free, Pose2D(x=1.0, y=1.0, yaw=0.0), Pose2D(x=1.6, y=1.0, yaw=0.0)).length_m == pytest.approx(0.6)
    data[22, 20] = 100  # 0.1 m beside the robot: everything round it is too near, not only where it stands
    assert planning_code(data, (1.02, 1.02), (0.2, 1.8)) is Code.NO_VALID_PATH


@pytest.mark.parametrize("goal", [(3.02, 0.6), (2.95, 0.8), (0.05, 2.0)])
def test_an_occupied_goal_becomes_the_nearest_free_point_half_a_metre_round_it(goal: tuple[float, float]) -> None:
    map_ = costmap(rooms())
    path = plan(map_, Pose2D(x=1.0, y=1.0, yaw=0.0), Pose2D(x=goal[0], y=goal[1], yaw=1.2))
    end = path.poses()[-1]
    assert 0.1 < math.hypot(end.x - goal[0], end.y - goal[1]) < 0.5
    assert map_.free[map_.grid.cell(end.x, end.y)]
    assert end.yaw == 1.2


def test_where_nothing_is_free_half_a_metre_round_it_there_is_no_path() -> None:
    data = rooms()
    data[:, 80:110] = 100
    assert planning_code(data, (1.0, 1.0), (4.8, 2.0)) is Code.NO_VALID_PATH


def test_a_planner_without_a_tolerance_names_the_occupied_goal() -> None:
    with pytest.raises(NavigationError) as refused:
        plan(costmap(rooms()), Pose2D(x=1.0, y=1.0, yaw=0.0), Pose2D(x=2.9, y=0.6, yaw=0.0), tolerance_m=0.0)
    assert refused.value.code is Code.GOAL_OCCUPIED


def test_way_points_lie_two_and_a_half_centimetres_apart() -> None:
    points = plan(costmap(rooms()), Pose2D(x=1.0, y=0.8, yaw=0.0), Pose2D(x=5.0, y=3.2, yaw=0.0)).points_m
    assert np.hypot(*np.diff(points, axis=0).T).max() <= 0.0251


def test_a_closed_door_leaves_no_valid_path() -> None:
    assert planning_code(rooms(door_m=0.0), (1.0, 1.0), (5.0, 2.0)) is Code.NO_VALID_PATH


def planning_code(data: np.ndarray, start: tuple[float, float], goal: tuple[float, float]) -> Code:
    try:
        plan(costmap(data), Pose2D(x=start[0], y=start[1], yaw=0.0), Pose2D(x=goal[0], y=goal[1], yaw=0.0))
    except NavigationError as error:
        return error.code
    return Code.NONE


@given(
    x=st.floats(0.4, 2.6),
    y=st.floats(0.4, 3.6),
    yaw=st.floats(-3.1, 3.1),
    goal_x=st.floats(3.4, 5.6),
    goal_y=st.floats(0.4, 3.6),
    goal_yaw=st.floats(-3.1, 3.1),
)
@settings(max_examples=15, derandomize=True)
def test_the_robot_arrives_within_tolerance_without_touching_a_wall(
    x: float, y: float, yaw: float, goal_x: float, goal_y: float, goal_yaw: float
) -> None:
    data = rooms()
    goal = Pose2D(x=goal_x, y=goal_y, yaw=goal_yaw)
    robot = drive(data, Pose2D(x=x, y=y, yaw=yaw))
    robot.navigator.start(goal, robot.pose, 0.0)
    assert robot.to_the_end().outcome is Outcome.SUCCEEDED
    assert 0.15 < math.hypot(robot.pose.x - goal.x, robot.pose.y - goal.y) < 0.25
    assert abs(wrap(robot.pose.yaw - goal.yaw)) < 0.25
    map_ = costmap(data)
    rows, columns = map_.grid.cells(np.array([(p.x, p.y) for p in robot.trail]))
    assert map_.clearance_m[rows, columns].min() > 0.17


@pytest.mark.parametrize("goal", [Pose2D(x=1.2, y=1.1, yaw=0.2), Pose2D(x=0.78, y=1.0, yaw=-0.2)])
def test_a_goal_nearer_than_the_tolerance_succeeds_at_once_without_a_move(goal: Pose2D) -> None:
    robot = drive(rooms(), Pose2D(x=1.0, y=1.0, yaw=0.0))
    robot.navigator.start(goal, robot.pose, 0.0)
    assert robot.tick().outcome is Outcome.SUCCEEDED
    assert robot.pose == Pose2D(x=1.0, y=1.0, yaw=0.0)


def test_once_within_the_tolerance_it_only_turns_whatever_pushes_it_away() -> None:
    robot = drive(rooms(), Pose2D(x=1.0, y=1.0, yaw=0.0))
    robot.navigator.start(Pose2D(x=1.2, y=1.0, yaw=3.0), robot.pose, 0.0)
    assert robot.tick().twist.linear_x == 0.0
    robot.pose = robot.pose.model_copy(update={"x": 0.7})
    end = robot.to_the_end()
    assert end.outcome is Outcome.SUCCEEDED
    assert all(pose.x == 0.7 for pose in robot.trail[1:])


def test_speeds_stay_within_the_limits_of_the_base() -> None:
    robot = drive(rooms(), Pose2D(x=1.0, y=1.0, yaw=3.0))
    robot.navigator.start(Pose2D(x=5.0, y=3.0, yaw=-1.0), robot.pose, 0.0)
    twists = []
    while (progress := robot.tick()).outcome is Outcome.RUNNING:
        twists.append(progress.twist)
    assert max(t.linear_x for t in twists) == pytest.approx(0.26)
    assert min(t.linear_x for t in twists) >= 0.0
    assert max(abs(t.angular_z) for t in twists) <= 1.2


def test_a_thing_in_the_way_that_the_map_does_not_hold_is_driven_round() -> None:
    real = rooms()
    real[36:44, 28:32] = 100
    robot = drive(rooms(), Pose2D(x=0.6, y=2.0, yaw=0.0), real=real)
    robot.navigator.start(Pose2D(x=5.0, y=2.0, yaw=0.0), robot.pose, 0.0)
    assert robot.to_the_end().outcome is Outcome.SUCCEEDED
    clearance_m = costmap(real).clearance_m
    rows, columns = costmap(real).grid.cells(np.array([(p.x, p.y) for p in robot.trail]))
    assert clearance_m[rows, columns].min() > 0.15


def test_a_door_that_is_shut_in_reality_ends_with_patience_exceeded() -> None:
    robot = drive(rooms(), Pose2D(x=1.0, y=2.0, yaw=0.0), real=rooms(door_m=0.0))
    robot.navigator.start(Pose2D(x=5.0, y=2.0, yaw=0.0), robot.pose, 0.0)
    end = robot.to_the_end()
    assert (end.outcome, end.code) == (Outcome.ABORTED, Code.PATIENCE_EXCEEDED)
    assert robot.pose.x < 3.0 - 0.15
    with pytest.raises(NavigationError) as refused:
        robot.navigator.start(Pose2D(x=5.0, y=2.0, yaw=0.0), robot.pose, robot.time_s)
    assert refused.value.code is Code.NO_VALID_PATH


def test_clearing_the_costmap_forgets_what_is_no_longer_there() -> None:
    robot = drive(rooms(), Pose2D(x=1.5, y=2.0, yaw=0.0), real=rooms(door_m=0.0))
    robot.navigator.observe(robot.laser.scan(robot.pose), robot.pose)
    assert not robot.navigator.costmap.free[40, 60]
    robot.navigator.clear_global()
    robot.navigator.clear_local()
    assert robot.navigator.costmap.free[40, 60]


def test_a_robot_that_is_held_fails_to_make_progress() -> None:
    robot = drive(rooms(), Pose2D(x=1.0, y=2.0, yaw=0.0))
    robot.held = True
    robot.navigator.start(Pose2D(x=2.0, y=2.0, yaw=0.0), robot.pose, 0.0)
    end = robot.to_the_end()
    assert end.code is Code.FAILED_TO_MAKE_PROGRESS
    assert robot.time_s == pytest.approx(Patience().stuck_s, abs=0.2)


def test_turning_on_the_spot_and_creeping_are_no_progress() -> None:
    robot = drive(rooms(), Pose2D(x=1.0, y=2.0, yaw=0.0))
    robot.navigator.start(Pose2D(x=2.5, y=2.0, yaw=0.0), robot.pose, 0.0)
    while (end := robot.tick()).outcome is Outcome.RUNNING:
        robot.pose = Pose2D(x=1.0 + 0.04 * robot.time_s, y=2.0, yaw=wrap(0.5 * robot.time_s))
    assert (end.code, round(robot.time_s)) == (Code.FAILED_TO_MAKE_PROGRESS, 10)


def test_one_in_so_many_replannings_is_lost_and_aborts_without_a_code() -> None:
    robot = drive(rooms(), Pose2D(x=1.0, y=2.0, yaw=0.0), patience=Patience(lost_one_in=3))
    robot.navigator.start(Pose2D(x=5.0, y=2.0, yaw=0.0), robot.pose, 0.0)
    end = robot.to_the_end()
    assert (end.outcome, end.code) == (Outcome.ABORTED, Code.NONE)
    assert robot.time_s == pytest.approx(3.0, abs=0.2)
    robot.navigator.start(Pose2D(x=2.2, y=2.0, yaw=0.0), robot.pose, robot.time_s)
    assert robot.to_the_end().outcome is Outcome.SUCCEEDED


def test_a_cancelled_goal_asks_for_nothing_more() -> None:
    robot = drive(rooms(), Pose2D(x=1.0, y=2.0, yaw=0.0))
    robot.navigator.start(Pose2D(x=2.0, y=2.0, yaw=0.0), robot.pose, 0.0)
    robot.navigator.cancel()
    assert robot.navigator.step(robot.pose, 1.0).twist == Twist2D()


def test_marks_vanish_once_the_laser_sees_through_them() -> None:
    map_, laser_pose = costmap(rooms()), Pose2D(x=1.0, y=2.0, yaw=0.3)
    with_box = rooms()
    with_box[38:42, 30:34] = 100
    layer = ObstacleLayer(map_)
    assert layer.observe(Laser(with_box > 50).scan(laser_pose), laser_pose)
    assert layer.marked[38:42, 29:34].any()
    assert layer.observe(Laser(rooms() > 50).scan(laser_pose), laser_pose)
    assert not layer.marked.any()


def test_the_maps_own_walls_are_not_marked_even_when_seen_a_little_off_their_place() -> None:
    layer, true, believed = (
        ObstacleLayer(costmap(rooms())),
        Pose2D(x=1.0, y=2.0, yaw=0.0),
        Pose2D(x=1.06, y=1.95, yaw=0.0),
    )
    layer.observe(Laser(rooms() > 50).scan(true), believed)
    assert not layer.marked.any()


def test_an_obstacle_counts_only_when_the_robot_would_come_nearer_to_it() -> None:
    ahead, behind, touching = np.array([[0.3, 0.0]]), np.array([[-0.3, 0.0]]), np.array([[-0.1, 0.1]])
    forward, turning = Twist2D(linear_x=0.2), Twist2D(angular_z=1.0)
    assert blocked(forward, ahead, Limits())
    assert not blocked(forward, behind, Limits())
    assert not blocked(forward, touching, Limits())
    assert not blocked(turning, ahead, Limits())
    assert not blocked(forward, NO_SCAN, Limits())
