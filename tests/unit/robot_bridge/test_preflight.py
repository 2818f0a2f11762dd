"""What the bridge makes of a planner's answers before it sends a goal; the planner is a script with NavFn's habits."""

import math
from collections.abc import Callable
from typing import Any, cast

import numpy as np
import pytest

from contracts.geometry import Pose2D
from contracts.robot import CandidatePose
from mesh.errors import UnavailableError
from robot_bridge.navigation.path_check import GoalRegion, PathCheck, PathChecker, PathLimits, best_or_first
from robot_bridge.ports import Path, Robot
from robot_bridge.sensing.sensor_readings import Grid, SensorReadings

HERE = Pose2D(x=1.0, y=1.0, yaw=0.0)
WANTED = Pose2D(x=3.0, y=3.0, yaw=0.5)


class Planner:
    """The port of a robot, as far as the preflight knows it; `answer` gets each goal."""

    def __init__(self, answer: Callable[[Pose2D], Path]) -> None:
        self.senses = SensorReadings()
        self.senses.map.put(Grid(np.zeros((100, 100), np.int8), 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0)), 0.0)
        self.senses.poses.add_odometry(1.0, HERE)
        self.senses.poses.add_map_to_odom(1.0, Pose2D(x=0.0, y=0.0, yaw=0.0), received_s=1.0)
        self.answer = answer
        self.asked: list[Pose2D] = []

    async def compute_path(self, goal: Pose2D, start: Pose2D | None) -> Path:
        self.asked.append(goal)
        return self.answer(goal)


def to(pose: Pose2D) -> Path:
    return Path((HERE, pose))


async def checked(planner: Any, *, radius_m: float = 0.6) -> PathCheck:
    return await PathChecker(planner, PathLimits()).best(GoalRegion((CandidatePose(pose=WANTED),), radius_m))


def ends_off(metres: float) -> Callable[[Pose2D], Path]:
    """The wanted pose is occupied: a plan to it ends so far beside it, with its own heading and code 0."""
    return lambda goal: to(WANTED.model_copy(update={"x": WANTED.x - metres}) if goal == WANTED else goal)


@pytest.mark.parametrize("metres", [0.0, 0.05, 0.14])
async def test_a_plan_that_ends_a_little_beside_its_goal_leads_there(metres: float) -> None:
    found = await checked(Planner(ends_off(metres)))
    assert (found.pose, found.tried, found.error_code) == (WANTED, 1, 0)


@pytest.mark.parametrize("metres", [0.16, 0.47, 0.7])
async def test_a_plan_that_ends_elsewhere_is_none_and_the_ring_is_asked(metres: float) -> None:
    found = await checked(Planner(ends_off(metres)))
    assert found.pose is not None
    assert 0.1 < math.hypot(found.pose.x - WANTED.x, found.pose.y - WANTED.y) < 0.65
    assert found.error_code == 208


async def test_without_a_ring_it_is_told_how_far_off_the_plan_ended() -> None:
    found = await checked(Planner(ends_off(0.47)), radius_m=0.0)
    assert found.unreachable
    assert "0.47 m" in found.reason


async def test_where_nav2_finds_no_way_out_of_the_robots_own_place_the_goal_is_not_blamed() -> None:
    """NavFn answers 208 for a start in an obstacle, or, near by, a plan that ends where it begins."""
    planner = Planner(lambda goal: to(HERE) if math.hypot(goal.x - HERE.x, goal.y - HERE.y) < 0.7 else Path((), 208))
    found = await checked(planner)
    assert (found.pose, found.error_code, found.unreachable) == (None, 205, False)
    assert len(planner.asked) == 2
    assert "where the robot stands" in found.reason


async def test_a_goal_that_is_to_blame_itself_costs_one_more_question() -> None:
    planner = Planner(
        lambda goal: Path((), 208) if math.hypot(goal.x - WANTED.x, goal.y - WANTED.y) < 0.7 else to(goal)
    )
    found = await checked(planner, radius_m=0.0)
    assert (found.error_code, found.unreachable) == (208, True)
    assert len(planner.asked) == 2


def candidate(x: float, rank: int, cost_m: float = 0.0) -> CandidatePose:
    return CandidatePose(pose=Pose2D(x=x, y=1.0, yaw=0.0), rank=rank, cost_m=cost_m)


async def best(planner: Any, *candidates: CandidatePose, radius_m: float = 0.0, **changes: Any) -> PathCheck:
    return await PathChecker(planner, PathLimits(**changes)).best(GoalRegion(candidates, radius_m))


async def test_of_the_lowest_rank_with_a_path_the_cheapest_wins_and_what_must_be_dearer_is_not_asked_for() -> None:
    planner = Planner(lambda goal: Path((), 208) if goal.x == 2.0 else to(goal))
    ranks = candidate(2.0, 0), candidate(4.0, 1), candidate(3.0, 1, 0.5), candidate(2.5, 1, 3.0), candidate(1.5, 2)
    found = await best(planner, *ranks)
    assert (found.candidate, found.pose) == (2, ranks[2].pose)
    assert [goal.x for goal in planner.asked if goal.y == 1.0 and goal.x != 1.6] == [2.0, 3.0]


async def test_a_longer_way_round_loses_to_a_candidate_that_lies_farther_off() -> None:
    planner = Planner(lambda goal: Path((HERE, Pose2D(x=1.0, y=4.0, yaw=0.0), goal)) if goal.x == 2.0 else to(goal))
    assert (await best(planner, candidate(2.0, 0), candidate(3.0, 0))).candidate == 1


async def test_the_ring_comes_after_every_candidate_and_is_none_of_them() -> None:
    planner = Planner(lambda goal: Path((), 206) if goal.x in {2.0, 4.0} else to(goal))
    found = await best(planner, candidate(2.0, 0), candidate(4.0, 1), radius_m=0.6)
    assert found.candidate is None
    assert found.pose is not None
    assert math.hypot(found.pose.x - 2.0, found.pose.y - 1.0) < 0.61


async def test_a_candidate_outside_the_map_is_not_asked_for() -> None:
    planner = Planner(to)
    assert (await best(planner, candidate(90.0, 0), candidate(3.0, 1))).candidate == 1
    assert [goal.x for goal in planner.asked] == [3.0]


async def test_the_number_of_questions_is_bounded() -> None:
    planner = Planner(lambda goal: Path((), 206))
    found = await best(planner, *(candidate(2.0 + k / 10.0, k) for k in range(9)), preflight_poses_max=5)
    assert (found.pose, found.tried, len(planner.asked)) == (None, 5, 5)


async def test_without_a_planner_the_first_candidate_in_the_map_is_driven_to() -> None:
    def away(_: Pose2D) -> Path:
        raise UnavailableError("nav2", "no planner")

    outside = CandidatePose(pose=Pose2D(x=900.0, y=0.0, yaw=0.0))
    region = GoalRegion((outside, CandidatePose(pose=WANTED)), 0.6)
    found = await best_or_first(PathChecker(cast("Robot", Planner(away)), PathLimits()), region)
    assert (found.pose, found.candidate) == (WANTED, 1)
