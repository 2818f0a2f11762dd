"""What may help after what went wrong, the smallest first, and how often of each, as data."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from contracts.manipulation import FetchCause, ManipulationState
from coordinator.manipulation.transitions import Task

_C, _S = FetchCause, ManipulationState


class FetchRecovery(StrEnum):
    AGAIN = "again"
    """The task that failed once more: the arm was held up, a service did not answer."""
    ANOTHER_GRASP = "another_grasp"
    """The next of the grasps that were planned; the thing stands as it did."""
    LOOK_AGAIN = "look_again"
    """The thing may have moved."""
    STAND_ELSEWHERE = "stand_elsewhere"


@dataclass(frozen=True, slots=True)
class RecoverySteps:
    """At most so many in one fetch; `clear`: what brings the arm out of the way first; `to`: the state that goes on,
    none = the one that failed, from the task that did."""

    most: int
    clear: tuple[Task, ...]
    to: ManipulationState | None


RECOVERIES: Final[dict[FetchRecovery, RecoverySteps]] = {
    FetchRecovery.AGAIN: RecoverySteps(3, (), None),
    FetchRecovery.ANOTHER_GRASP: RecoverySteps(2, (Task.OPEN, Task.BACK_OFF), _S.PRE_GRASP),
    FetchRecovery.LOOK_AGAIN: RecoverySteps(2, (Task.OPEN, Task.BACK_OFF, Task.FOLD), _S.LOOK),
    FetchRecovery.STAND_ELSEWHERE: RecoverySteps(2, (Task.OPEN, Task.BACK_OFF, Task.FOLD), _S.BASE_ALIGN),
}

_R = FetchRecovery
_CLOSER = (_R.ANOTHER_GRASP, _R.LOOK_AGAIN, _R.STAND_ELSEWHERE)

HELPS: Final[dict[FetchCause, tuple[FetchRecovery, ...]]] = {
    _C.NO_STANCE: (),
    _C.NOT_NEAR: (_R.STAND_ELSEWHERE,),
    _C.NOT_SEEN: (_R.LOOK_AGAIN, _R.STAND_ELSEWHERE),
    _C.OUT_OF_REACH: (_R.STAND_ELSEWHERE,),
    _C.TOO_WIDE: (),
    _C.NO_ROOM: (_R.STAND_ELSEWHERE,),
    _C.ARM_REFUSED: _CLOSER,
    _C.ARM_HELD_UP: _CLOSER,
    _C.JAW_JAMMED: (_R.AGAIN,),
    _C.MISSED: (_R.LOOK_AGAIN, _R.STAND_ELSEWHERE),
    _C.SLIPPED: (_R.LOOK_AGAIN, _R.STAND_ELSEWHERE),
    _C.DROPPED: (_R.LOOK_AGAIN,),
    _C.UNSURE: (_R.AGAIN,),
    _C.NOT_THERE: (_R.AGAIN,),
    _C.NO_SPOT: (),
    _C.NOBODY_TOOK_IT: (),
    _C.TAKEN_OVER: (),
    _C.NO_ANSWER: (_R.AGAIN,),
    _C.TIME_UP: (),
}
"""Of what is not in the jaw, the smallest first."""

ONCE_MORE: Final = frozenset({_C.ARM_REFUSED, _C.ARM_HELD_UP, _C.JAW_JAMMED, _C.UNSURE, _C.NOT_THERE, _C.NO_ANSWER})
"""With the thing in the jaw, and while the arm folds before anything else, only AGAIN can help: whatever opens the jaw
would drop it."""

_FOLDED: Final = frozenset({_S.HOME, _S.BASE_ALIGN, _S.LOOK})
"""The arm is folded, and the jaw holds nothing: nothing has to be cleared. So it is while a grasp is planned."""
_AWAY: Final = frozenset({_S.CARRY, _S.DELIVER, _S.PLACE})
"""The arm has left the place of the grasp: there is nothing to back off from."""

BEGINS_AT: Final = {_S.GRASP: _S.PRE_GRASP}
"""Where a state is begun once more: a jaw that may be closed does not move to the thing."""


def that_help(cause: FetchCause, state: ManipulationState, *, in_jaw: bool) -> tuple[FetchRecovery, ...]:
    """The smallest first."""
    if in_jaw or state is _S.HOME:
        return (FetchRecovery.AGAIN,) if cause in ONCE_MORE else ()
    return HELPS[cause]


def clearing(recovery: FetchRecovery, state: ManipulationState, failed: Task, *, carried: bool) -> tuple[Task, ...]:
    """What brings the arm out of the way first, after `failed` did not work. `carried`: the robot has driven off with
    the thing."""
    if state in _FOLDED or failed is Task.PLAN_GRASP:
        return ()
    clear = RECOVERIES[recovery].clear
    return tuple(task for task in clear if task is not Task.BACK_OFF) if carried or state in _AWAY else clear
