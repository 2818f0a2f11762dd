"""EXPLORING: an exploration leads (`coordinator.exploration`); the mission begins it, holds it, says how it ended."""

from typing import assert_never

from contracts.exploration import ExplorationEnd
from contracts.mission import EndCause, EventKind, MapTrouble, Outcome
from coordinator.core import actions as do
from coordinator.core.activities import Starting, UnderExploration, WaitingForPlace
from coordinator.core.events import DetectionsSeen, DiscoverySeen, Event, ExplorationEnded, LeadChanged, Tick
from coordinator.core.outcomes import abort, abort_for_the_map, end
from coordinator.core.report import others_in_words
from coordinator.core.search import new_scan
from coordinator.core.sightings import count_other_objects
from coordinator.core.states.state import State
from coordinator.core.step_context import StepContext

DISCOVERIES_TOLD = 5


class ExplorationState(State):
    def begin(self, context: StepContext) -> None:
        mission = context.mission
        home = mission.robot.pose
        if home is None:
            lost_since_s = max(mission.robot.localized_s, mission.started_s)
            context.set_activity(WaitingForPlace(lost_since_s + context.rules.lost_pose_s, "localisation"))
            return
        call = context.call()
        motion = mission.motion
        context.request(do.BeginExploration(call, home, motion.explore_s if motion is not None else None))
        context.set_activity(UnderExploration(call))

    def handle(self, context: StepContext, event: Event) -> None:
        match event:
            case DetectionsSeen(detections=seen):
                count_other_objects(context, seen)
            case LeadChanged(mode=mode, why=why):
                context.log_event(EventKind.NAVIGATION, f"exploring, {mode.value}: {why}")
            case DiscoverySeen(label=label, note=note):
                context.log_event(EventKind.SIGHTING, f"discovered: {label}{f' ({note})' if note else ''}")
            case ExplorationEnded():
                _ended(context, event)
            case Tick() if (
                isinstance(context.mission.activity, WaitingForPlace) and context.mission.robot.pose is not None
            ):
                context.set_activity(Starting())
            case _:
                pass


def _ended(context: StepContext, ended: ExplorationEnded) -> None:
    match ended.end:
        case ExplorationEnd.EXPLORED if ended.actions == 0 or ended.all_known:
            new_scan(context, "the map shows nothing unknown that can be reached: looking at all of it instead")
        case ExplorationEnd.EXPLORED:
            _done(context, ended, "explored: nothing unknown is left that can be reached")
        case ExplorationEnd.TIME_UP:
            _done(context, ended, "explored until its time was up")
        case ExplorationEnd.MODEL_SILENT:
            abort(context, EndCause.SERVICE, "the model did not answer for too long: it ended at home")
        case ExplorationEnd.HOME_NOT_REACHED:
            abort(context, EndCause.NAVIGATION, "it explored, and found no way home")
        case ExplorationEnd.MOTION_FAILED:
            abort(context, EndCause.SERVICE, "the robot took nothing that moves it, however often it was asked")
        case ExplorationEnd.ANOTHER_MAP:
            abort_for_the_map(context, MapTrouble.ANOTHER_MAP)
        case ExplorationEnd.STOPPED:
            abort(context, EndCause.STOPPED, "the emergency stop")
        case ExplorationEnd.CANCELED:
            why = "the exploration was cancelled"
            end(context, Outcome.CANCELED, why, EndCause.PERSON, cause=why)
        case _:
            assert_never(ended.end)


def _done(context: StepContext, ended: ExplorationEnded, what: str) -> None:
    found = ", ".join(dict.fromkeys(ended.discoveries[-DISCOVERIES_TOLD:]))
    told = (
        what,
        f"{ended.actions} drives and turns",
        f"the model was asked {ended.calls} times" if ended.calls else "",
        f"discovered: {found}" if found else "",
        others_in_words(context.mission, "seen"),
    )
    end(context, Outcome.DONE, "; ".join(filter(None, told)), None)
