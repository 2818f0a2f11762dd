"""The mission under way as spans: one of all of it, and inside it one of each state it is in. Its time is counted."""

from contextlib import AbstractContextManager

from opentelemetry.trace import Span

from contracts.mission import MissionState, Outcome
from coordinator.core.mission import Mission
from coordinator.metrics import MISSIONS
from mesh.tracing import NO_SPAN, Tracer, failed, inside, trace_id

TRACER = Tracer(__name__)
FAULTS = frozenset({Outcome.ABORTED, Outcome.INTERRUPTED})
"""A mission that found nothing, was unsure or was cancelled did what it should."""


class MissionTrace:
    """What is done inside `inside()` belongs to the mission. It begins in the trace of the command it came from."""

    def __init__(self) -> None:
        self.id = ""
        """Of the trace of the mission under way, or of the last one."""
        self._mission: Span = NO_SPAN
        self._here: Span = NO_SPAN
        self._state: MissionState | None = None

    def begin(self, mission_id: str, command: str) -> None:
        self._mission = self._here = TRACER.begin("mission", {"mission.id": mission_id, "mission.command": command})
        self._state = None
        with inside(self._mission):
            self.id = trace_id()

    def inside(self) -> AbstractContextManager[Span]:
        return inside(self._here)

    def enter(self, mission: Mission) -> None:
        """Before what was decided is done: it belongs to the state that the mission is in now."""
        if self._mission is NO_SPAN or mission.state is self._state or mission.state.resting:
            return
        self._leave_state()
        self._state = mission.state
        with inside(self._mission):
            self._here = TRACER.begin(mission.state.value)

    def leave(self, mission: Mission, now_s: float) -> None:
        """After it was done: a mission that is over has its last span."""
        if self._mission is NO_SPAN or mission.running:
            return
        self._leave_state()
        outcome = mission.outcome.value if mission.outcome is not None else ""
        MISSIONS.labels(mission.kind.value, outcome).observe(now_s - mission.started_s)
        self._mission.set_attributes({"mission.outcome": outcome, "mission.reason": mission.reason})
        if mission.outcome in FAULTS:
            failed(self._mission, mission.reason)
        self._mission.end()
        self._mission = self._here = NO_SPAN

    def _leave_state(self) -> None:
        if self._here is not self._mission:
            self._here.end()
            self._here = self._mission
