"""What a person asks of a mission: start, cancel, pause, resume (requirement A1)."""

from dataclasses import replace
from typing import assert_never

from contracts.mission import MissionState, Outcome
from coordinator.core import events as ev
from coordinator.core.activities import Entering, Paused
from coordinator.core.draft import Draft
from coordinator.core.endings import end
from coordinator.core.mission import Mission, Search
from coordinator.core.search import new_scan


def handle(draft: Draft, event: ev.MissionStarted | ev.CancelAsked | ev.PauseAsked | ev.ResumeAsked) -> None:
    match event:
        case ev.MissionStarted():
            _start(draft, event)
        case ev.CancelAsked():
            if draft.mission.running:
                end(draft, Outcome.CANCELED, "cancelled by a person")
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
        Mission(rules=mission.rules, robot=mission.robot, calls=mission.calls),
        id=event.mission_id,
        command=event.command,
        target=event.target,
        colour=event.colour,
        parser=event.parser,
        epoch=mission.robot.epoch,
        started_s=draft.now_s,
        deadline_s=draft.now_s + mission.rules.mission_timeout_s,
        metres_from=mission.robot.odometry,
        search=Search(views=event.views[: mission.rules.memory_views_max]),
    )
    draft.say("start", f"'{event.command}': looking for the {event.target.description} ({event.target.label})"
              + (f"; {event.notes}" if event.notes else ""), parser=event.parser)  # fmt: skip
    if draft.search.views:
        draft.go(MissionState.MEMORY_NAV, f"such things were seen at {len(draft.search.views)} places: the best first")
    else:
        new_scan(draft, "no place is remembered: looking round here first")


def _pause(draft: Draft) -> None:
    if draft.mission.running and not draft.mission.paused:
        draft.stop_motion()
        draft.be(Paused(since_s=draft.now_s, until_s=draft.now_s + draft.rules.pause_timeout_s))
        draft.say("pause", f"paused by a person while {draft.mission.state.value}")


def _resume(draft: Draft) -> None:
    paused = draft.mission.activity
    if not draft.mission.running or not isinstance(paused, Paused):
        return
    draft.set(deadline_s=draft.mission.deadline_s + draft.now_s - paused.since_s)
    draft.say("resume", f"resumed by a person in {draft.mission.state.value}")
    draft.be(Entering())
