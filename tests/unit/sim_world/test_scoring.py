"""When a robot's pose counts as having found the right thing."""

import math

import pytest

from contracts.geometry import Pose2D
from sim.scoring import NothingToScoreError, Score, score
from sim.world.robot import CAMERA_X_M
from support.simulated_room import world_at


def _score(x: float, y: float, yaw_degrees: float, kind: str = "bottle", colour: str | None = "red") -> Score:
    return score(world_at(Pose2D(x=x, y=y, yaw=math.radians(yaw_degrees))), kind, colour)


def test_half_a_metre_before_the_red_bottle_facing_it_is_correct() -> None:
    result = _score(4.0, 3.0, 0.0)
    assert result.correct
    assert result.thing_id == "bottle_red"
    assert result.true_distance_m == pytest.approx(4.5 - 0.04 - 4.0 - CAMERA_X_M, abs=0.005)
    assert result.horizontal_distance_m == pytest.approx(result.true_distance_m, abs=0.005)
    assert result.in_front[0].id == "bottle_red"


def test_the_same_place_facing_away_is_not_correct() -> None:
    result = _score(3.9, 3.0, 90.0)
    assert not result.facing
    assert not result.correct


def test_a_metre_away_is_not_correct() -> None:
    result = _score(3.3, 3.0, 0.0)
    assert result.facing
    assert not result.correct


def test_standing_before_the_blue_bottle_is_told_as_the_wrong_one() -> None:
    result = _score(3.9, 1.0, 0.0)
    assert not result.correct
    assert result.thing_id == "bottle_red"
    assert (result.in_front[0].kind, result.in_front[0].colour) == ("bottle", "blue")


def test_any_colour_counts_when_none_was_asked_for() -> None:
    assert _score(3.9, 1.0, 0.0, colour=None).thing_id == "bottle_blue"
    assert _score(3.9, 1.0, 0.0, colour=None).correct


def test_a_cup_deep_on_a_table_counts_from_as_near_as_the_map_allows() -> None:
    result = _score(1.5, 2.75, 90.0, "cup", "white")
    assert 0.3 < result.nearest_possible_m < 0.7
    assert result.true_distance_m > result.horizontal_distance_m
    assert result.unobstructed


def test_a_wall_between_robot_and_thing_is_no_arrival() -> None:
    result = _score(4.0, 4.4, math.degrees(math.atan2(-1.4, 0.5)))
    assert result.facing
    assert not result.unobstructed
    assert not result.correct
    assert all(item.id != "bottle_red" for item in result.in_front)


def test_a_thing_the_home_does_not_hold_is_named() -> None:
    with pytest.raises(NothingToScoreError, match="green bottle"):
        _score(2.0, 2.0, 0.0, "bottle", "green")
