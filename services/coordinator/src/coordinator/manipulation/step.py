"""`step(fetch, event, now_s) -> (fetch, commands)`: all that a fetch decides; pure."""

from typing import assert_never

from contracts.arm import ArmEnd
from contracts.manipulation import FetchCause, FetchEnd, Holding, ManipulationState
from coordinator.manipulation import commands as do
from coordinator.manipulation import events as ev
from coordinator.manipulation.answers import fits, why_not
from coordinator.manipulation.context import ManipulationContext
from coordinator.manipulation.fetch import Fetch, FetchEnding
from coordinator.manipulation.recoveries import BEGINS_AT, RECOVERIES, FetchRecovery, clearing, that_help
from coordinator.manipulation.transitions import CARRYING, TASKS, ForbiddenStateError, Task

_S = ManipulationState

_NEXT = {
    _S.HOME: _S.BASE_ALIGN,
    _S.BASE_ALIGN: _S.LOOK,
    _S.LOOK: _S.PRE_GRASP,
    _S.PRE_GRASP: _S.GRASP,
    _S.GRASP: _S.LIFT,
    _S.LIFT: _S.CHECK,
    _S.CARRY: _S.CHECK,
}
"""When all tasks of a state are done; the others see to it themselves."""


def step(fetch: Fetch, event: ev.Event, now_s: float) -> tuple[Fetch, tuple[do.Command, ...]]:
    """What `event` at `now_s` makes of the fetch, and what is to be done about it.

    Pure: the same fetch, event and time give the same answer. Raises `ForbiddenStateError` when the core would leave
    its table (a bug, which the property tests look for).
    """
    context = ManipulationContext(fetch, now_s)
    match event:
        case ev.FetchBegun():
            _begin(context, event)
        case ev.FetchCanceled():
            if fetch.running:
                context.finish(FetchEnd.CANCELED, folded=False, why="cancelled")
        case ev.StopSeen():
            _stop_seen(context, event)
        case ev.HoldLost():
            if fetch.ending is None and fetch.holding is Holding.HELD and fetch.state in CARRYING:
                _fail(context, FetchCause.DROPPED)
        case ev.MomentPassed():
            _pass_time(context)
        case _:
            _answer(context, event)
    return context.fetch, tuple(context.commands)


def _begin(context: ManipulationContext, event: ev.FetchBegun) -> None:
    """Nothing begins while another is under way, or while it is stopped."""
    one = context.fetch
    if one.running or one.stopped:
        return
    context.fetch = Fetch(
        rules=one.rules, goal=event.goal, hand_over=event.hand_over, started_s=context.now_s,
        next_call=one.next_call, epoch=one.epoch,
    )  # fmt: skip
    context.become(_S.HOME, "begun")


def _stop_seen(context: ManipulationContext, event: ev.StopSeen) -> None:
    """A stop that came and went between two looks is told by its epoch."""
    one = context.fetch
    rose = one.epoch is not None and event.epoch is not None and event.epoch > one.epoch
    context.update(stopped=event.stopped, epoch=one.epoch if event.epoch is None else event.epoch)
    if one.running and (event.stopped or rose):
        _stop(context)


def _stop(context: ManipulationContext) -> None:
    context.finish(FetchEnd.STOPPED, folded=False, why="the emergency stop")


def _pass_time(context: ManipulationContext) -> None:
    one = context.fetch
    if not one.running:
        return
    if one.ending is None and context.now_s >= one.started_s + one.rules.fetch_s_max:
        _conclude(context, FetchCause.TIME_UP)
    elif context.now_s >= one.until_s:
        _fail(context, FetchCause.NOBODY_TOOK_IT if one.tasks[0] is Task.AWAIT_HAND else FetchCause.NO_ANSWER)


def _answer(context: ManipulationContext, event: ev.Answer) -> None:
    """Answers to calls that were given up are too late."""
    one = context.fetch
    if not one.call or event.call != one.call:
        return
    task = one.tasks[0]
    if not fits(task, event):
        _fail(context, FetchCause.NO_ANSWER)
        return
    if isinstance(event, ev.ArmMoved) and event.end is ArmEnd.STOPPED:
        context.update(call=0)
        _stop(context)
        return
    _learn(context, event)
    cause = why_not(task, event, carried=one.at_goal)
    context.update(call=0)
    if cause is None:
        _done(context, task)
    else:
        _fail(context, cause)


def _learn(context: ManipulationContext, event: ev.Answer) -> None:
    match event:
        case ev.StancePlanned(stance=stance) if stance is not None:
            context.update(stance=stance, tried=(*context.fetch.tried, stance))
        case ev.GraspsPlanned(count=count):
            context.update(grasp=0, grasps=count)
        case ev.HoldChecked(holding=holding):
            context.update(holding=holding)
        case _:
            pass


