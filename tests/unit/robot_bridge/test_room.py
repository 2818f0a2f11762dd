"""How a robot that stands too near something gets room, and what is said of a goal that the safety filter held."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from contracts.causes import GoalCause, LimitCause, SafetyCause
from contracts.geometry import Twist2D
from contracts.robot import GoalStatus
from robot_bridge.motion.arbiter import ArbitratedCommand
from robot_bridge.motion.navigation_hold import NavigationHold, next_hold
from robot_bridge.navigation.recovery import HELD_S, STUCK_S, explained, is_stuck
from robot_bridge.ports import GoalEnd
from robot_bridge.safety.collision_monitor import Restraint, SafetyLimits
from robot_bridge.safety.room import LEAST_M, ROOM_M, is_crowded, recovery_motion

LIMITS = SafetyLimits()
NOTHING = np.empty((0, 2))
TOUCH_M = LIMITS.footprint_radius_m + LIMITS.side_margin_m
OBSTACLE = Restraint(SafetyCause.OBSTACLE, free_m=0.03)
AHEAD = Twist2D(linear_x=0.2)


def seen(*arcs: tuple[float, float, float]) -> NDArray[np.float64]:
    """Points of a room of 3 m; each arc (from, to, degrees) stands nearer: its distance in m from base_link."""
    deg = np.arange(-180.0, 180.0, 2.0)
    ranges = np.full(deg.shape, 3.0)
    for low, high, distance_m in arcs:
        ranges[(deg >= low) & (deg <= high)] = distance_m
    return np.stack([ranges * np.cos(np.radians(deg)), ranges * np.sin(np.radians(deg))], axis=1)


@pytest.mark.parametrize(("distance_m", "crowded"), [(0.28, True), (0.30, False)])
def test_crowded_is_who_stands_within_the_stop_distance(distance_m: float, crowded: bool) -> None:
    assert is_crowded(seen((-20, 20, distance_m)), LIMITS) is crowded


def test_before_a_wall_it_backs_off_the_way_it_came() -> None:
    way = recovery_motion(seen((-60, 60, 0.25)), NOTHING, LIMITS, may_reverse=True, bumped=False)
    assert way is not None
    assert (way.turn_rad, way.distance_m) == (0.0, -ROOM_M)


def test_with_its_back_to_something_it_turns_to_the_nearest_heading_with_room() -> None:
    points = seen((-20, 20, 0.25), (-180, -160, 0.26), (160, 180, 0.26))
    way = recovery_motion(points, NOTHING, LIMITS, may_reverse=True, bumped=False)
    assert way is not None
    assert math.radians(60) < abs(way.turn_rad) < math.radians(120)
    assert way.distance_m == ROOM_M


def test_who_may_not_reverse_turns_round() -> None:
    way = recovery_motion(seen((-90, 90, 0.25)), NOTHING, LIMITS, may_reverse=False, bumped=False)
    assert way is not None
    assert abs(way.turn_rad) > math.radians(90)
    assert way.distance_m > 0.0


def test_it_drives_no_farther_than_the_safety_filter_would_let_it() -> None:
    stand_m = TOUCH_M + LIMITS.stop_distance_m + 0.12
    way = recovery_motion(
        seen((-120, 120, 0.25), (-180, -150, stand_m), (150, 180, stand_m)),
        NOTHING,
        LIMITS,
        may_reverse=True,
        bumped=False,
    )
    assert way is not None
    assert way.turn_rad == 0.0
    assert -0.125 < way.distance_m < -LEAST_M


def test_hemmed_in_all_round_it_stays() -> None:
    assert recovery_motion(seen((-180, 180, 0.27)), NOTHING, LIMITS, may_reverse=True, bumped=False) is None


def test_who_bumped_into_what_no_laser_sees_goes_back_or_stays() -> None:
    assert recovery_motion(seen(), NOTHING, LIMITS, may_reverse=False, bumped=True) is None
    stand_m = TOUCH_M + LIMITS.stop_distance_m + 0.1
    way = recovery_motion(
        seen((-180, -150, stand_m), (150, 180, stand_m)), NOTHING, LIMITS, may_reverse=True, bumped=True
    )
    assert way is not None
    assert way.turn_rad == 0.0
    assert way.distance_m < 0.0


def test_it_does_not_back_into_what_no_laser_sees() -> None:
    """A scanner that covers 270 degrees; what is ahead of it once it has turned is seen."""
    rear = np.radians(np.arange(140.0, 221.0, 4.0))
    unseen_m = 0.3 * np.stack([np.cos(rear), np.sin(rear)], axis=1)
    motion = recovery_motion(seen((-20, 20, 0.25)), unseen_m, LIMITS, may_reverse=True, bumped=False)
    assert motion is not None
    assert motion.turn_rad != 0.0
    assert motion.distance_m > 0.0


def test_a_hold_counts_from_its_first_tick_and_ends_with_the_first_that_drives() -> None:
    held = ArbitratedCommand(Twist2D(angular_z=0.3), "cmd_vel_nav", AHEAD, (OBSTACLE,))
    turns = ArbitratedCommand(Twist2D(angular_z=0.3), "cmd_vel_nav", Twist2D(angular_z=0.3))
    slow = ArbitratedCommand(Twist2D(linear_x=0.1), "cmd_vel_nav", AHEAD, (LimitCause.ACCELERATION,))
    first = next_hold(None, held, 10.0)
    assert next_hold(None, turns, 10.0) is None
    later = next_hold(next_hold(first, turns, 10.1), held, 10.4)
    assert later == NavigationHold(OBSTACLE, 10.0, 10.4)
    assert next_hold(later, slow, 10.5) is None
    assert next_hold(later, held, 20.0) == NavigationHold(OBSTACLE, 20.0, 20.0)


def test_a_goal_that_the_filter_held_says_so() -> None:
    end = GoalEnd(GoalStatus.ABORTED, 105, "Failed to make progress")
    told, cause = explained(end, NavigationHold(OBSTACLE, 10.0, 18.5))
    assert cause is GoalCause.HELD
    assert told == GoalEnd(GoalStatus.ABORTED, 105, "the safety filter held the robot for 8.5 s: obstacle ahead")


@pytest.mark.parametrize(
    ("code", "hold"),
    [
        (105, None),
        (105, NavigationHold(OBSTACLE, 10.0, 10.0 + HELD_S / 2)),
        (208, NavigationHold(OBSTACLE, 10.0, 30.0)),
    ],
)
def test_where_it_was_something_else_nav2s_own_words_stand(code: int, hold: NavigationHold | None) -> None:
    end = GoalEnd(GoalStatus.ABORTED, code, "said by Nav2")
    assert explained(end, hold) == (end, GoalCause.NAV2)


@pytest.mark.parametrize("status", [GoalStatus.SUCCEEDED, GoalStatus.CANCELED])
def test_of_a_goal_that_was_not_aborted_nothing_is_explained(status: GoalStatus) -> None:
    end = GoalEnd(status)
    assert explained(end, NavigationHold(OBSTACLE, 10.0, 18.5))[0] == end


@pytest.mark.parametrize(
    ("cause", "held_s", "stuck"),
    [
        (SafetyCause.OBSTACLE, STUCK_S + 0.1, True),
        (SafetyCause.HAZARD, STUCK_S + 0.1, True),
        (SafetyCause.OBSTACLE, STUCK_S - 0.1, False),
        (SafetyCause.OLD_SCAN, 60.0, False),
    ],
)
def test_stuck_is_who_is_held_by_what_another_place_to_start_from_may_cure(
    cause: SafetyCause, held_s: float, stuck: bool
) -> None:
    assert is_stuck(NavigationHold(Restraint(cause), 10.0, 10.0 + held_s)) is stuck
    assert not is_stuck(None)
