"""The states of a fetch, what each means, which may follow which and why, and what is done in each, as data."""

from enum import StrEnum
from typing import Final

from contracts.manipulation import ManipulationState

_S = ManipulationState


class Task(StrEnum):
    """One thing that is done in a state; each is one call of the shell's, answered by one event."""

    FOLD = "fold"
    PLAN_STANCE = "plan_stance"
    DRIVE_TO_STANCE = "drive_to_stance"
    LOOK = "look"
    PLAN_GRASP = "plan_grasp"
    OPEN = "open"
    MOVE_BEFORE = "move_before"
    """Beside the thing, the jaw open, clear of it."""
    MOVE_TO = "move_to"
    """The jaw round the thing."""
    CLOSE = "close"
    RAISE = "raise"
    BACK_OFF = "back_off"
    """From the thing to where the arm came from."""
    CHECK_HOLD = "check_hold"
    DRIVE_TO_GOAL = "drive_to_goal"
    HOLD_OUT = "hold_out"
    AWAIT_HAND = "await_hand"
    PLAN_SPOT = "plan_spot"
    MOVE_TO_SPOT = "move_to_spot"
    LET_GO = "let_go"


SENTENCES: Final[dict[ManipulationState, str]] = {
    _S.IDLE: "Nothing is fetched.",
    _S.HOME: "The arm folds: before anything drives, and before the end is told.",
    _S.BASE_ALIGN: "Driving to stand where the arm reaches the thing.",
    _S.LOOK: "Measuring the thing from there.",
    _S.PRE_GRASP: "Choosing a grasp; the open jaw moves beside the thing.",
    _S.GRASP: "The jaw moves round the thing and closes.",
    _S.LIFT: "Raising it.",
    _S.CHECK: "Finding out whether it is in the jaw.",
    _S.CARRY: "The arm folds with it, and the robot drives to where it is wanted.",
    _S.DELIVER: "Holding it out, and letting go when somebody takes it.",
    _S.PLACE: "Putting it down.",
    _S.RECOVER: "The smallest thing that can help, so often and no more.",
}

_FAILED = "something of it did not work"
_OVER = "the emergency stop, cancelled"
_END = "nothing more can be tried, or out of time"

TRANSITIONS: Final[dict[ManipulationState, dict[ManipulationState, str]]] = {
    _S.IDLE: {_S.HOME: "begun"},
    _S.HOME: {
        _S.BASE_ALIGN: "folded",
        _S.RECOVER: _FAILED,
        _S.HOME: _END,
        _S.IDLE: f"the end is told, folded or not; {_OVER}",
    },
    _S.BASE_ALIGN: {_S.LOOK: "the robot stands there", _S.RECOVER: _FAILED, _S.HOME: _END, _S.IDLE: _OVER},
    _S.LOOK: {_S.PRE_GRASP: "it is seen", _S.RECOVER: _FAILED, _S.HOME: _END, _S.IDLE: _OVER},
    _S.PRE_GRASP: {_S.GRASP: "the jaw is beside it", _S.RECOVER: _FAILED, _S.HOME: _END, _S.IDLE: _OVER},
    _S.GRASP: {_S.LIFT: "the jaw closed on something", _S.RECOVER: _FAILED, _S.HOME: _END, _S.IDLE: _OVER},
    _S.LIFT: {_S.CHECK: "raised", _S.RECOVER: _FAILED, _S.HOME: _END, _S.IDLE: _OVER},
    _S.CHECK: {
        _S.CARRY: "it is in the jaw after lifting",
        _S.DELIVER: "it is in the jaw where it is wanted, to be handed over",
        _S.PLACE: "it is in the jaw where it is wanted, to be put down",
        _S.RECOVER: _FAILED,
        _S.HOME: _END,
        _S.IDLE: _OVER,
    },
    _S.CARRY: {_S.CHECK: "the robot is where the thing is wanted", _S.RECOVER: _FAILED, _S.HOME: _END, _S.IDLE: _OVER},
    _S.DELIVER: {_S.RECOVER: _FAILED, _S.HOME: f"handed over; {_END}", _S.IDLE: _OVER},
    _S.PLACE: {_S.RECOVER: _FAILED, _S.HOME: f"put down; {_END}", _S.IDLE: _OVER},
    _S.RECOVER: {
        _S.BASE_ALIGN: "stand elsewhere",
        _S.LOOK: "look again",
        _S.PRE_GRASP: "another grasp, or once more",
        _S.LIFT: "once more",
        _S.CHECK: "once more",
        _S.CARRY: "once more",
        _S.DELIVER: "once more",
        _S.PLACE: "once more",
        _S.HOME: f"once more; {_END}",
        _S.IDLE: _OVER,
    },
}

