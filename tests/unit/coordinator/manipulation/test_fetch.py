"""A fetch: its table, its happy way, its recoveries and its honest endings, on a simulated clock."""

from collections.abc import Callable
from typing import Any, get_args

import pytest

from contracts.arm import ArmEnd
from contracts.manipulation import FetchCause, FetchEnd, Holding, ManipulationState
from coordinator.manipulation import commands as do
from coordinator.manipulation import events as ev
from coordinator.manipulation.answers import ANSWERED_BY, ARM_ENDS
from coordinator.manipulation.recoveries import HELPS, ONCE_MORE, RECOVERIES, FetchRecovery
from coordinator.manipulation.transitions import ALLOWED, SENTENCES, TASKS, TRANSITIONS, Task, diagram, page
from coordinator.manipulation.words import told
from support.fetch_played import GOAL, Answers, FetchPlayed, all_well
from support.source import ROOT

S, C = ManipulationState, FetchCause
WAY = [S.HOME, S.BASE_ALIGN, S.LOOK, S.PRE_GRASP, S.GRASP, S.LIFT, S.CHECK, S.CARRY, S.CHECK]


def but(when: Callable[[Any], bool], then: Callable[[int], ev.Answer], times: int = 10**6) -> Answers:
    """All well, but for commands `when`, so many times."""
    left = [times]

    def answer(command: do.Command, call: int) -> ev.Answer:
        if left[0] and when(command):
            left[0] -= 1
            return then(call)
        return all_well(command, call)

    return answer


def of(kind: type[Any], **fields: Any) -> Callable[[Any], bool]:
    return lambda one: isinstance(one, kind) and all(getattr(one, name) == value for name, value in fields.items())


def arm(end: ArmEnd) -> Callable[[int], ev.Answer]:
    return lambda call: ev.ArmMoved(call, end)


# the tables


def test_the_tables_name_every_state_task_cause_and_end() -> None:
    assert SENTENCES.keys() == TRANSITIONS.keys() == TASKS.keys() == set(S)
    assert HELPS.keys() == set(C)
    assert RECOVERIES.keys() == set(FetchRecovery)
    assert ARM_ENDS.keys() == set(ArmEnd)
    assert ANSWERED_BY.keys() == set(Task)
    assert all(cause.sentence for cause in C)
    assert set(ANSWERED_BY.values()) == set(get_args(ev.Answer)) - {ev.ManipulationCallFailed}


def test_every_task_is_done_somewhere() -> None:
    done = {task for tasks in TASKS.values() for task in tasks}
    assert done | {task for each in RECOVERIES.values() for task in each.clear} == set(Task)


def test_every_state_is_reached_and_left_and_is_drawn() -> None:
    assert all(any(state in to for to in ALLOWED.values()) for state in S)
    assert all(S.IDLE in ALLOWED[state] for state in set(S) - {S.IDLE}), "a stop ends it from everywhere"
    assert all(state.value in diagram() for state in S)


def test_the_page_of_the_states_is_the_table() -> None:
    assert (ROOT / "docs/manipulation-states.md").read_text(encoding="utf-8") == page()


# the way


def test_a_thing_is_fetched_and_handed_over() -> None:
    played = FetchPlayed().begin().play()
    assert played.states == [*WAY, S.DELIVER, S.HOME, S.IDLE]
    assert played.finish == do.FinishFetch(FetchEnd.DELIVERED)


def test_a_thing_is_fetched_and_put_down() -> None:
    played = FetchPlayed().begin(hand_over=False).play()
    assert played.states == [*WAY, S.PLACE, S.HOME, S.IDLE]
    assert played.finish == do.FinishFetch(FetchEnd.PLACED)


def test_nothing_drives_before_the_arm_is_folded() -> None:
    played = FetchPlayed().begin().play()
    last: do.Command | None = None
    for one in played.told:
        if isinstance(one, do.DriveBase):
            assert isinstance(last, do.FoldArm)
        if isinstance(one, do.FoldArm | do.MoveArm):
            last = one


def test_one_thing_at_a_time() -> None:
    played = FetchPlayed().begin()
    assert played.feed(ev.FetchBegun(GOAL)) == ()


# recoveries