def _done(context: ManipulationContext, task: Task) -> None:
    match task:
        case Task.CLOSE:
            context.update(holding=Holding.HELD)
        case Task.OPEN:
            context.update(holding=Holding.EMPTY)
        case Task.LET_GO:
            end = FetchEnd.DELIVERED if context.fetch.hand_over else FetchEnd.PLACED
            context.update(holding=Holding.EMPTY, ending=FetchEnding(end))
        case Task.DRIVE_TO_GOAL:
            context.update(at_goal=True)
        case _:
            pass
    context.update(tasks=context.fetch.tasks[1:])
    if context.fetch.tasks:
        context.begin_task()
    else:
        _go_on(context)


def _go_on(context: ManipulationContext) -> None:
    """All tasks of the state are done."""
    one = context.fetch
    match one.state:
        case _S.HOME if one.ending is not None:
            context.finish(one.ending.end, one.ending.cause, folded=True, why="the end is told")
        case _S.CHECK:
            if not one.at_goal:
                context.become(_S.CARRY, "it is in the jaw")
            else:
                context.become(_S.DELIVER if one.hand_over else _S.PLACE, "it is in the jaw, where it is wanted")
        case _S.DELIVER | _S.PLACE:
            context.become(_S.HOME, "handed over" if one.hand_over else "put down")
        case _S.RECOVER:
            _recovered(context)
        case _S.HOME | _S.BASE_ALIGN | _S.LOOK | _S.PRE_GRASP | _S.GRASP | _S.LIFT | _S.CARRY:
            context.become(_NEXT[one.state], "done")
        case _S.IDLE:
            pass
        case _:
            assert_never(one.state)


# what goes wrong


def _fail(context: ManipulationContext, cause: FetchCause) -> None:
    """The smallest recovery that can help and is left; else the end."""
    one = context.fetch
    if one.ending is not None and one.state is _S.HOME:
        context.finish(one.ending.end, one.ending.cause, folded=False, why="the end is told, the arm is not folded")
        return
    if one.ending is not None or one.state is _S.RECOVER:
        _conclude(context, one.cause or cause)
        return
    context.halt()
    if cause is FetchCause.DROPPED:
        context.update(holding=Holding.EMPTY)
    if cause is FetchCause.NO_STANCE and one.tried:
        cause = one.cause or cause  # what was wrong where it has stood says more
    context.update(cause=cause, failed_in=one.state, undone=one.tasks)
    in_jaw = context.fetch.holding is not Holding.EMPTY
    for recovery in that_help(cause, one.state, in_jaw=in_jaw):
        if one.used.count(recovery) < RECOVERIES[recovery].most and _can(one, recovery):
            _recover(context, recovery)
            return
    _conclude(context, cause)


def _can(fetch: Fetch, recovery: FetchRecovery) -> bool:
    return recovery is not FetchRecovery.ANOTHER_GRASP or fetch.grasp + 1 < fetch.grasps


def _recover(context: ManipulationContext, recovery: FetchRecovery) -> None:
    clear = clearing(recovery, context.fetch.state, context.fetch.tasks[0], carried=context.fetch.at_goal)
    context.update(recovery=recovery, used=(*context.fetch.used, recovery))
    if recovery is not FetchRecovery.AGAIN and context.fetch.at_goal:
        context.update(at_goal=False)  # dropped on the way: it has to be carried once more
    cause = context.fetch.cause
    context.become(_S.RECOVER, cause.sentence if cause is not None else "", clear)
    if not clear:
        _recovered(context)


def _recovered(context: ManipulationContext) -> None:
    one = context.fetch
    if one.recovery is None or one.failed_in is None:
        raise ForbiddenStateError("RECOVER is entered with what to do and what failed")
    to = RECOVERIES[one.recovery].to or BEGINS_AT.get(one.failed_in, one.failed_in)
    tasks = one.undone if one.recovery is FetchRecovery.AGAIN and to is one.failed_in else None
    if one.recovery is FetchRecovery.ANOTHER_GRASP:
        context.update(grasp=one.grasp + 1)
        tasks = tuple(task for task in TASKS[to] if task is not Task.PLAN_GRASP)
    context.become(to, one.recovery.value.replace("_", " "), tasks)


def _conclude(context: ManipulationContext, cause: FetchCause) -> None:
    """The end is decided; the arm folds first."""
    one = context.fetch
    context.halt()
    if one.ending is None:
        end = FetchEnd.NOT_BROUGHT if one.holding is Holding.HELD else FetchEnd.NOT_TAKEN
        context.update(ending=FetchEnding(end, cause))
    context.become(_S.HOME, cause.sentence)
