"""The ten mission states of requirement A12, what each means, and which may follow which."""

from contracts.mission import MissionState

SENTENCES: dict[MissionState, str] = {
    MissionState.IDLE: "Nothing to do.",
    MissionState.MEMORY_NAV: "Driving to a place where such a thing was seen.",
    MissionState.SCANNING: "Turning on the spot and looking.",
    MissionState.MOVING_TO_SCAN: "Driving to the next place of the search.",
    MissionState.CENTERING: "Turning until the target is in the middle of the picture.",
    MissionState.DEPTH_CHECK: "Standing still: measuring the distance and validating.",
    MissionState.APPROACHING: "Driving up to a validated target.",
    MissionState.DRIVING_1M: "Taking one step of about a metre towards a far target.",
    MissionState.DONE: "The target was found; resets by itself.",
    MissionState.EMERGENCY_STOP: "Stopped until RESUME.",
}

_S = MissionState

ALLOWED: dict[MissionState, frozenset[MissionState]] = {
    _S.IDLE: frozenset({_S.MEMORY_NAV, _S.SCANNING, _S.EMERGENCY_STOP}),
    _S.MEMORY_NAV: frozenset({_S.SCANNING, _S.MEMORY_NAV, _S.MOVING_TO_SCAN, _S.CENTERING, _S.IDLE, _S.EMERGENCY_STOP}),
    _S.SCANNING: frozenset({_S.CENTERING, _S.MOVING_TO_SCAN, _S.MEMORY_NAV, _S.IDLE, _S.EMERGENCY_STOP}),
    _S.MOVING_TO_SCAN: frozenset({_S.SCANNING, _S.MOVING_TO_SCAN, _S.CENTERING, _S.IDLE, _S.EMERGENCY_STOP}),
    _S.CENTERING: frozenset({_S.DEPTH_CHECK, _S.SCANNING, _S.APPROACHING, _S.IDLE, _S.EMERGENCY_STOP}),
    _S.DEPTH_CHECK: frozenset(
        {_S.DONE, _S.APPROACHING, _S.DRIVING_1M, _S.SCANNING, _S.CENTERING, _S.IDLE, _S.EMERGENCY_STOP}
    ),
    _S.APPROACHING: frozenset({_S.DONE, _S.CENTERING, _S.IDLE, _S.EMERGENCY_STOP}),
    _S.DRIVING_1M: frozenset({_S.CENTERING, _S.IDLE, _S.EMERGENCY_STOP}),
    _S.DONE: frozenset({_S.IDLE, _S.EMERGENCY_STOP}),
    _S.EMERGENCY_STOP: frozenset({_S.IDLE}),
}
"""The document's arrows, and what its text implies: the next remembered place after a scan (SCANNING to MEMORY_NAV),
exploration when no remembered place is reachable, finishing on the map position when the target leaves the picture
(CENTERING to APPROACHING), looking again when a box grew old (DEPTH_CHECK to CENTERING), and the end of a mission
by cancel, failure or exhaustion (to IDLE) from wherever it is."""

RESTING: frozenset[MissionState] = frozenset({_S.IDLE, _S.DONE, _S.EMERGENCY_STOP})
"""States in which nothing may ask for motion."""
