"""SCANNING: turn, stop, look, or one slow turn; a sighting ends it (requirements A5, A8)."""

from contracts.mission import EndCause, EventKind, MissionState
from contracts.vision import Detections
from coordinator.core import actions as do
from coordinator.core.activities import AwaitingFrame, CheckingPlace, Rotating, Undocking, Waking
from coordinator.core.events import DetectionsSeen, Event, Localized, MotionEnded, Undocked
from coordinator.core.geometry import wrap
from coordinator.core.mission import Sighting
from coordinator.core.outcomes import abort
from coordinator.core.reactions import Reaction, react
from coordinator.core.rules import Rules, ScanRule
from coordinator.core.search import awake, next_place, undock_first, undocked
from coordinator.core.sightings import (
    count_other_objects,
    is_near_rejected,
    is_refused,
    is_worth_pursuing,
    new_candidate,
    sightings,
)  # fmt: skip
from coordinator.core.step_context import StepContext

FACING_RAD = 0.06
SWEEP_FROM_RAD = 0.35


def begin(context: StepContext) -> None:
    """Turns to the next heading, or looks at once when it is already there; without headings the scan is over."""
    if undock_first(context):
        return
    if not context.search.headings:
        _finish(context)
        return
    angle_rad = wrap(context.search.headings[0] - context.mission.robot.yaw)
    slowly = context.rules.scan_rule is ScanRule.SLOW_TURN and context.search.sweeps == 0 and _left_rad(context) > 0.0
    if slowly and abs(angle_rad) <= SWEEP_FROM_RAD:
        context.sweep(_left_rad(context), sweep_speed_rad_s(context.rules))
    elif abs(angle_rad) <= FACING_RAD:
        context.look(context.rules.look_timeout_s)
    else:
        context.turn(angle_rad, context.rules.scan_speed_rad_s)


def handle(context: StepContext, event: Event) -> None:
    match context.mission.activity, event:
        case Undocking(), Undocked():
            undocked(context)
        case Waking(), DetectionsSeen():
            awake(context)
        case Rotating(looking_s=float() as since_s), DetectionsSeen(detections=seen) if seen.stamp_s >= since_s:
            _looked_in_passing(context, seen)
        case Rotating() as turning, MotionEnded() as ended:
            _turned(context, turning, ended)
        case AwaitingFrame(after_s=after_s), DetectionsSeen(detections=seen) if seen.stamp_s >= after_s:
            _looked(context, seen)
        case CheckingPlace(), Localized(reply=reply):
            place = (reply.map_point.x, reply.map_point.y) if reply.map_point is not None else None
            if place is None or is_refused(context.mission, place, reply.distance_m):
                context.log_event(EventKind.SIGHTING, "already rejected: going on")
                context.update(candidate=None)
                _next_heading(context)
            else:
                context.transition_to(MissionState.CENTERING, "another one next to the rejected one: turning to it")
        case _:
            pass


def _turned(context: StepContext, turning: Rotating, ended: MotionEnded) -> None:
    if react(context, ended) is not Reaction.GO_ON:
        return
    if turning.looking_s is None:
        context.look(context.rules.look_timeout_s)
    else:
        context.update_search(sweeps=context.search.sweeps + 1)
        begin(context)


def on_look_timeout(context: StepContext) -> None:
    """No picture came: the heading is given up; several in a row end the mission, for a blind robot finds nothing."""
    context.update_search(blind_looks=context.search.blind_looks + 1)
    if context.search.blind_looks >= context.rules.blind_looks_max:
        abort(
            context,
            EndCause.NO_PICTURES,
            f"no picture came in {context.search.blind_looks} looks: inference or the camera is down",
        )
        return
    context.log_event(EventKind.FAILURE, "no camera picture while looking", blind_looks=context.search.blind_looks)
    context.look(context.rules.look_timeout_s)


def sweep_speed_rad_s(rules: Rules) -> float:
    """So slow that every bearing is in the picture for `scan_looks_min` looks of the detector."""
    return min(rules.scan_speed_rad_s, rules.camera_hfov_rad / (rules.scan_looks_min * rules.detector_period_s))


def _left_rad(context: StepContext) -> float:
    """Of the scan, from its next heading to its last."""
    return context.search.headings[-1] - context.search.headings[0]


def _looked_in_passing(context: StepContext, seen: Detections) -> None:
    """Headings the camera swept over are done; those left when the turn is over are looked at one by one."""
    sighting = _inspected(context, seen)
    if sighting is not None:
        context.stop_motion()
        _sighted(context, sighting)
        return
    yaw = seen.pose.yaw if seen.pose is not None else context.mission.robot.yaw
    near = context.rules.camera_hfov_rad * (1.0 - context.rules.scan_overlap_min) / 2
    context.update_search(headings=tuple(h for h in context.search.headings if abs(wrap(h - yaw)) > near))


def _looked(context: StepContext, seen: Detections) -> None:
    sighting = _inspected(context, seen)
    if sighting is None:
        _next_heading(context)
    else:
        _sighted(context, sighting)


def _inspected(context: StepContext, seen: Detections) -> Sighting | None:
    """The sighting in this frame that is worth going after; the look is written down."""
    context.update_search(blind_looks=0)
    pose = seen.pose or context.mission.robot.pose
    if pose is not None:
        context.request(do.RecordLook(pose, seen))
    count_other_objects(context, seen)
    return next((s for s in sightings(context.mission, seen) if is_worth_pursuing(context.mission, s)), None)


def _sighted(context: StepContext, sighting: Sighting) -> None:
    new_candidate(context, sighting)
    data = {"confidence": sighting.confidence, "colour": sighting.colour, "bearing_rad": round(sighting.bearing_rad, 3)}
    context.log_event(EventKind.SIGHTING, f"possible match, confidence {sighting.confidence:.2f}", **data)
    if not is_near_rejected(context.mission, sighting):
        context.transition_to(MissionState.CENTERING, "spotted: turning to it")
        return
    call, limit_s = context.call(), context.rules.localize_timeout_s
    context.request(do.Localize(call, sighting.box, limit_s))
    context.set_activity(CheckingPlace(call, context.now_s + limit_s + context.rules.call_margin_s))


def _next_heading(context: StepContext) -> None:
    context.update_search(headings=context.search.headings[1:])
    begin(context)


def _finish(context: StepContext) -> None:
    here = context.mission.robot.pose
    places = tuple(p for p in (context.search.scan_from, here) if p is not None)[:1]
    context.update_search(visited=(*context.search.visited, *places), scan_from=None)
    next_place(context, "nothing found here")
