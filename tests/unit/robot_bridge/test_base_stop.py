"""The base's own stop: asked for on the edge, believed by the wheels, never let go against a person."""

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from robot_bridge.safety.base_stop import ANSWER_S_MAX, ASKS_MAX, ECHO_S_MAX, BaseStop, BaseStopState

State = BaseStopState


@pytest.fixture
def base() -> BaseStop:
    """Its service is there and its wheels are enabled."""
    base = BaseStop()
    base.there(True)
    base.heard(True, 0.0)
    return base


def asks(base: BaseStop, *, from_s: float, to_s: float) -> list[bool]:
    """All that a poll every half second asks for."""
    moments = (from_s + step / 2.0 for step in range(int((to_s - from_s) * 2)))
    return [asked for now_s in moments if (asked := base.due(now_s)) is not None]


def test_nothing_is_asked_before_anybody_stops(base: BaseStop) -> None:
    assert asks(base, from_s=0.0, to_s=60.0) == []
    assert base.state(60.0) is State.RELEASED


def test_a_stop_is_asked_for_a_few_times_where_the_wheels_never_say_so(base: BaseStop) -> None:
    base.stopped()
    assert asks(base, from_s=0.0, to_s=3600.0) == [True] * ASKS_MAX
    assert base.state(3600.0) is State.UNCONFIRMED


def test_a_stop_is_asked_for_once_where_the_wheels_say_so(base: BaseStop) -> None:
    base.stopped()
    assert base.due(10.0) is True
    assert base.state(10.1) is State.ASKED
    base.heard(False, 10.2)
    assert asks(base, from_s=10.2, to_s=3600.0) == []
    assert base.state(10.2) is State.ENGAGED


def test_a_reset_lets_go_once_whatever_becomes_of_it(base: BaseStop) -> None:
    base.stopped()
    assert base.due(10.0) is True
    base.heard(False, 10.2)
    base.reset()
    assert asks(base, from_s=20.0, to_s=3600.0) == [False]
    assert base.state(3600.0) is State.HELD


def test_a_second_stop_and_reset_let_go_of_what_the_first_reset_did_not_reach(base: BaseStop) -> None:
    base.stopped()
    base.due(10.0)
    base.heard(False, 10.2)
    base.reset()
    base.due(11.0)
    base.stopped()
    assert base.due(60.0) is True
    base.reset()
    assert base.due(61.0) is False


def test_a_stop_pressed_at_the_robot_is_told_and_never_undone(base: BaseStop) -> None:
    base.heard(False, 10.0)
    assert base.state(10.0) is State.HELD
    assert asks(base, from_s=10.0, to_s=3600.0) == []


def test_a_stop_and_reset_from_afar_do_not_undo_what_was_pressed_at_the_robot_before(base: BaseStop) -> None:
    base.heard(False, 10.0)
    base.stopped()
    assert asks(base, from_s=20.0, to_s=60.0) == [True]
    assert base.state(60.0) is State.ENGAGED
    base.reset()
    assert asks(base, from_s=60.0, to_s=3600.0) == []
    assert base.state(3600.0) is State.HELD
    base.heard(True, 3601.0)
    assert base.state(3601.0) is State.RELEASED


def test_a_reset_without_a_stop_asks_for_nothing(base: BaseStop) -> None:
    base.reset()
    assert asks(base, from_s=0.0, to_s=60.0) == []
    base.heard(False, 60.0)
    base.reset()
    assert asks(base, from_s=60.0, to_s=120.0) == []


def test_a_base_that_is_let_go_at_the_robot_while_latched_is_stopped_again(base: BaseStop) -> None:
    """The robot's button toggles: whoever presses it to stop a robot that is stopped already would release it."""
    base.stopped()
    base.due(10.0)
    base.heard(False, 10.1)
    base.heard(True, 30.0)
    assert base.due(30.0) is True
    base.heard(False, 30.1)
    assert asks(base, from_s=30.1, to_s=3600.0) == []
    base.reset()
    assert base.due(3601.0) is False


def test_a_stop_and_reset_in_quick_succession_are_asked_in_this_order_and_are_no_button(base: BaseStop) -> None:
    base.stopped()
    assert base.due(10.0) is True
    base.reset()
    assert base.due(10.05) is False
    base.heard(False, 10.3)
    assert base.state(10.3) is State.RELEASED
    base.heard(True, 10.4)
    assert asks(base, from_s=10.4, to_s=3600.0) == []
    base.heard(False, 10.4 + 2 * ECHO_S_MAX)
    assert base.state(30.0) is State.HELD


