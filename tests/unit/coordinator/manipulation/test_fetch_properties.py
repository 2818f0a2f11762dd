"""Whatever answers a fetch gets: it ends, it tries nothing for ever, and after a stop nothing moves."""

from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts.arm import ArmEnd
from contracts.manipulation import FetchCause, FetchEnd, Holding, ManipulationState
from coordinator.manipulation import commands as do
from coordinator.manipulation import events as ev
from coordinator.manipulation.answers import ANSWERED_BY
from coordinator.manipulation.fetch import Fetch
from coordinator.manipulation.recoveries import RECOVERIES
from coordinator.manipulation.step import step
from coordinator.manipulation.transitions import TASKS, Task
from support.fetch_played import GOAL, STANCE, Answers, FetchPlayed, all_well

S = ManipulationState
MOST = 600
"""Commands in one fetch, at most: nine recoveries, each followed by no more than the whole way."""
NOT_GRASPED = (FetchCause.OUT_OF_REACH, FetchCause.TOO_WIDE, FetchCause.NO_ROOM)


def as_luck_has_it(chance: Random, luck: float) -> Answers:
    """Of the right type; well with the probability `luck`, else anything: now and then no answer at all."""

    def answer(command: do.Command, call: int) -> ev.Answer:
        if chance.random() < luck:
            return all_well(command, call)
        well = chance.random() < 0.5
        answers: list[ev.Answer] = [ev.ManipulationCallFailed(call)]
        match command:
            case do.FoldArm() | do.MoveArm() | do.MoveJaw():
                answers += [ev.ArmMoved(call, end) for end in ArmEnd if end is not ArmEnd.STOPPED]
            case do.DriveBase():
                answers.append(ev.BaseMoved(call, well))
            case do.PlanStance():
                answers.append(ev.StancePlanned(call, STANCE if well else None))
            case do.LookAtThing():
                answers.append(ev.ThingLooked(call, well))
            case do.PlanGrasps():
                answers += [ev.GraspsPlanned(call, 0, cause) for cause in NOT_GRASPED] + [ev.GraspsPlanned(call, 1)]
            case do.PlanSpot():
                answers.append(ev.SpotPlanned(call, well))
            case do.CheckHold():
                answers += [ev.HoldChecked(call, holding) for holding in Holding]
            case do.AwaitHand():
                answers.append(ev.HandWaited(call, well))
            case _:
                raise AssertionError(f"nobody answers {command}")
        return chance.choice(answers)

    return answer


def holds_together(fetch: Fetch) -> None:
    """What is true after every step."""
    assert fetch.running == bool(fetch.call)
    assert not fetch.running or (fetch.tasks and fetch.until_s > 0.0)
    opens = fetch.state is S.RECOVER and fetch.tasks[0] is Task.OPEN
    assert not opens or fetch.holding is Holding.EMPTY, "what is held is not let go by a recovery"
    for recovery, steps in RECOVERIES.items():
        assert fetch.used.count(recovery) <= steps.most


LUCK = st.floats(0.0, 1.0)
SEEDS = st.integers(0, 2**32)


@settings(max_examples=500, deadline=None)
@given(SEEDS, LUCK, st.booleans())
def test_every_path_ends_once_and_says_how(seed: int, luck: float, hand_over: bool) -> None:
    chance = Random(seed)
    played = FetchPlayed(as_luck_has_it(chance, luck)).begin(hand_over=hand_over)
    while played.fetch.running:
        holds_together(played.fetch)
        assert len(played.told) < MOST
        if chance.random() < 0.03 * (1.0 - luck):
            played.feed(ev.HoldLost())
            played.waiting = [one for one in played.waiting if one.call == played.fetch.call]
        else:
            played.answer_one()
    finish = played.finish
    assert (finish.cause is None) == finish.end.completed
    checks = [answer for answer in played.answers_given if isinstance(answer, ev.HoldChecked)]
    assert not finish.end.completed or checks[-1].holding is Holding.HELD, "only what was held is handed over"
    assert not finish.end.completed or last_jaw(played), "and it was let go"


def last_jaw(played: FetchPlayed) -> bool:
    return [one.open for one in played.told if isinstance(one, do.MoveJaw)][-1]


