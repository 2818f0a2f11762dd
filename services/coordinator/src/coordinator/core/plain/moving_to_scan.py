"""MOVING_TO_SCAN by the plain rule (requirement A6): one plan, driven to its end."""

from coordinator.core.states.travelling import MovingToScan
from coordinator.core.step_context import StepContext


class PlannedOnce(MovingToScan):
    def to_next_place(self, context: StepContext) -> None:
        if context.search.plans == 0:
            super().to_next_place(context)
        else:
            self.to_next_point(context)