def test_reset_and_stop_in_quick_succession_leave_the_base_stopped(base: BaseStop) -> None:
    base.stopped()
    base.due(10.0)
    base.heard(False, 10.1)
    base.reset()
    base.stopped()
    assert asks(base, from_s=10.2, to_s=20.0) == [True]
    base.heard(True, 20.0)
    assert base.due(20.0 + ANSWER_S_MAX) is True


def test_a_base_that_comes_late_is_told_to_stop_and_one_that_is_away_is_asked_nothing() -> None:
    base = BaseStop()
    base.stopped()
    assert asks(base, from_s=0.0, to_s=60.0) == []
    assert base.state(60.0) is State.MISSING
    base.there(True)
    assert base.due(60.0) is True


def test_a_base_that_comes_back_while_latched_is_told_again_whatever_its_wheels_said_before(base: BaseStop) -> None:
    base.stopped()
    base.due(10.0)
    base.heard(False, 10.1)
    base.there(False)
    base.there(True)
    assert base.due(60.0) is True


def test_a_base_that_comes_back_while_not_latched_is_told_nothing(base: BaseStop) -> None:
    base.stopped()
    base.due(10.0)
    base.heard(False, 10.1)
    base.there(False)
    base.reset()
    base.there(True)
    assert asks(base, from_s=20.0, to_s=3600.0) == []
    assert base.state(3600.0) is State.HELD


@pytest.mark.parametrize("wheels_first", [True, False])
def test_what_an_earlier_bridge_had_asked_for_is_let_go_by_this_ones_reset(wheels_first: bool) -> None:
    base = BaseStop()
    base.there(True)
    steps = [lambda: base.heard(False, 1.0), lambda: base.stopped(restored=True)]
    for step in steps if wheels_first else reversed(steps):
        step()
    assert base.due(2.0) is True
    base.reset()
    assert base.due(3.0) is False


def test_without_a_word_of_the_wheels_a_stop_is_unconfirmed_and_a_reset_lets_go_once() -> None:
    base = BaseStop()
    base.there(True)
    assert base.state(0.0) is State.UNKNOWN
    base.stopped()
    assert asks(base, from_s=0.0, to_s=60.0) == [True] * ASKS_MAX
    assert base.state(60.0) is State.UNCONFIRMED
    base.reset()
    assert asks(base, from_s=60.0, to_s=3600.0) == [False]
    assert base.state(3600.0) is State.UNKNOWN


class BaseStopMachine(RuleBasedStateMachine):
    """Persons at the page and at the robot, a base that comes and goes: what must hold in whatever order."""

    def __init__(self) -> None:
        super().__init__()
        self.base, self.now_s = BaseStop(), 0.0
        self.engaged, self.alive, self.latched = False, False, False
        self.pressed_at_robot = False
        """The base is stopped, and it was somebody at the robot who stopped it, while nothing was latched."""
        self.asked: list[bool] = []
        self.resets = self.edges = 0

    @rule()
    def stop(self) -> None:
        self.base.stopped()
        self.latched, self.edges = True, self.edges + 1
        self.poll()

    @rule()
    def reset(self) -> None:
        self.base.reset()
        self.resets += self.latched
        self.latched = False
        held = self.pressed_at_robot
        before = self.asked.count(False)
        self.poll()
        assert not (held and self.asked.count(False) > before), "let go against a person"

    @precondition(lambda self: self.alive)
    @rule()
    def press_the_robots_button(self) -> None:
        self.now_s += ECHO_S_MAX + 1.0
        self.engaged = not self.engaged
        self.pressed_at_robot = self.engaged and not self.latched
        self.edges += self.latched
        self.base.heard(not self.engaged, self.now_s)
        self.poll()

    @rule(alive=st.booleans())
    def come_or_go(self, alive: bool) -> None:
        self.edges += alive and not self.alive
        self.alive = alive
        self.base.there(alive)
        self.poll()

    @rule(seconds=st.floats(0.1, 100.0))
    def wait(self, seconds: float) -> None:
        self.now_s += seconds
        self.poll()

    def poll(self) -> None:
        """The base does what it is asked, and its wheels say so."""
        while self.alive and (asked := self.base.due(self.now_s)) is not None:
            self.asked.append(asked)
            self.pressed_at_robot = self.pressed_at_robot and asked
            self.engaged = asked
            self.base.heard(not asked, self.now_s)

    @invariant()
    def a_base_that_is_there_is_stopped_while_latched(self) -> None:
        assert self.engaged or not (self.latched and self.alive)

    @invariant()
    def asks_are_bounded_by_what_persons_and_bases_did(self) -> None:
        assert self.asked.count(True) <= ASKS_MAX * self.edges
        assert self.asked.count(False) <= self.resets


TestBaseStopMachine = BaseStopMachine.TestCase
TestBaseStopMachine.settings = settings(max_examples=30, stateful_step_count=25)
