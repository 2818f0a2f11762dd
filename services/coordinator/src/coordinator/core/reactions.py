"""What a mission does when a rotation or a drive ends, in each of its states: decided here, once, as data."""

from enum import StrEnum
from typing import assert_never

from contracts.mission import EndCause, MissionState
from contracts.motion import MotionEnd
from coordinator.core.events import MotionEnded
from coordinator.core.outcomes import abort
from coordinator.core.step_context import StepContext


class Reaction(StrEnum):
    GO_ON = "go on"
    """The state goes on with what comes next."""
    AS_NEAR_AS_IT_GETS = "as near as it gets"
    """Something is in the way: what is left is measured, and the approach may end there."""
    REPEAT = "repeat"
    """After a pause the state is taken up again; many in a row end the mission with the cause."""
    SET_ASIDE = "set aside"
    """The candidate is left as one that may be it, and the search goes on elsewhere."""
    PAUSE = "pause"
    """The mission pauses, says why and waits for a person."""
    END = "end"
    """The plain motion is over, and the mission with it: nobody asked for a way round."""
    IGNORE = "ignore"
    """No rotation or drive belongs to this state."""


_E, _R, _S = MotionEnd, Reaction, MissionState

_MOVING: dict[MotionEnd, Reaction] = {
    _E.COMPLETED: _R.GO_ON,
    _E.BLOCKED: _R.REPEAT,
    _E.HAZARD: _R.REPEAT,
    _E.LIFTED: _R.PAUSE,
    _E.BLIND: _R.REPEAT,
    _E.NO_SCAN: _R.REPEAT,
    _E.NO_ODOMETRY: _R.REPEAT,
    _E.TIMED_OUT: _R.REPEAT,
    _E.HELD_BACK: _R.REPEAT,
    _E.PREEMPTED: _R.REPEAT,
    _E.BASE_BUSY: _R.REPEAT,
    _E.STOPPED: _R.REPEAT,
    _E.RESET: _R.REPEAT,
    _E.SESSION_ENDED: _R.REPEAT,
    _E.CLIENT_LEFT: _R.REPEAT,
    _E.CANCELED: _R.REPEAT,
    _E.SHUT_DOWN: _R.REPEAT,
}
"""Where no state says otherwise. A lifted robot must not drive off by itself when it is put down."""

_TO_IT: dict[MotionEnd, Reaction] = {**_MOVING, _E.HAZARD: _R.SET_ASIDE, _E.BLIND: _R.SET_ASIDE}
"""On the way to a candidate. A bump and a cliff are no arrival: what was met is not known to be what was looked for,
and beyond an edge nothing was reached. Where the laser is blind the robot does not grope its way.
"""

_AS_ASKED: dict[MotionEnd, Reaction] = {
    **_MOVING, _E.BLOCKED: _R.END, _E.HAZARD: _R.END, _E.BLIND: _R.END, _E.TIMED_OUT: _R.END, _E.PREEMPTED: _R.END,
}  # fmt: skip
"""Of a drive or a turn that was asked for itself: what is in the way is told, and who asked decides what follows. A
person who took the stick has moved it elsewhere."""

_NO_MOTION: dict[MotionEnd, Reaction] = dict.fromkeys(MotionEnd, _R.IGNORE)

REACTIONS: dict[MissionState, dict[MotionEnd, Reaction]] = {
    _S.IDLE: _NO_MOTION,
    _S.MEMORY_NAV: _NO_MOTION,
    _S.MOVING_TO_SCAN: _NO_MOTION,
    _S.DEPTH_CHECK: _NO_MOTION,
    _S.EXPLORING: _NO_MOTION,
    _S.DONE: _NO_MOTION,
    _S.EMERGENCY_STOP: _NO_MOTION,
    _S.SCANNING: _MOVING,
    _S.MOVING: _AS_ASKED,
    _S.CENTERING: {**_MOVING, _E.TIMED_OUT: _R.GO_ON},
    _S.DRIVING_1M: {**_TO_IT, _E.BLOCKED: _R.GO_ON, _E.TIMED_OUT: _R.GO_ON},
    _S.APPROACHING: {**_TO_IT, _E.BLOCKED: _R.AS_NEAR_AS_IT_GETS, _E.TIMED_OUT: _R.GO_ON},
}


def react(context: StepContext, ended: MotionEnded) -> Reaction:
    """The reaction; what is the same in every state (REPEAT, PAUSE) is done here already."""
    reaction = REACTIONS[context.mission.state][ended.end]
    match reaction:
        case Reaction.REPEAT:
            _repeat(context, ended)
        case Reaction.PAUSE:
            lifted(context)
        case Reaction.GO_ON | Reaction.AS_NEAR_AS_IT_GETS:
            context.update(cut_off=0)
        case Reaction.SET_ASIDE | Reaction.END | Reaction.IGNORE:
            pass
        case _:
            assert_never(reaction)
    return reaction


def lifted(context: StepContext) -> None:
    """Pauses. Where the candidate was measured to be does not hold for a robot that was carried: it is forgotten."""
    if context.mission.candidate is not None:
        context.update_candidate(map_xy=None, odom_xy=None, track=None)
    context.pause(f"{MotionEnd.LIFTED.sentence}: paused until a person resumes it")


def _repeat(context: StepContext, ended: MotionEnded) -> None:
    why = ended.text or ended.end.sentence
    context.update(cut_off=context.mission.cut_off + 1)
    if context.mission.cut_off >= context.rules.failures_max:
        abort(
            context, EndCause.CANNOT_MOVE, f"the robot would not move, {context.mission.cut_off} times in a row: {why}"
        )
    else:
        context.retry_later("robot_bridge", f"the motion ended early ({why})", stopped=ended.end is MotionEnd.STOPPED)


def section() -> str:
    """The table as a part of `docs/mission-states.md`; states without a motion of their own are left out."""
    states = [state for state, ends in REACTIONS.items() if ends is not _NO_MOTION]
    head = f"| a turn or a drive ends | {' | '.join(state.value for state in states)} |\n|---|{'---|' * len(states)}\n"
    rows = (
        f"| {end.value}{f': {end.sentence}' if end.sentence else ''} | "
        f"{' | '.join(REACTIONS[state][end].value for state in states)} |\n"
        for end in MotionEnd
    )
    return (
        "\n## When a turn or a drive ends\n\n"
        f"{head}{''.join(rows)}\n"
        "Only an arrival, or an obstacle in the way, lets an approach end as a find: a bump, a cliff, a wheel in the "
        "air or a blind laser never does. What is set aside is told at the end as what may have been it. A wheel that "
        "hangs in the air for a second pauses the mission in every state, and where the thing was measured to be is "
        "forgotten.\n"
    )
