"""SCANNING: turn, stop, look; a sighting ends it (requirements A5, A8)."""

from contracts.mission import EndCause, EventFacts, EventKind, MissionState
from contracts.vision import Detections
from coordinator.core import actions as do
from coordinator.core.activities import AwaitingFrame, Rotating
from coordinator.core.events import DetectionsSeen, Event, MotionEnded
from coordinator.core.mission import Sighting
from coordinator.core.outcomes import abort, retry_or_abort
from coordinator.core.reactions import Reaction, react
from coordinator.core.rules import CoverageRule
from coordinator.core.search import next_place
from coordinator.core.sightings import (
    count_other_objects,
    is_near_rejected,
    is_refused,
    is_worth_pursuing,
    new_candidate,
    sightings,
)  # fmt: skip
from coordinator.core.states.state import State
from coordinator.core.step_context import StepContext
from geometry.poses import wrap

FACING_RAD = 0.06


class Scanning(State):
    def begin(self, context: StepContext) -> None:
        """Turns to the next heading, or looks at once when it is already there; without headings the scan is over."""
        if not context.search.headings:
            _finish(context)
            return
        angle_rad = wrap(context.search.headings[0] - context.mission.robot.yaw)
        self.look_at(context, angle_rad)

    def look_at(self, context: StepContext, angle_rad: float) -> None:
        """Turn there, stop, and look."""
        if abs(angle_rad) <= FACING_RAD:
            context.look(context.rules.look_timeout_s)
        else:
            context.turn(angle_rad, context.rules.scan_speed_rad_s)

    def handle(self, context: StepContext, event: Event) -> None:
        match context.mission.activity, event:
            case Rotating(), MotionEnded() as ended:
                if react(context, ended) is Reaction.GO_ON:
                    context.look(context.rules.look_timeout_s)
            case AwaitingFrame(after_s=after_s), DetectionsSeen(detections=seen) if seen.stamp_s >= after_s:
                self._looked(context, seen)
            case _:
                pass

    def on_timeout(self, context: StepContext) -> None:
        no_picture(context)

    def _looked(self, context: StepContext, seen: Detections) -> None:
        sighting = inspected(context, seen)
        if sighting is None:
            self.next_heading(context)
        else:
            self.sighted(context, sighting)

    def sighted(self, context: StepContext, sighting: Sighting) -> None:
        """Turns to it, unless its place says that it was rejected before."""
        new_candidate(context, sighting)
        facts = EventFacts(confidence=sighting.confidence, colour=sighting.colour)
        context.log_event(EventKind.SIGHTING, f"possible match, confidence {sighting.confidence:.2f}", facts)
        measured = sighting.measurement
        if not is_near_rejected(context.mission, sighting):
            context.transition_to(MissionState.CENTERING, "spotted: turning to it")
        elif not measured.answered:
            retry_or_abort(context, "robot_bridge", measured.text)
        elif measured.map_point is None or is_refused(
            context.mission, (measured.map_point.x, measured.map_point.y), measured.distance_m
        ):
            context.log_event(EventKind.SIGHTING, "already rejected: going on")
            context.update(candidate=None)
            self.next_heading(context)
        else:
            context.transition_to(MissionState.CENTERING, "another one next to the rejected one: turning to it")

    def next_heading(self, context: StepContext) -> None:
        context.update_search(headings=context.search.headings[1:])
        self.begin(context)


def no_picture(context: StepContext) -> None:
    """Looks again. Several looks in a row without a picture end the mission: a blind robot finds nothing."""
    context.update_search(blind_looks=context.search.blind_looks + 1)
    if context.search.blind_looks >= context.rules.blind_looks_max:
        abort(
            context,
            EndCause.NO_PICTURES,
            f"no picture came in {context.search.blind_looks} looks: inference or the camera is down",
        )
        return
    context.log_event(EventKind.FAILURE, "no camera picture while looking")
    context.look(context.rules.look_timeout_s)


def inspected(context: StepContext, seen: Detections) -> Sighting | None:
    """The sighting in this frame that is worth going after; the look is written down."""
    context.update_search(blind_looks=0)
    pose = seen.pose or context.mission.robot.pose
    if pose is not None:
        context.request(do.RecordLook(pose, seen))
    count_other_objects(context, seen)
    return next((s for s in sightings(context.mission, seen) if is_worth_pursuing(context.mission, s)), None)


def _finish(context: StepContext) -> None:
    """By belief a scan may end before its first look: then a place is chosen, and none counts as looked at."""
    here, started = context.mission.robot.pose, context.search.scan_from
    by_belief = context.rules.coverage_rule is CoverageRule.BELIEF and context.mission.target is not None
    if started is None and by_belief:
        context.transition_to(MissionState.MOVING_TO_SCAN, "choosing where to look")
        return
    places = tuple(p for p in (started, here) if p is not None)[:1]
    context.update_search(visited=(*context.search.visited, *places), scan_from=None)
    next_place(context, "nothing found here")
