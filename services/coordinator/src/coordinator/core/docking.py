"""Going home to charge (requirement A15): robot_bridge drives before the dock with Nav2, then the base docks by itself.

It is a mission of its own kind in MEMORY_NAV, the dock being a remembered place: it is watched, paused, cancelled and
stopped like any other.
"""

from contracts.mission import EndCause, EventKind, Outcome
from coordinator.core import actions as do
from coordinator.core.activities import Docking
from coordinator.core.events import Docked, Event
from coordinator.core.outcomes import abort, end
from coordinator.core.step_context import Draft


def begin(draft: Draft) -> None:
    if draft.mission.robot.docked is True:
        end(draft, Outcome.DOCKED, "it stands on its dock", None)
        return
    call, limit_s = draft.call(), draft.rules.dock_timeout_s
    draft.act(do.Dock(call, limit_s))
    draft.be(Docking(call, draft.now_s + limit_s + draft.rules.call_margin_s))
    draft.say(EventKind.DOCK, "driving to the dock and onto it")


def handle(draft: Draft, event: Event) -> None:
    if isinstance(draft.mission.activity, Docking) and isinstance(event, Docked):
        end(draft, Outcome.DOCKED, "docked: charging", None)


def on_failure(draft: Draft, detail: str) -> bool:
    """True when that was the last try: the ending says why."""
    draft.set(dock_tries=draft.mission.dock_tries + 1)
    if draft.mission.dock_tries < draft.rules.dock_tries:
        return False
    abort(draft, EndCause.NOT_DOCKED, f"could not dock in {draft.mission.dock_tries} tries: {detail}")
    return True
