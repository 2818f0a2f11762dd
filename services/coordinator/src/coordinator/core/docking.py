"""Driving home to charge (requirement A15): to the place before the dock, then the base docks by itself.

It is a mission of its own kind in MEMORY_NAV, the dock being a remembered place: it is watched, paused, cancelled and
stopped like any other.
"""

from contracts.mission import Outcome
from contracts.robot import GoalStatus
from coordinator.core import actions as do
from coordinator.core.activities import ChoosingPath, Docking, Going
from coordinator.core.draft import Draft
from coordinator.core.endings import abort, end
from coordinator.core.events import Docked, Event, GoalEnded, PathChosen
from coordinator.core.geometry import around, distance_m

NEAR_M = 0.3


def begin(draft: Draft) -> None:
    mission = draft.mission
    if mission.robot.docked is True:
        end(draft, Outcome.DOCKED, "it stands on its dock")
        return
    approach, here = mission.dock_approach, mission.robot.pose
    if approach is None or (here is not None and distance_m(here, approach) <= NEAR_M):
        _dock(draft)
        return
    draft.say("navigation", "to the place before the dock", goal=approach.model_dump())
    groups = ((approach,), around(approach, 0.25, 6))
    draft.choose_path(groups, tuple(0.0 for group in groups for _ in group))


def handle(draft: Draft, event: Event) -> None:
    match draft.mission.activity, event:
        case ChoosingPath(poses=poses), PathChosen(index=index) if index is not None and index < len(poses):
            draft.navigate(poses[index])
        case ChoosingPath(), PathChosen(error=error):
            _not_there(draft, f"no path to the place before the dock ({error or 'no reason given'})")
        case Going(), GoalEnded():
            _goal_ended(draft, event)
        case Docking(), Docked():
            end(draft, Outcome.DOCKED, "docked: charging")
        case _:
            pass


def on_failure(draft: Draft, detail: str) -> bool:
    """True when that was the last try: the ending says why."""
    if not isinstance(draft.mission.activity, Docking):
        return False
    draft.set(dock_tries=draft.mission.dock_tries + 1)
    if draft.mission.dock_tries < draft.rules.dock_tries:
        return False
    abort(draft, f"could not dock in {draft.mission.dock_tries} tries: {detail}")
    return True


def _goal_ended(draft: Draft, event: GoalEnded) -> None:
    going = draft.mission.activity
    assert isinstance(going, Going)
    what = f"{event.status.value} {event.error_code or ''} {event.error}".strip()
    if event.status is GoalStatus.SUCCEEDED:
        _dock(draft)
    elif event.status is GoalStatus.ABORTED and going.tries == 0:
        draft.say("navigation", f"{what}: clearing the costmaps and trying once more from here",
                  error_code=event.error_code)  # fmt: skip
        draft.navigate(going.goal, tries=1)
    else:
        _not_there(draft, what)


def _not_there(draft: Draft, why: str) -> None:
    """The base may see its dock from here all the same: it is asked, and says so when not."""
    draft.say("navigation", f"{why}: asking the base to find its dock from here")
    _dock(draft)


def _dock(draft: Draft) -> None:
    call, limit_s = draft.call(), draft.rules.dock_timeout_s
    draft.act(do.Dock(call, limit_s))
    draft.be(Docking(call, draft.now_s + limit_s + draft.rules.call_margin_s))
    draft.say("dock", "driving onto the dock")
