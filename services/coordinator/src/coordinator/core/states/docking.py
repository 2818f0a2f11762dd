"""Going home to charge (requirement A15): robot_bridge drives before the dock with Nav2, then the base docks by itself.

It is a mission of its own kind in MEMORY_NAV, the dock being a remembered place: it is watched, paused, cancelled and
stopped like any other.
"""

from contracts.mission import EndCause, EventKind, Outcome
from coordinator.core import actions as do
from coordinator.core import activities
from coordinator.core.events import Docked, Event
from coordinator.core.outcomes import abort, end
from coordinator.core.states.state import State
from coordinator.core.step_context import StepContext


class GoingToDock(State):
    def begin(self, context: StepContext) -> None:
        if context.mission.robot.docked is True:
            end(context, Outcome.DOCKED, "the robot is on its dock", None)
            return
        call, limit_s = context.call(), context.rules.dock_timeout_s
        context.request(do.Dock(call, limit_s))
        context.set_activity(activities.Docking(call, context.now_s + limit_s + context.rules.call_margin_s))
        context.log_event(EventKind.DOCK, "driving to the dock")

    def handle(self, context: StepContext, event: Event) -> None:
        if isinstance(context.mission.activity, activities.Docking) and isinstance(event, Docked):
            end(context, Outcome.DOCKED, "docked: charging", None)

    def on_call_failed(self, context: StepContext, detail: str) -> bool:
        """True when that was the last try. The ending says why."""
        context.update(dock_tries=context.mission.dock_tries + 1)
        if context.mission.dock_tries < context.rules.dock_tries:
            return False
        abort(context, EndCause.NOT_DOCKED, f"could not dock in {context.mission.dock_tries} tries: {detail}")
        return True
