"""CENTERING: turning until the target is in the middle of the picture (requirement A8)."""

import math

from contracts.geometry import Twist2D
from contracts.mission import MissionState
from contracts.vision import Detections
from coordinator.core import actions as do
from coordinator.core.activities import Looking, Turning
from coordinator.core.events import DetectionsSeen, Event, MotionEnded
from coordinator.core.geometry import distance_m
from coordinator.core.mission import Sighting
from coordinator.core.reactions import Reaction, react
from coordinator.core.rules import ApproachRule, CenteringRule, Rules
from coordinator.core.search import new_scan
from coordinator.core.sightings import bearing_error_rad, colour_in_its_place, follow, lose, reject, tracked
from coordinator.core.step_context import Draft

TURN_SPEED_RAD_S = 0.8
MOVED_AWAY_M = 1.0


def centering_speed_rad_s(error_px: float, rules: Rules) -> float:
    """omega = -gain * error, clipped, and never so small that the wheels stand still (A8).

    `error_px` is right-positive in a 320 px wide frame.
    """
    size = min(max(abs(error_px) * rules.centering_gain_rad_s_px, rules.centering_speed_min_rad_s),
               rules.centering_speed_max_rad_s)  # fmt: skip
    return -math.copysign(size, error_px)


def begin(draft: Draft) -> None:
    candidate = draft.candidate
    if candidate.rounds >= draft.rules.rounds_max:
        why = f"a {_what(draft)} that could not be reached in {candidate.rounds} rounds"
        reject(draft, why, narrow=True)
        back_to_search(draft, why)
        return
    draft.set_candidate(
        since_s=draft.now_s, seen_s=draft.now_s, centered=0, rounds=candidate.rounds + 1, samples=(),
    )  # fmt: skip
    draft.look(draft.rules.centering_lost_s)


def handle(draft: Draft, event: Event) -> None:
    match draft.mission.activity, event:
        case Looking(after_s=after_s), DetectionsSeen(detections=seen) if seen.stamp_s >= after_s:
            _seen(draft, seen)
        case Turning(), MotionEnded() as ended:
            if react(draft, ended) is Reaction.GO_ON:
                _look(draft)
        case _:
            pass


def on_look_timeout(draft: Draft) -> None:
    """Lost for 4 s, or 15 s gone by: what is validated and localised is finished on the map, the rest is searched."""
    candidate = draft.candidate
    if candidate.confirmed and candidate.map_xy is not None and draft.rules.approach_rule is ApproachRule.LOCALIZED:
        draft.go(MissionState.APPROACHING, "out of the picture from here: finishing on the place it was measured at")
        return
    lost = draft.now_s - candidate.seen_s >= draft.rules.centering_lost_s
    lose(draft)
    back_to_search(draft, "lost it from the picture" if lost else "it would not be centred")


def back_to_search(draft: Draft, reason: str) -> None:
    """SCANNING goes on where it was, or starts afresh where the robot has moved meanwhile."""
    here, started = draft.mission.robot.pose, draft.search.scan_from
    moved = here is not None and started is not None and distance_m(here, started) > MOVED_AWAY_M
    if moved:
        new_scan(draft, f"{reason}; looking round from here")
    elif started is None:
        new_scan(draft, f"{reason}; looking round")
    else:
        draft.go(MissionState.SCANNING, f"{reason}; back to scanning")


def set_aside(draft: Draft, why: str) -> None:
    """The candidate stays one that may be it, with the reason; the search goes on elsewhere."""
    lose(draft, f"could not be driven up to ({why})")
    back_to_search(draft, f"it could not be driven up to: {why}")


def _seen(draft: Draft, seen: Detections) -> None:
    rules = draft.rules
    if draft.now_s - draft.candidate.since_s > rules.centering_timeout_s:
        draft.stop_motion()
        on_look_timeout(draft)
        return
    other = _other_colour(draft, seen)
    if other:
        draft.stop_motion()
        lose(draft)
        back_to_search(draft, f"it is {other}, not {draft.mission.colour}")
        return
    sighting = tracked(draft.mission, draft.candidate, seen)
    if sighting is None:
        draft.set_candidate(centered=0)
        _look(draft, after_s=seen.stamp_s)
        return
    follow(draft, sighting)
    if abs(sighting.error_px) <= rules.centering_tolerance_px:
        draft.set_candidate(centered=draft.candidate.centered + 1)
        if draft.candidate.centered >= rules.centering_detections:
            draft.go(MissionState.DEPTH_CHECK, "in the middle of the picture: measuring")
        else:
            _look(draft, after_s=seen.stamp_s)
        return
    draft.set_candidate(centered=0)
    _turn(draft, sighting)


def _other_colour(draft: Draft, seen: Detections) -> str:
    """The colour it has after all, once enough pictures have named it; empty until then."""
    asked, named = draft.mission.colour, colour_in_its_place(draft.mission, draft.candidate, seen)
    if asked is None or named is None:
        return ""
    count = draft.candidate.other_colour + (1 if named != asked else -1)
    draft.set_candidate(other_colour=max(0, count))
    return named if count >= draft.rules.other_colour_looks else ""


def _turn(draft: Draft, sighting: Sighting) -> None:
    match draft.rules.centering_rule:
        case CenteringRule.BEARING:
            draft.turn(bearing_error_rad(draft.mission, sighting), TURN_SPEED_RAD_S)
        case CenteringRule.PROPORTIONAL:
            omega = centering_speed_rad_s(sighting.error_px, draft.rules)
            draft.act(do.SetVelocity(Twist2D(angular_z=omega), draft.rules.lease_s))
            _look(draft, after_s=sighting.stamp_s)


def _look(draft: Draft, *, after_s: float | None = None) -> None:
    """Waits for a newer frame, no longer than until the target counts as lost or the time is up."""
    rules, candidate = draft.rules, draft.candidate
    until_s = min(candidate.seen_s + rules.centering_lost_s, candidate.since_s + rules.centering_timeout_s)
    after = draft.robot_now_s + rules.look_settle_s if after_s is None else math.nextafter(after_s, math.inf)
    draft.be(Looking(after_s=after, until_s=max(until_s, draft.now_s)))


def _what(draft: Draft) -> str:
    return draft.mission.target.description if draft.mission.target is not None else "target"
