"""SCANNING: turn, stop, look, or one slow turn; a sighting ends it (requirements A5, A8)."""

from contracts.mission import EndCause, EventKind, MissionState
from contracts.vision import Detections
from coordinator.core import actions as do
from coordinator.core.activities import CheckingPlace, Looking, Turning, Undocking, Waking
from coordinator.core.events import DetectionsSeen, Event, Localized, MotionEnded, Undocked
from coordinator.core.geometry import wrap
from coordinator.core.mission import Sighting
from coordinator.core.outcomes import abort
from coordinator.core.reactions import Reaction, react
from coordinator.core.rules import Rules, ScanRule
from coordinator.core.search import awake, next_place, undock_first, undocked
from coordinator.core.sightings import (
    is_refused,
    may_be_rejected,
    new_candidate,
    sightings,
    tally_others,
    worth_it,
)  # fmt: skip
from coordinator.core.step_context import Draft

FACING_RAD = 0.06
SWEEP_FROM_RAD = 0.35


def begin(draft: Draft) -> None:
    """Turns to the next heading, or looks at once when it is already there; without headings the scan is over."""
    if undock_first(draft):
        return
    if not draft.search.headings:
        _finish(draft)
        return
    angle_rad = wrap(draft.search.headings[0] - draft.mission.robot.yaw)
    slowly = draft.rules.scan_rule is ScanRule.SLOW_TURN and draft.search.sweeps == 0 and _left_rad(draft) > 0.0
    if slowly and abs(angle_rad) <= SWEEP_FROM_RAD:
        draft.sweep(_left_rad(draft), sweep_speed_rad_s(draft.rules))
    elif abs(angle_rad) <= FACING_RAD:
        draft.look(draft.rules.look_timeout_s)
    else:
        draft.turn(angle_rad, draft.rules.scan_speed_rad_s)


def handle(draft: Draft, event: Event) -> None:
    match draft.mission.activity, event:
        case Undocking(), Undocked():
            undocked(draft)
        case Waking(), DetectionsSeen():
            awake(draft)
        case Turning(looking_s=float() as since_s), DetectionsSeen(detections=seen) if seen.stamp_s >= since_s:
            _looked_in_passing(draft, seen)
        case Turning() as turning, MotionEnded() as ended:
            _turned(draft, turning, ended)
        case Looking(after_s=after_s), DetectionsSeen(detections=seen) if seen.stamp_s >= after_s:
            _looked(draft, seen)
        case CheckingPlace(), Localized(reply=reply):
            place = (reply.map_point.x, reply.map_point.y) if reply.map_point is not None else None
            if place is None or is_refused(draft.mission, place, reply.distance_m):
                draft.say(EventKind.SIGHTING, "the same thing that was refused before: going on")
                draft.set(candidate=None)
                _next_heading(draft)
            else:
                draft.go(MissionState.CENTERING, "another one beside the refused one: turning to it")
        case _:
            pass


def _turned(draft: Draft, turning: Turning, ended: MotionEnded) -> None:
    if react(draft, ended) is not Reaction.GO_ON:
        return
    if turning.looking_s is None:
        draft.look(draft.rules.look_timeout_s)
    else:
        draft.set_search(sweeps=draft.search.sweeps + 1)
        begin(draft)


def on_look_timeout(draft: Draft) -> None:
    """No picture came: the heading is given up; several in a row end the mission, for a blind robot finds nothing."""
    draft.set_search(blind_looks=draft.search.blind_looks + 1)
    if draft.search.blind_looks >= draft.rules.blind_looks_max:
        abort(
            draft,
            EndCause.NO_PICTURES,
            f"no picture came in {draft.search.blind_looks} looks: inference or the camera is away",
        )
        return
    draft.say(EventKind.FAILURE, "no picture came while looking", blind_looks=draft.search.blind_looks)
    draft.look(draft.rules.look_timeout_s)


def sweep_speed_rad_s(rules: Rules) -> float:
    """So slow that every bearing is in the picture for `scan_looks_min` looks of the detector."""
    return min(rules.scan_speed_rad_s, rules.camera_hfov_rad / (rules.scan_looks_min * rules.detector_period_s))


def _left_rad(draft: Draft) -> float:
    """Of the scan, from its next heading to its last."""
    return draft.search.headings[-1] - draft.search.headings[0]


def _looked_in_passing(draft: Draft, seen: Detections) -> None:
    """Headings the camera swept over are done; those left when the turn is over are looked at one by one."""
    sighting = _inspected(draft, seen)
    if sighting is not None:
        draft.stop_motion()
        _sighted(draft, sighting)
        return
    yaw = seen.pose.yaw if seen.pose is not None else draft.mission.robot.yaw
    near = draft.rules.camera_hfov_rad * (1.0 - draft.rules.scan_overlap_min) / 2
    draft.set_search(headings=tuple(h for h in draft.search.headings if abs(wrap(h - yaw)) > near))


def _looked(draft: Draft, seen: Detections) -> None:
    sighting = _inspected(draft, seen)
    if sighting is None:
        _next_heading(draft)
    else:
        _sighted(draft, sighting)


def _inspected(draft: Draft, seen: Detections) -> Sighting | None:
    """The sighting in this frame that is worth going after; the look is written down."""
    draft.set_search(blind_looks=0)
    pose = seen.pose or draft.mission.robot.pose
    if pose is not None:
        draft.act(do.RecordLook(pose, seen))
    tally_others(draft, seen)
    return next((s for s in sightings(draft.mission, seen) if worth_it(draft.mission, s)), None)


def _sighted(draft: Draft, sighting: Sighting) -> None:
    new_candidate(draft, sighting)
    data = {"confidence": sighting.confidence, "colour": sighting.colour, "bearing_rad": round(sighting.bearing_rad, 3)}
    draft.say(EventKind.SIGHTING, f"something like it at confidence {sighting.confidence:.2f}", **data)
    if not may_be_rejected(draft.mission, sighting):
        draft.go(MissionState.CENTERING, "seen: turning to it")
        return
    call, limit_s = draft.call(), draft.rules.localize_timeout_s
    draft.act(do.Localize(call, sighting.box, limit_s))
    draft.be(CheckingPlace(call, draft.now_s + limit_s + draft.rules.call_margin_s))


def _next_heading(draft: Draft) -> None:
    draft.set_search(headings=draft.search.headings[1:])
    begin(draft)


def _finish(draft: Draft) -> None:
    here = draft.mission.robot.pose
    places = tuple(p for p in (draft.search.scan_from, here) if p is not None)[:1]
    draft.set_search(looked=(*draft.search.looked, *places), scan_from=None)
    next_place(draft, "looked all round, not here")
