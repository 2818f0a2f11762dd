"""What a person asks of a mission: start, cancel, pause, resume (requirement A1)."""

from dataclasses import replace
from typing import assert_never

from contracts.mission import EndCause, EventKind, MissionKind, MissionState, Outcome
from coordinator.core import events as ev
from coordinator.core.activities import Entering, Paused
from coordinator.core.mission import Mission, Order, Search
from coordinator.core.outcomes import end
from coordinator.core.search import new_scan
from coordinator.core.step_context import Draft


def handle(
    draft: Draft, event: ev.MissionStarted | ev.DockingStarted | ev.CancelAsked | ev.PauseAsked | ev.ResumeAsked
) -> None:
    match event:
        case ev.MissionStarted():
            _start(draft, event)
        case ev.DockingStarted():
            _start_docking(draft, event)
        case ev.CancelAsked():
            if draft.mission.running:
                end(draft, Outcome.CANCELED, "cancelled by a person", EndCause.PERSON, cause="a person asked for it")
        case ev.PauseAsked():
            _pause(draft)
        case ev.ResumeAsked():
            _resume(draft)
        case _:
            assert_never(event)


def _start(draft: Draft, event: ev.MissionStarted) -> None:
    mission = draft.mission
    if mission.state is not MissionState.IDLE:
        return
    draft.mission = replace(
        _fresh(draft, event.mission_id, event.order),
        command=event.command,
        target=event.target,
        colour=event.colour,
        parser=event.parser,
        last_seen=event.last_seen,
        search=Search(views=event.views[: mission.rules.memory_views_max]),
    )
    draft.say(EventKind.START, f"'{event.command}': looking for the {event.target.description} ({event.target.label})"
              + (f"; {event.notes}" if event.notes else ""), parser=event.parser)  # fmt: skip
    if draft.search.views:
        places = len(draft.search.views)
        where = "one place: going there" if places == 1 else f"{places} places: the best first"
        draft.go(MissionState.MEMORY_NAV, f"such things were seen at {where}")
    else:
        new_scan(draft, "no place is remembered: looking round here first")


def _start_docking(draft: Draft, event: ev.DockingStarted) -> None:
    if draft.mission.state is not MissionState.IDLE:
        return
    fresh = _fresh(draft, event.mission_id, event.order)
    draft.mission = replace(fresh, kind=MissionKind.DOCK, command="dock")
    draft.say(EventKind.START, f"to the dock: {event.why}")
    draft.go(MissionState.MEMORY_NAV, "the dock is a remembered place: driving there")


def _fresh(draft: Draft, mission_id: str, order: Order) -> Mission:
    """A mission that begins now, with nothing of the one before but what is known of the robot."""
    before = draft.mission
    return Mission(
        rules=before.rules,
        robot=before.robot,
        calls=before.calls,
        id=mission_id,
        order=order,
        epoch=before.robot.epoch,
        started_s=draft.now_s,
        deadline_s=draft.now_s + before.rules.mission_timeout_s,
        metres_from=before.robot.odometry,
        map_id=before.robot.map_id,
    )


def _pause(draft: Draft) -> None:
    if draft.mission.running and not draft.mission.paused:
        draft.pause(f"paused by a person while {draft.mission.state.value}")


def _resume(draft: Draft) -> None:
    paused = draft.mission.activity
    if not draft.mission.running or not isinstance(paused, Paused):
        return
    draft.set(deadline_s=draft.mission.deadline_s + draft.now_s - paused.since_s)
    draft.say(EventKind.RESUME, f"resumed by a person in {draft.mission.state.value}")
    draft.be(Entering())