@pytest.mark.parametrize(
    ("answers", "recovery"),
    [
        (but(of(do.MoveJaw, open=False), arm(ArmEnd.COMPLETED), 1), FetchRecovery.LOOK_AGAIN),
        (but(of(do.MoveArm, task=Task.MOVE_BEFORE), arm(ArmEnd.OFF_PATH), 1), FetchRecovery.ANOTHER_GRASP),
        (but(of(do.MoveArm, task=Task.MOVE_TO), arm(ArmEnd.REJECTED), 1), FetchRecovery.ANOTHER_GRASP),
        (but(of(do.MoveArm, task=Task.RAISE), arm(ArmEnd.NOT_REACHED), 1), FetchRecovery.AGAIN),
        (but(of(do.CheckHold), lambda call: ev.HoldChecked(call, Holding.UNKNOWN), 1), FetchRecovery.AGAIN),
        (but(of(do.CheckHold), lambda call: ev.HoldChecked(call, Holding.EMPTY), 1), FetchRecovery.LOOK_AGAIN),
        (but(of(do.LookAtThing), lambda call: ev.ThingLooked(call, seen=False), 1), FetchRecovery.LOOK_AGAIN),
        (but(of(do.LookAtThing), lambda call: ev.ThingLooked(call, seen=False), 3), FetchRecovery.STAND_ELSEWHERE),
        (but(of(do.PlanGrasps), lambda call: ev.GraspsPlanned(call, 0), 1), FetchRecovery.STAND_ELSEWHERE),
        (but(of(do.DriveBase, carrying=False), lambda call: ev.BaseMoved(call, reached=False), 1),
         FetchRecovery.STAND_ELSEWHERE),
        (but(of(do.DriveBase, carrying=True), lambda call: ev.BaseMoved(call, reached=False), 1), FetchRecovery.AGAIN),
        (but(of(do.PlanStance), ev.ManipulationCallFailed, 2), FetchRecovery.AGAIN),
        (but(of(do.FoldArm), arm(ArmEnd.ABORTED), 1), FetchRecovery.AGAIN),
    ],
)  # fmt: skip
def test_the_smallest_recovery_that_can_help_is_tried_and_the_thing_is_brought(
    answers: Answers, recovery: FetchRecovery
) -> None:
    played = FetchPlayed(answers).begin().play()
    assert played.fetch.used[-1] is recovery
    assert played.finish.end is FetchEnd.DELIVERED


@pytest.mark.parametrize(
    ("answers", "end", "cause"),
    [
        (but(of(do.PlanStance), lambda call: ev.StancePlanned(call, None)), FetchEnd.NOT_TAKEN, C.NO_STANCE),
        (but(of(do.DriveBase), lambda call: ev.BaseMoved(call, reached=False)), FetchEnd.NOT_TAKEN, C.NOT_NEAR),
        (but(of(do.LookAtThing), lambda call: ev.ThingLooked(call, seen=False)), FetchEnd.NOT_TAKEN, C.NOT_SEEN),
        (but(of(do.PlanGrasps), lambda call: ev.GraspsPlanned(call, 0, C.TOO_WIDE)), FetchEnd.NOT_TAKEN, C.TOO_WIDE),
        (but(of(do.MoveJaw, open=True), arm(ArmEnd.STALLED)), FetchEnd.NOT_TAKEN, C.JAW_JAMMED),
        (but(of(do.MoveJaw, open=False), arm(ArmEnd.COMPLETED)), FetchEnd.NOT_TAKEN, C.MISSED),
        (but(of(do.MoveArm, task=Task.MOVE_TO), arm(ArmEnd.REJECTED)), FetchEnd.NOT_TAKEN, C.ARM_REFUSED),
        (but(of(do.MoveArm, task=Task.MOVE_TO), arm(ArmEnd.CANCELED)), FetchEnd.NOT_TAKEN, C.TAKEN_OVER),
        (but(of(do.CheckHold), lambda call: ev.HoldChecked(call, Holding.EMPTY)), FetchEnd.NOT_TAKEN, C.SLIPPED),
        (but(of(do.CheckHold), lambda call: ev.HoldChecked(call, Holding.UNKNOWN)), FetchEnd.NOT_TAKEN, C.UNSURE),
        (but(of(do.MoveArm, task=Task.RAISE), arm(ArmEnd.OFF_PATH)), FetchEnd.NOT_BROUGHT, C.ARM_HELD_UP),
        (but(of(do.DriveBase, carrying=True), lambda call: ev.BaseMoved(call, reached=False)),
         FetchEnd.NOT_BROUGHT, C.NOT_THERE),
        (but(of(do.AwaitHand), lambda call: ev.HandWaited(call, taken=False)), FetchEnd.NOT_BROUGHT, C.NOBODY_TOOK_IT),
        (but(of(do.FoldArm), arm(ArmEnd.ABORTED)), FetchEnd.NOT_TAKEN, C.ARM_HELD_UP),
        (but(of(do.PlanGrasps), ev.ManipulationCallFailed), FetchEnd.NOT_TAKEN, C.NO_ANSWER),
    ],
)  # fmt: skip
def test_when_nothing_helps_the_end_says_what_it_was(answers: Answers, end: FetchEnd, cause: FetchCause) -> None:
    played = FetchPlayed(answers).begin().play()
    assert (played.finish.end, played.finish.cause) == (end, cause)


