"""What every state of a mission answers to."""

from typing import Protocol

from coordinator.core.events import Event
from coordinator.core.step_context import StepContext


class State(Protocol):
    """One state of a mission. It holds nothing itself: all that is known stands in the mission of the context."""

    def begin(self, context: StepContext) -> None:
        """It was entered, or is taken up again: ask for what comes first."""
        ...

    def handle(self, context: StepContext, event: Event) -> None:
        """A frame, a tick, or the answer its activity awaits."""
        ...

    def on_timeout(self, context: StepContext) -> None:
        """No frame came in time, or the time to steer is over."""
        raise AssertionError(f"{self} awaits no frame and steers nothing")

    def on_call_failed(self, context: StepContext, detail: str) -> bool:
        """Returns True if the state goes on without the answer. Else it is taken up again after a pause."""
        del context, detail
        return False
