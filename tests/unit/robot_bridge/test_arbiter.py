"""Leases: who has the wheels, for how long, and how fast."""

import math

import pytest

from contracts.causes import LimitCause, Refusal, SafetyCause
from contracts.geometry import Twist2D
from contracts.robot import Priority
from robot_bridge.motion.arbiter import Arbiter, ArbiterLimits, Request
from robot_bridge.safety.collision_monitor import Restraint


def asked(source: str = "a", linear_x: float = 0.2, priority: Priority = Priority.MANUAL, **more: object) -> Request:
    values = {"angular_z": 0.0, "duration_s": 1.0, "epoch": 0} | more
    return Request(source, priority, linear_x, **values)  # type: ignore[arg-type]


def freely(twist: Twist2D) -> tuple[Twist2D, None]:
    return twist, None


def settled(arbiter: Arbiter, now_s: float, epoch: int = 0) -> tuple[float, str, tuple[SafetyCause | LimitCause, ...]]:
    """What is sent after 0.4 s of ticks ending at `now_s`."""
    for step in range(8):
        choice = arbiter.choose(now_s - 0.05 * (8 - step), epoch=epoch, restrain=freely)
    choice = arbiter.choose(now_s, epoch=epoch, restrain=freely)
    return choice.twist.linear_x, choice.source, choice.kinds


@pytest.fixture
def arbiter() -> Arbiter:
    return Arbiter(ArbiterLimits())


def test_without_a_lease_zero_is_sent(arbiter: Arbiter) -> None:
    assert settled(arbiter, 10.0)[:2] == (0.0, "none")


def test_the_more_urgent_priority_wins_and_gives_back_when_it_ends(arbiter: Arbiter) -> None:
    arbiter.request(asked("teleop", 0.1, duration_s=2.0), 9.0, epoch=0)
    arbiter.request(asked("nav", 0.25, Priority.NAVIGATION, duration_s=1.5), 9.0, epoch=0)
    assert settled(arbiter, 10.0)[:2] == (0.25, "nav")
    assert settled(arbiter, 10.9)[:2] == (0.1, "teleop")


def test_among_equals_the_one_who_came_first_keeps_the_wheels_by_renewing(arbiter: Arbiter) -> None:
    arbiter.request(asked("first", 0.1), 9.0, epoch=0)
    arbiter.request(asked("second", 0.2), 9.1, epoch=0)
    arbiter.request(asked("first", 0.15), 9.2, epoch=0)
    assert settled(arbiter, 9.7)[:2] == (0.15, "first")


def test_a_lease_ends_at_its_time_at_once(arbiter: Arbiter) -> None:
    arbiter.request(asked(duration_s=0.5), 9.0, epoch=0)
    assert settled(arbiter, 9.49)[0] == 0.2
    assert arbiter.choose(9.5, epoch=0, restrain=freely).twist == Twist2D()


def test_speeding_up_is_limited_and_said_slowing_down_is_not(arbiter: Arbiter) -> None:
    arbiter.choose(9.0, epoch=0, restrain=freely)
    arbiter.request(asked(linear_x=0.3), 9.0, epoch=0)
    choice = arbiter.choose(9.05, epoch=0, restrain=freely)
    assert math.isclose(choice.twist.linear_x, 0.045)
    assert choice.kinds == (LimitCause.ACCELERATION,)
    arbiter.request(asked(linear_x=0.01), 9.05, epoch=0)
    assert arbiter.choose(9.06, epoch=0, restrain=freely).twist.linear_x == 0.01


def test_speed_is_clipped_to_the_base(arbiter: Arbiter) -> None:
    arbiter.request(asked(linear_x=2.0), 9.0, epoch=0)
    assert settled(arbiter, 9.9) == (0.306, "a", (LimitCause.SPEED,))


def test_reverse_needs_permission(arbiter: Arbiter) -> None:
    arbiter.request(asked(linear_x=-0.2), 9.0, epoch=0)
    assert settled(arbiter, 9.5) == (0.0, "a", (LimitCause.NO_REVERSE,))
    arbiter.request(asked(linear_x=-0.2, allow_reverse=True), 9.5, epoch=0)
    assert settled(arbiter, 10.0)[0] == -0.2


def test_a_slowed_robot_reaches_the_slowed_speed_and_not_less(arbiter: Arbiter) -> None:
    arbiter.request(asked(linear_x=0.3), 9.0, epoch=0)

    def third(twist: Twist2D) -> tuple[Twist2D, str]:
        return Twist2D(linear_x=twist.linear_x * 0.3), "slowed"

    for step in range(10):
        choice = arbiter.choose(9.0 + 0.05 * step, epoch=0, restrain=third)
    assert math.isclose(choice.twist.linear_x, 0.09)


@pytest.mark.parametrize(
    ("request_", "why"),
    [
        (asked(linear_x=math.nan), Refusal.NOT_FINITE),
        (asked(angular_z=math.inf), Refusal.NOT_FINITE),
        (asked(stamp_s=math.nan), Refusal.NOT_FINITE),
        (asked(stamp_s=8.0), Refusal.STALE),
        (asked(stamp_s=11.0), Refusal.FROM_THE_FUTURE),
        (asked(epoch=1), Refusal.OLD_EPOCH),
        (asked(priority=Priority.EMERGENCY), Refusal.RESERVED),
        (asked(priority=Priority.SAFETY), Refusal.RESERVED),
        (asked(duration_s=0.0), Refusal.BAD_DURATION),
        (asked(duration_s=2.001), Refusal.BAD_DURATION),
        (asked(duration_s=math.inf), Refusal.BAD_DURATION),
        (asked(duration_s=math.nan), Refusal.BAD_DURATION),
    ],
)
def test_what_makes_no_sense_is_refused_with_a_reason(arbiter: Arbiter, request_: Request, why: Refusal) -> None:
    assert arbiter.request(request_, 10.0, epoch=0) is why
    assert settled(arbiter, 10.5)[1] == "none"