def test_where_there_is_nowhere_else_to_stand_the_end_says_what_was_wrong_here() -> None:
    stances = iter([ev.StancePlanned])
    answers = but(of(do.PlanGrasps), lambda call: ev.GraspsPlanned(call, 0, C.NO_ROOM))
    played = FetchPlayed(
        lambda one, call: (
            ev.StancePlanned(call, None)
            if isinstance(one, do.PlanStance) and next(stances, None) is None
            else answers(one, call)
        )
    )
    assert played.begin().play().finish == do.FinishFetch(FetchEnd.NOT_TAKEN, C.NO_ROOM)


def test_an_arm_that_is_still_folded_is_not_cleared_away() -> None:
    played = FetchPlayed(but(of(do.PlanGrasps), lambda call: ev.GraspsPlanned(call, 0), 1)).begin().play(until=S.GRASP)
    assert [one.task for one in played.told if isinstance(one, do.MoveArm)] == [Task.MOVE_BEFORE, Task.MOVE_TO]


def test_what_it_holds_is_never_let_go_by_a_recovery() -> None:
    played = FetchPlayed(but(of(do.DriveBase, carrying=True), lambda call: ev.BaseMoved(call, reached=False)))
    played.begin().play()
    assert [one.open for one in played.told if isinstance(one, do.MoveJaw)] == [True, False]


def test_what_is_lost_on_the_way_is_looked_for_and_carried_once_more() -> None:
    played = FetchPlayed().begin().play(until=S.CARRY)
    played.feed(ev.HoldLost())
    assert any(isinstance(one, do.HaltManipulation) for one in played.told)
    played.waiting = played.waiting[-1:]
    played.play()
    assert played.finish.end is FetchEnd.DELIVERED
    assert played.states.count(S.CARRY) == 2


def test_what_is_put_down_stays_put_down_though_the_arm_is_held_up_afterwards() -> None:
    played = FetchPlayed(but(of(do.MoveArm, task=Task.BACK_OFF), arm(ArmEnd.OFF_PATH))).begin(hand_over=False).play()
    assert played.finish == do.FinishFetch(FetchEnd.PLACED)


def test_an_end_that_the_arm_cannot_fold_for_says_so() -> None:
    played = FetchPlayed().begin().play(until=S.DELIVER)
    played.answers = but(of(do.FoldArm), arm(ArmEnd.OFF_PATH))
    played.play()
    assert played.finish == do.FinishFetch(FetchEnd.DELIVERED, folded=False)


def test_a_service_that_is_silent_is_not_waited_for_longer_than_its_time() -> None:
    played = FetchPlayed().begin()
    played.now_s = played.fetch.rules.arm_s_max
    told_now = played.feed(ev.MomentPassed())
    assert any(isinstance(one, do.HaltManipulation) for one in told_now)
    assert played.fetch.cause is C.NO_ANSWER


def test_out_of_time_the_arm_folds_and_the_end_says_so() -> None:
    played = FetchPlayed().begin().play(until=S.GRASP)
    played.now_s = played.fetch.rules.fetch_s_max
    played.feed(ev.MomentPassed())
    played.waiting = played.waiting[-1:]
    played.play()
    assert played.finish == do.FinishFetch(FetchEnd.NOT_TAKEN, C.TIME_UP)


def test_an_answer_to_a_call_that_was_given_up_changes_nothing() -> None:
    played = FetchPlayed().begin().play(until=S.LOOK)
    before = played.fetch
    assert played.feed(ev.ArmMoved(1, ArmEnd.OFF_PATH)) == ()
    assert played.fetch == before


@pytest.mark.parametrize("cause", list(C))
def test_the_honest_ending_is_made_of_the_cause(cause: FetchCause) -> None:
    assert told(FetchEnd.NOT_TAKEN, cause, "red bottle") == (
        f"I found the red bottle, but could not take it: {cause.sentence}."
    )


def test_only_what_may_be_repeated_with_the_thing_in_the_jaw_is() -> None:
    assert ONCE_MORE & {C.DROPPED, C.SLIPPED, C.MISSED} == set()