ALLOWED: Final[dict[ManipulationState, frozenset[ManipulationState]]] = {
    state: frozenset(to) for state, to in TRANSITIONS.items()
}

TASKS: Final[dict[ManipulationState, tuple[Task, ...]]] = {
    _S.IDLE: (),
    _S.HOME: (Task.FOLD,),
    _S.BASE_ALIGN: (Task.PLAN_STANCE, Task.DRIVE_TO_STANCE),
    _S.LOOK: (Task.LOOK,),
    _S.PRE_GRASP: (Task.PLAN_GRASP, Task.OPEN, Task.MOVE_BEFORE),
    _S.GRASP: (Task.MOVE_TO, Task.CLOSE),
    _S.LIFT: (Task.RAISE,),
    _S.CHECK: (Task.CHECK_HOLD,),
    _S.CARRY: (Task.FOLD, Task.DRIVE_TO_GOAL),
    _S.DELIVER: (Task.HOLD_OUT, Task.AWAIT_HAND, Task.LET_GO),
    _S.PLACE: (Task.PLAN_SPOT, Task.MOVE_TO_SPOT, Task.LET_GO, Task.BACK_OFF),
    _S.RECOVER: (),  # those of the recovery: `recoveries.RECOVERIES`
}
"""What is done in each state, one after another."""

CARRYING: Final = frozenset({_S.LIFT, _S.CHECK, _S.CARRY, _S.DELIVER, _S.PLACE})
"""The thing is in the jaw, until it is let go or known to be lost."""


class ForbiddenStateError(RuntimeError):
    """The core would leave its table: a bug."""


def diagram() -> str:
    """The table as a Mermaid state diagram; the ends, which every state has, are drawn once."""
    lines = ["stateDiagram-v2", "    [*] --> idle"]
    for before, to in TRANSITIONS.items():
        for after, why in to.items():
            if after not in {_S.IDLE, _S.RECOVER} and why != _END:
                lines.append(f"    {before.value} --> {after.value}: {why.replace(';', ' #59;')}")
    lines += [
        "    state every_state <<choice>>",
        f"    every_state --> recover: {_FAILED}",
        f"    every_state --> home: {_END}",
        f"    every_state --> idle: {_OVER}",
    ]
    return "\n".join(lines)


def page() -> str:
    """`docs/manipulation-states.md`, whole."""
    states = "\n".join(
        f"| {state.value} | {sentence} | {', '.join(TASKS[state]).replace('_', ' ')} |"
        for state, sentence in SENTENCES.items()
    )
    return (
        "# The states of a fetch\n\n"
        "Written by `python -m coordinator.write_states --of fetch docs/manipulation-states.md` from "
        "`manipulation/transitions.py`; a test compares them.\n\n"
        f"| state | meaning | what is done, one after another |\n|---|---|---|\n{states}\n\n"
        f"```mermaid\n{diagram()}\n```\n\n"
        "An emergency stop, a stop that came and went, and a cancel lead from every state to idle at once: what moves "
        "is halted, the jaw goes on holding, and nothing more is asked for. What goes wrong leads to recover while a "
        "recovery that can help is left (`manipulation/recoveries.py`), else by way of home to the end with its "
        "cause.\n"
    )
