"""What an answer means for the task that waited for it: done, or why not."""

from typing import Final

from contracts.arm import ArmEnd
from contracts.manipulation import FetchCause, Holding
from coordinator.manipulation import events as ev
from coordinator.manipulation.transitions import Task

_C = FetchCause

ARM_ENDS: Final[dict[ArmEnd, FetchCause | None]] = {
    ArmEnd.COMPLETED: None,
    ArmEnd.STALLED: _C.ARM_HELD_UP,
    ArmEnd.REJECTED: _C.ARM_REFUSED,
    ArmEnd.OFF_PATH: _C.ARM_HELD_UP,
    ArmEnd.NOT_REACHED: _C.ARM_HELD_UP,
    ArmEnd.ABORTED: _C.ARM_HELD_UP,
    ArmEnd.TIMED_OUT: _C.ARM_HELD_UP,
    ArmEnd.STOPPED: _C.TAKEN_OVER,  # the fetch has ended before: see `step`
    ArmEnd.CANCELED: _C.TAKEN_OVER,
    ArmEnd.SESSION_ENDED: _C.NO_ANSWER,
    ArmEnd.SHUT_DOWN: _C.NO_ANSWER,
}
"""Of a motion of the joints, and of the jaw beside what `_jaw` says."""

ANSWERED_BY: Final[dict[Task, type[ev.Answer]]] = {
    Task.FOLD: ev.ArmMoved,
    Task.OPEN: ev.ArmMoved,
    Task.MOVE_BEFORE: ev.ArmMoved,
    Task.MOVE_TO: ev.ArmMoved,
    Task.CLOSE: ev.ArmMoved,
    Task.RAISE: ev.ArmMoved,
    Task.BACK_OFF: ev.ArmMoved,
    Task.HOLD_OUT: ev.ArmMoved,
    Task.MOVE_TO_SPOT: ev.ArmMoved,
    Task.LET_GO: ev.ArmMoved,
    Task.PLAN_STANCE: ev.StancePlanned,
    Task.DRIVE_TO_STANCE: ev.BaseMoved,
    Task.DRIVE_TO_GOAL: ev.BaseMoved,
    Task.LOOK: ev.ThingLooked,
    Task.PLAN_GRASP: ev.GraspsPlanned,
    Task.CHECK_HOLD: ev.HoldChecked,
    Task.AWAIT_HAND: ev.HandWaited,
    Task.PLAN_SPOT: ev.SpotPlanned,
}


def fits(task: Task, event: ev.Answer) -> bool:
    """Whether an answer is of the type that the task waits for; a failed call is of each."""
    return isinstance(event, ev.ManipulationCallFailed | ANSWERED_BY[task])


def why_not(task: Task, event: ev.Answer, *, carried: bool) -> FetchCause | None:
    """What went wrong; none = the task is done. `carried`: the robot has driven to where the thing is wanted."""
    match event:
        case ev.ManipulationCallFailed():
            return _C.NO_ANSWER
        case ev.ArmMoved(end=end):
            return _jaw(task, end) if task in {Task.OPEN, Task.LET_GO, Task.CLOSE} else ARM_ENDS[end]
        case ev.GraspsPlanned(count=count, cause=cause):
            return None if count > 0 else cause or _C.OUT_OF_REACH
        case ev.HoldChecked(holding=holding):
            return _not_held(holding, carried=carried)
        case _:
            return None if _well(event) else _WITHOUT[task]


_WITHOUT: Final[dict[Task, FetchCause]] = {
    Task.PLAN_STANCE: _C.NO_STANCE,
    Task.DRIVE_TO_STANCE: _C.NOT_NEAR,
    Task.DRIVE_TO_GOAL: _C.NOT_THERE,
    Task.LOOK: _C.NOT_SEEN,
    Task.AWAIT_HAND: _C.NOBODY_TOOK_IT,
    Task.PLAN_SPOT: _C.NO_SPOT,
}
"""Why a task that is answered by yes or no was answered by no."""


def _well(event: ev.StancePlanned | ev.BaseMoved | ev.ThingLooked | ev.HandWaited | ev.SpotPlanned) -> bool:
    match event:
        case ev.StancePlanned(stance=stance):
            return stance is not None
        case ev.BaseMoved(reached=well) | ev.ThingLooked(seen=well) | ev.HandWaited(taken=well):
            return well
        case ev.SpotPlanned(found=found):
            return found


def _jaw(task: Task, end: ArmEnd) -> FetchCause | None:
    """A jaw that closes as far as it goes holds nothing; one that is held up holds something."""
    if task is Task.CLOSE:
        return {ArmEnd.STALLED: None, ArmEnd.COMPLETED: _C.MISSED}.get(end, ARM_ENDS[end])
    return _C.JAW_JAMMED if end is ArmEnd.STALLED else ARM_ENDS[end]


def _not_held(holding: Holding, *, carried: bool) -> FetchCause | None:
    match holding:
        case Holding.HELD:
            return None
        case Holding.UNKNOWN:
            return _C.UNSURE
        case Holding.EMPTY:
            return _C.DROPPED if carried else _C.SLIPPED
