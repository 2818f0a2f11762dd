"""CENTERING: turning until the target is in the middle of the picture (requirement A8)."""

import math

from contracts.geometry import Twist2D
from contracts.mission import MissionState
from contracts.vision import Detections
from coordinator.core import actions as do
from coordinator.core.activities import AwaitingFrame, Rotating
from coordinator.core.events import DetectionsSeen, Event, MotionEnded
from coordinator.core.geometry import distance_m
from coordinator.core.mission import Sighting
from coordinator.core.reactions import Reaction, react
from coordinator.core.rules import ApproachRule, CenteringRule, Rules
from coordinator.core.search import new_scan
from coordinator.core.sightings import bearing_error_rad, colour_in_its_place, follow, lose, reject, tracked
from coordinator.core.step_context import StepContext

TURN_SPEED_RAD_S = 0.8
MOVED_AWAY_M = 1.0


def centering_speed_rad_s(error_px: float, rules: Rules) -> float:
    """omega = -gain * error, clipped, and never so small that the wheels stand still (A8).

    `error_px` is right-positive in a 320 px wide frame.
    """
    size = min(max(abs(error_px) * rules.centering_gain_rad_s_px, rules.centering_speed_min_rad_s),
               rules.centering_speed_max_rad_s)  # fmt: skip
    return -math.copysign(size, error_px)


def begin(context: StepContext) -> None:
    candidate = context.candidate
    if candidate.rounds >= context.rules.rounds_max:
        why = f"a {_what(context)} that could not be reached in {candidate.rounds} rounds"
        reject(context, why, narrow=True)
        back_to_search(context, why)
        return
    context.update_candidate(
        since_s=context.now_s, seen_s=context.now_s, centered=0, rounds=candidate.rounds + 1, samples=(),
    )  # fmt: skip
    context.look(context.rules.centering_lost_s)


def handle(context: StepContext, event: Event) -> None:
    match context.mission.activity, event:
        case AwaitingFrame(after_s=after_s), DetectionsSeen(detections=seen) if seen.stamp_s >= after_s:
            _seen(context, seen)
        case Rotating(), MotionEnded() as ended:
            if react(context, ended) is Reaction.GO_ON:
                _look(context)
        case _:
            pass


def on_look_timeout(context: StepContext) -> None:
    """Lost for 4 s, or 15 s gone by: what is validated and localised is finished on the map, the rest is searched."""
    candidate = context.candidate
    if candidate.confirmed and candidate.map_xy is not None and context.rules.approach_rule is ApproachRule.LOCALIZED:
        context.transition_to(MissionState.APPROACHING, "out of view from here: driving to its measured position")
        return
    lost = context.now_s - candidate.seen_s >= context.rules.centering_lost_s
    lose(context)
    what = _what(context)
    back_to_search(context, f"lost sight of the {what}" if lost else f"the {what} could not be centred")


def back_to_search(context: StepContext, reason: str) -> None:
    """SCANNING goes on where it was, or starts afresh where the robot has moved meanwhile."""
    here, started = context.mission.robot.pose, context.search.scan_from
    moved = here is not None and started is not None and distance_m(here, started) > MOVED_AWAY_M
    if moved:
        new_scan(context, f"{reason}; looking around from here")
    elif started is None:
        new_scan(context, f"{reason}; looking around")
    else:
        context.transition_to(MissionState.SCANNING, f"{reason}; looking around again")


def set_aside(context: StepContext, why: str) -> None:
    """The candidate stays one that may be it, with the reason; the search goes on elsewhere."""
    lose(context, f"could not be driven up to ({why})")
    back_to_search(context, f"it could not be driven up to: {why}")


def _seen(context: StepContext, seen: Detections) -> None:
    rules = context.rules
    if context.now_s - context.candidate.since_s > rules.centering_timeout_s:
        context.stop_motion()
        on_look_timeout(context)
        return
    other = _other_colour(context, seen)
    if other:
        context.stop_motion()
        lose(context)
        back_to_search(context, f"it is {other}, not {context.mission.colour}")
        return
    sighting = tracked(context.mission, context.candidate, seen)
    if sighting is None:
        context.update_candidate(centered=0)
        _look(context, after_s=seen.stamp_s)
        return
    follow(context, sighting)
    if abs(sighting.error_px) <= rules.centering_tolerance_px:
        context.update_candidate(centered=context.candidate.centered + 1)
        if context.candidate.centered >= rules.centering_detections:
            context.transition_to(MissionState.DEPTH_CHECK, "centred: measuring the distance")
        else:
            _look(context, after_s=seen.stamp_s)
        return
    context.update_candidate(centered=0)
    _turn(context, sighting)


def _other_colour(context: StepContext, seen: Detections) -> str:
    """The colour it has after all, once enough pictures have named it; empty until then."""
    asked, named = context.mission.colour, colour_in_its_place(context.mission, context.candidate, seen)
    if asked is None or named is None:
        return ""
    count = context.candidate.other_colour + (1 if named != asked else -1)
    context.update_candidate(other_colour=max(0, count))
    return named if count >= context.rules.other_colour_looks else ""


def _turn(context: StepContext, sighting: Sighting) -> None:
    match context.rules.centering_rule:
        case CenteringRule.BEARING:
            context.turn(bearing_error_rad(context.mission, sighting), TURN_SPEED_RAD_S)
        case CenteringRule.PROPORTIONAL:
            omega = centering_speed_rad_s(sighting.error_px, context.rules)
            context.request(do.SetVelocity(Twist2D(angular_z=omega), context.rules.lease_s))
            _look(context, after_s=sighting.stamp_s)


def _look(context: StepContext, *, after_s: float | None = None) -> None:
    """Waits for a newer frame, no longer than until the target counts as lost or the time is up."""
    rules, candidate = context.rules, context.candidate
    until_s = min(candidate.seen_s + rules.centering_lost_s, candidate.since_s + rules.centering_timeout_s)
    after = context.robot_now_s + rules.look_settle_s if after_s is None else math.nextafter(after_s, math.inf)
    context.set_activity(AwaitingFrame(after_s=after, until_s=max(until_s, context.now_s)))


def _what(context: StepContext) -> str:
    return context.mission.target.description if context.mission.target is not None else "target"
