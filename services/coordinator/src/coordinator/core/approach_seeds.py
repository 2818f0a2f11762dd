"""APPROACHING by the plain rule (requirement A10): straight ahead, a depth check every 0.5 s."""

from dataclasses import replace

from contracts.geometry import Twist2D
from contracts.mission import MissionState
from contracts.motion import MotionEnd
from contracts.robot import LocalizeReply
from contracts.vision import Detections
from coordinator.core import actions as do
from coordinator.core.activities import Steering
from coordinator.core.centering import set_aside
from coordinator.core.depth_check import take_measurement
from coordinator.core.events import DetectionsSeen, Event, LeaseAnswered, Localized, MotionEnded, Tick
from coordinator.core.outcomes import found
from coordinator.core.plausibility import plausible
from coordinator.core.reactions import Reaction, react
from coordinator.core.sightings import follow, tracked
from coordinator.core.step_context import Draft

BLOCKED_S = 3.0
STILL_M_S = 0.02
OVERTIME_S = 10.0


def begin(draft: Draft) -> None:
    distance = draft.candidate.distance_m or draft.rules.near_m
    until_s = draft.now_s + distance / draft.rules.approach_speed_m_s + OVERTIME_S
    draft.be(Steering(until_s=until_s, next_depth_s=draft.now_s, moving_s=draft.now_s))


def handle(draft: Draft, event: Event) -> None:
    match draft.mission.activity, event:
        case Steering() as steering, Tick():
            _tick(draft, steering)
        case Steering(), DetectionsSeen(detections=seen):
            _seen(draft, seen)
        case Steering() as steering, Localized(reply=reply):
            draft.be(replace(steering, call=0))
            _measured(draft, plausible(reply, draft.rules))
        case Steering() as steering, LeaseAnswered(held=held):
            draft.be(replace(steering, held=held))
        case _:
            pass


def on_steering_end(draft: Draft) -> None:
    draft.stop_motion()
    draft.go(MissionState.CENTERING, "not there in time: centring again")


def on_failure(draft: Draft) -> None:
    """One depth check failed; the next comes by itself."""
    if isinstance(draft.mission.activity, Steering):
        draft.be(replace(draft.mission.activity, call=0))


def _tick(draft: Draft, steering: Steering) -> None:
    rules, now = draft.rules, draft.now_s
    if now - draft.candidate.seen_s > rules.centering_lost_s:
        draft.stop_motion()
        draft.go(MissionState.CENTERING, "out of the picture: looking again")
        return
    if draft.mission.robot.speed_m_s > STILL_M_S:
        steering = replace(steering, moving_s=now)
    if now - steering.moving_s > BLOCKED_S:
        draft.stop_motion()
        _stands_still(draft, steering.held)
        return
    draft.act(do.SetVelocity(Twist2D(linear_x=rules.approach_speed_m_s), rules.lease_s))
    if steering.call == 0 and now >= steering.next_depth_s:
        call = draft.call()
        draft.act(do.Localize(call, draft.candidate.sighting.box, rules.localize_timeout_s))
        steering = replace(steering, call=call, next_depth_s=now + rules.depth_period_s)
    draft.be(steering)


def _stands_still(draft: Draft, end: MotionEnd) -> None:
    reaction = react(draft, MotionEnded(0, end, text=end.sentence))
    if reaction is Reaction.AS_NEAR_AS_IT_GETS:
        found(draft, draft.candidate.distance_m, "no nearer straight ahead: an obstacle is in the way")
    elif reaction is Reaction.SET_ASIDE:
        set_aside(draft, end.sentence)


def _seen(draft: Draft, seen: Detections) -> None:
    sighting = tracked(draft.mission, draft.candidate, seen)
    if sighting is None:
        return
    follow(draft, sighting)
    if abs(sighting.error_px) > draft.rules.drift_px:
        draft.stop_motion()
        draft.go(MissionState.CENTERING, "it drifted from the middle: centring again")


def _measured(draft: Draft, reply: LocalizeReply) -> None:
    take_measurement(draft, reply)
    if reply.distance_m is not None and reply.distance_m <= draft.rules.reach_m:
        draft.stop_motion()
        found(draft, reply.distance_m, "within reach")