@settings(max_examples=100, deadline=None)
@given(SEEDS, LUCK, st.integers(0, 15))
def test_what_nobody_answers_ends_by_its_time(seed: int, luck: float, answered: int) -> None:
    played = FetchPlayed(as_luck_has_it(Random(seed), luck)).begin()
    for _ in range(answered):
        if played.fetch.running:
            played.answer_one()
    for _ in range(200):
        played.now_s += 5.0
        played.feed(ev.MomentPassed())
    assert not played.fetch.running
    assert played.finish.end in set(FetchEnd) - {FetchEnd.STOPPED, FetchEnd.CANCELED}


def moves_the_arm(state: ManipulationState, task: int) -> bool:
    return state is S.RECOVER or ANSWERED_BY[TASKS[state][task]] is ev.ArmMoved


def in_each_task() -> list[tuple[ManipulationState, int]]:
    return [(state, k) for state, tasks in TASKS.items() for k in range(len(tasks))] + [(S.RECOVER, 0)]


def brought_to(state: ManipulationState, task: int) -> FetchPlayed:
    if state is S.RECOVER:
        played = FetchPlayed().begin().play(until=S.GRASP)
        played.feed(ev.ArmMoved(played.fetch.call, ArmEnd.OFF_PATH))
        assert played.fetch.state is S.RECOVER
    else:
        played = FetchPlayed().begin(hand_over=state is not S.PLACE).play(until=state)
        played.waiting = played.waiting[-1:]
        for _ in range(task):
            played.answer_one()
    assert played.fetch.state is state
    return played


def stopped_by(played: FetchPlayed, stop: ev.Event) -> None:
    """And whatever comes too late, a reset, and time."""
    played.feed(ev.StopSeen(stopped=False, epoch=0))
    before, call = len(played.told), played.fetch.call
    played.feed(stop)
    for late in (ev.ArmMoved(call, ArmEnd.COMPLETED), ev.ArmMoved(call, ArmEnd.STOPPED), ev.HoldLost()):
        played.feed(late)
    played.feed(ev.StopSeen(stopped=False, epoch=1))
    for _ in range(300):
        played.now_s += 5.0
        played.feed(ev.MomentPassed())
    assert [one for one in played.told[before:] if isinstance(one, do.MOTION | do.ASKING)] == []
    assert played.finish.end is FetchEnd.STOPPED
    assert played.fetch.state is S.IDLE


@pytest.mark.parametrize(("state", "task"), in_each_task())
@pytest.mark.parametrize("latched", [True, False], ids=["latched", "come and gone"])
def test_a_stop_in_each_state_ends_it_and_nothing_moves_after_it(
    state: ManipulationState, task: int, latched: bool
) -> None:
    stopped_by(brought_to(state, task), ev.StopSeen(latched, epoch=1))


@pytest.mark.parametrize(("state", "task"), [each for each in in_each_task() if moves_the_arm(*each)])
def test_a_stop_that_the_arm_tells_first_ends_it_too(state: ManipulationState, task: int) -> None:
    played = brought_to(state, task)
    stopped_by(played, ev.ArmMoved(played.fetch.call, ArmEnd.STOPPED))


def test_nothing_begins_while_it_is_stopped_and_a_reset_begins_nothing() -> None:
    fetch, _ = step(Fetch(), ev.StopSeen(stopped=True, epoch=1), 0.0)
    fetch, commands = step(fetch, ev.FetchBegun(GOAL), 1.0)
    assert commands == ()
    fetch, commands = step(fetch, ev.StopSeen(stopped=False, epoch=1), 2.0)
    assert commands == ()
    fetch, commands = step(fetch, ev.FetchBegun(GOAL), 3.0)
    assert any(isinstance(one, do.FoldArm) for one in commands)


@pytest.mark.parametrize(("state", "task"), in_each_task())
def test_a_cancel_in_each_state_halts_and_asks_for_nothing_more(state: ManipulationState, task: int) -> None:
    played = brought_to(state, task)
    after = played.feed(ev.FetchCanceled())
    assert [type(one) for one in after] == [do.HaltManipulation, do.TellFetchState, do.FinishFetch]
    assert played.finish.end is FetchEnd.CANCELED
