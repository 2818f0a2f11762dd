"""What the bridge makes of a planner's answers before it sends a goal; the planner is a script with NavFn's habits."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from contracts.geometry import Pose2D
from robot_bridge.navigation.path_check import GoalRegion, PathCheck, PathChecker
from robot_bridge.ports import Path
from robot_bridge.sensing.sensor_readings import Grid, SensorReadings
from robot_bridge.settings import Settings

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
    return await PathChecker(planner, Settings()).nearest(GoalRegion(WANTED, radius_m))


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