def test_what_was_decided_earlier_does_not_replace_what_was_decided_later(arbiter: Arbiter) -> None:
    assert arbiter.request(asked(stamp_s=10.0), 10.0, epoch=0) is None
    assert arbiter.request(asked(stamp_s=9.9), 10.0, epoch=0) is Refusal.OUT_OF_ORDER
    assert arbiter.request(asked("b", stamp_s=9.9), 10.0, epoch=0) is None


def test_the_number_of_leases_is_bounded(arbiter: Arbiter) -> None:
    refusals = [arbiter.request(asked(f"s{i}"), 10.0, epoch=0) for i in range(40)]
    assert refusals.count(Refusal.TOO_MANY) == 8


@pytest.mark.parametrize("stamp_s", [9.5, 10.1])
def test_the_oldest_and_the_newest_stamp_there_may_be(arbiter: Arbiter, stamp_s: float) -> None:
    assert arbiter.request(asked(stamp_s=stamp_s), 10.0, epoch=0) is None


def test_a_lease_ends_when_the_clock_goes_back_behind_its_beginning(arbiter: Arbiter) -> None:
    arbiter.request(asked(), 10.0, epoch=0)
    assert arbiter.choose(5.0, epoch=0, restrain=freely).source == "none"
    assert arbiter.choose(10.5, epoch=0, restrain=freely).source == "none"


@pytest.mark.parametrize("next_priority", [Priority.NAVIGATION, Priority.EXPLORATION, Priority.MANUAL])
def test_the_end_of_one_source_does_not_set_off_another_without_a_pause(
    arbiter: Arbiter, next_priority: Priority
) -> None:
    arbiter.request(asked("nav", 0.25, Priority.NAVIGATION), 9.0, epoch=0)
    arbiter.request(asked("next", 0.1, next_priority, duration_s=2.0), 9.1, epoch=0)
    assert settled(arbiter, 9.95)[:2] == (0.25, "nav")
    pause = arbiter.choose(10.0, epoch=0, restrain=freely)
    assert (pause.twist, pause.source, pause.kinds) == (Twist2D(), "next", (LimitCause.HANDOVER,))
    assert arbiter.choose(10.05, epoch=0, restrain=freely).twist.linear_x == pytest.approx(0.045)


def test_a_more_urgent_source_takes_over_without_a_pause(arbiter: Arbiter) -> None:
    arbiter.request(asked("teleop", 0.2), 9.5, epoch=0)
    settled(arbiter, 9.95)
    arbiter.request(asked("nav", 0.1, Priority.NAVIGATION), 9.95, epoch=0)
    assert arbiter.choose(10.0, epoch=0, restrain=freely).twist.linear_x == 0.1


def test_turning_round_goes_through_zero(arbiter: Arbiter) -> None:
    arbiter.request(asked(linear_x=0.2, allow_reverse=True), 9.0, epoch=0)
    settled(arbiter, 9.5)
    arbiter.request(asked(linear_x=-0.2, allow_reverse=True), 9.5, epoch=0)
    assert arbiter.choose(9.55, epoch=0, restrain=freely).twist.linear_x == 0.0
    assert arbiter.choose(9.6, epoch=0, restrain=freely).twist.linear_x == pytest.approx(-0.045)


def test_a_long_pause_between_ticks_is_no_licence_to_jump(arbiter: Arbiter) -> None:
    arbiter.choose(9.0, epoch=0, restrain=freely)
    arbiter.request(asked(linear_x=0.3), 9.9, epoch=0)
    assert arbiter.choose(10.0, epoch=0, restrain=freely).twist.linear_x == pytest.approx(0.09)


def test_the_arc_driven_while_gathering_speed_is_watched_too(arbiter: Arbiter) -> None:
    """The wanted arc is free, the one that results from the acceleration limits is not."""

    def only_the_wanted_arc(twist: Twist2D) -> tuple[Twist2D, Restraint | None]:
        if twist.angular_z == 1.5:
            return twist, None
        return Twist2D(angular_z=twist.angular_z), Restraint(SafetyCause.OBSTACLE)

    arbiter.choose(9.0, epoch=0, restrain=freely)
    arbiter.request(asked(linear_x=0.3, angular_z=1.5), 9.0, epoch=0)
    choice = arbiter.choose(9.05, epoch=0, restrain=only_the_wanted_arc)
    assert (choice.twist.linear_x, choice.twist.angular_z) == (0.0, pytest.approx(0.385))
    assert choice.kinds == (LimitCause.ACCELERATION, SafetyCause.OBSTACLE)


def test_a_lease_of_an_older_epoch_sends_zero(arbiter: Arbiter) -> None:
    arbiter.request(asked(), 9.5, epoch=0)
    assert settled(arbiter, 10.0, epoch=1)[:2] == (0.0, "none")
