"""The mission states (the ten of requirement A12, MOVING, EXPLORING): what each means, which may follow which, why."""

from contracts.mission import MissionState

SENTENCES: dict[MissionState, str] = {
    MissionState.IDLE: "Nothing to do.",
    MissionState.MEMORY_NAV: "Driving to a place that is remembered: where such a thing was seen, or the dock.",
    MissionState.SCANNING: "Turning on the spot and looking.",
    MissionState.MOVING_TO_SCAN: "Driving to the next place of the search.",
    MissionState.CENTERING: "Turning until the target is in the middle of the picture.",
    MissionState.DEPTH_CHECK: "Standing still: measuring the distance and validating.",
    MissionState.APPROACHING: "Driving up to a target that was validated, or is on the way (the direct approach).",
    MissionState.MOVING: "Doing the plain motions that were asked for: drives, turns, looks.",
    MissionState.EXPLORING: "Going where nobody has mapped yet: led by a model, the frontiers, or the laser alone.",
    MissionState.DRIVING_1M: "Taking one step of about a metre towards a far target.",
    MissionState.DONE: "The target was found; resets by itself.",
    MissionState.EMERGENCY_STOP: "Stopped until RESUME.",
}

_S = MissionState

_OVER = "cancelled, out of time, or a service stayed away"
_STOP = "emergency stop"

TRANSITIONS: dict[MissionState, dict[MissionState, str]] = {
    _S.IDLE: {
        _S.MEMORY_NAV: "a mission with remembered places, or a low battery and no mission left",
        _S.SCANNING: "a mission without remembered places",
        _S.MOVING_TO_SCAN: "the same, of a room that the robot is not in",
        _S.MOVING: "plain motions were asked for",
        _S.EXPLORING: "an exploration was asked for",
        _S.EMERGENCY_STOP: _STOP,
    },
    _S.MEMORY_NAV: {
        _S.SCANNING: "arrived there, or no remembered place could be reached",
        _S.MEMORY_NAV: "this place cannot be reached: the next one",
        _S.MOVING_TO_SCAN: "no remembered place is left",
        _S.CENTERING: "seen on the way",
        _S.IDLE: f"docked; {_OVER}",
        _S.EMERGENCY_STOP: _STOP,
    },
    _S.SCANNING: {
        _S.CENTERING: "seen",
        _S.MEMORY_NAV: "not here: the next remembered place",
        _S.MOVING_TO_SCAN: "not here, and no remembered place is left",
        _S.IDLE: _OVER,
        _S.EMERGENCY_STOP: _STOP,
    },
    _S.MOVING_TO_SCAN: {
        _S.SCANNING: "arrived",
        _S.MOVING_TO_SCAN: "this place cannot be reached: the next one",
        _S.CENTERING: "seen on the way",
        _S.DRIVING_1M: "every place was looked at: once more to what was refused in doubt",
        _S.IDLE: f"every place was looked at; {_OVER}",
        _S.EMERGENCY_STOP: _STOP,
    },
    _S.CENTERING: {
        _S.DEPTH_CHECK: "in the middle in three pictures",
        _S.SCANNING: "lost for 4 s, or not centred within 15 s",
        _S.APPROACHING: "validated and localised, but out of the picture; seen (the direct approach)",
        _S.IDLE: _OVER,
        _S.EMERGENCY_STOP: _STOP,
    },
    _S.DEPTH_CHECK: {
        _S.DONE: "within reach and validated",
        _S.APPROACHING: "validated, nearer than 1.5 m; measured (the direct approach)",
        _S.DRIVING_1M: "too far to judge, or validated from afar",
        _S.SCANNING: "refused by the votes",
        _S.CENTERING: "the box grew old, or was not in the picture that was judged",
        _S.IDLE: _OVER,
        _S.EMERGENCY_STOP: _STOP,
    },
    _S.APPROACHING: {
        _S.DONE: "within reach, or as near as the map allows",
        _S.CENTERING: "it drifted from the middle, its place is not known, or the way there settled nothing",
        _S.SCANNING: "it cannot be driven up to, or was refused on the way",
        _S.IDLE: _OVER,
        _S.EMERGENCY_STOP: _STOP,
    },
    _S.MOVING: {_S.IDLE: f"all of it is done, or an obstacle stands in the way; {_OVER}", _S.EMERGENCY_STOP: _STOP},
    _S.EXPLORING: {
        _S.SCANNING: "the map shows nothing unknown that can be reached: all of it is looked at instead",
        _S.IDLE: f"explored, or the model silent for too long; {_OVER}",
        _S.EMERGENCY_STOP: _STOP,
    },
    _S.DRIVING_1M: {
        _S.CENTERING: "the step is over, or it drifted from the middle",
        _S.SCANNING: "it cannot be driven up to",
        _S.IDLE: _OVER,
        _S.EMERGENCY_STOP: _STOP,
    },
    _S.DONE: {_S.IDLE: "after 2 s", _S.EMERGENCY_STOP: _STOP},
    _S.EMERGENCY_STOP: {_S.IDLE: "RESUME; nothing goes on by itself"},
}
"""The document's arrows, and what its text implies: the next remembered place after a scan (SCANNING to MEMORY_NAV),
exploration when no remembered place is reachable, finishing on the map position when the target leaves the picture
(CENTERING to APPROACHING), looking again when a box grew old (DEPTH_CHECK to CENTERING), and the end of a mission
by cancel, failure or exhaustion (to IDLE) from wherever it is. A pause changes no state: nothing moves in it until it
is resumed."""

ALLOWED: dict[MissionState, frozenset[MissionState]] = {s: frozenset(to) for s, to in TRANSITIONS.items()}


def diagram() -> str:
    """The table as a Mermaid state diagram; the stop, which reaches every state, is drawn once."""
    lines = ["stateDiagram-v2", "    [*] --> IDLE"]
    for before, to in TRANSITIONS.items():
        for after, why in to.items():
            if after is not _S.EMERGENCY_STOP:
                lines.append(f"    {before.value} --> {after.value}: {why.replace(';', ' #59;')}")
    lines.append("    state every_state <<choice>>")
    lines.append(f"    every_state --> {_S.EMERGENCY_STOP.value}: {_STOP}")
    return "\n".join(lines)


def page() -> str:
    """`docs/mission-states.md`, whole."""
    states = "\n".join(f"| {state.value} | {sentence} |" for state, sentence in SENTENCES.items())
    return (
        "# The states of a mission\n\n"
        "Written by `python -m coordinator.write_states docs/mission-states.md` from `core/transitions.py` and "
        "`core/reactions.py`; a test compares them.\n\n"
        f"| state | meaning |\n|---|---|\n{states}\n\n"
        f"```mermaid\n{diagram()}\n```\n\n"
        "An emergency stop leads from every state to EMERGENCY_STOP. While paused, a mission keeps its state and "
        "nothing moves; a pause to listen ends by itself. Every change of state is a line of the timeline with its "
        "reason in words.\n"
    )
