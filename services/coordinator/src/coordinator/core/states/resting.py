"""IDLE, DONE and EMERGENCY_STOP: nothing moves."""

from coordinator.core.activities import Idle
from coordinator.core.events import Event
from coordinator.core.states.state import State
from coordinator.core.step_context import StepContext


class Resting(State):
    def begin(self, context: StepContext) -> None:
        context.set_activity(Idle())

    def handle(self, context: StepContext, event: Event) -> None:
        del context, event
