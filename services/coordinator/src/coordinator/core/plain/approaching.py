"""The plain approach (requirement A10): straight ahead, a depth check every 0.5 s; within reach counts as found."""

from dataclasses import replace

from contracts.geometry import Twist2D
from contracts.mission import MissionState
from contracts.motion import MotionEnd
from contracts.vision import Detections
from coordinator.core import actions as do
from coordinator.core.activities import AwaitingFrame, Steering
from coordinator.core.events import DetectionsSeen, Event, LeaseAnswered, MotionEnded, Tick
from coordinator.core.outcomes import found, retry_or_abort
from coordinator.core.reactions import Reaction, react
from coordinator.core.rules import Rules
from coordinator.core.search import set_aside
from coordinator.core.sightings import follow, tracked
from coordinator.core.states.depth_check import DepthCheck, take_measurement
from coordinator.core.states.state import State
from coordinator.core.step_context import StepContext

BLOCKED_S = 3.0
STILL_M_S = 0.02
OVERTIME_S = 10.0


class StraightApproach(State):
    def begin(self, context: StepContext) -> None:
        """After a failure it stands until a picture is measured: it does not drive by a distance nobody checks."""
        if context.mission.failures > 0:
            context.look(context.rules.look_again_s)
        else:
            context.set_activity(_ahead(context))

    def handle(self, context: StepContext, event: Event) -> None:
        match context.mission.activity, event:
            case AwaitingFrame(after_s=after_s), DetectionsSeen(detections=seen) if seen.stamp_s >= after_s:
                if _follow(context, seen):
                    _check_depth(context, _ahead(context))
            case Steering() as steering, Tick():
                _tick(context, steering)
            case Steering() as steering, DetectionsSeen(detections=seen):
                if _follow(context, seen) and context.now_s >= steering.next_depth_s:
                    _check_depth(context, steering)
            case Steering() as steering, LeaseAnswered(held=held):
                context.set_activity(replace(steering, held=held))
            case _:
                pass

    def on_timeout(self, context: StepContext) -> None:
        context.stop_motion()
        waited = isinstance(context.mission.activity, AwaitingFrame)
        why = "out of view: looking again" if waited else "not there in time: turning to it again"
        context.transition_to(MissionState.CENTERING, why)


class StraightStep(State):
    def begin(self, context: StepContext) -> None:
        until_s = context.now_s + context.rules.step_m / context.rules.approach_speed_m_s
        context.set_activity(Steering(until_s=until_s, moving_s=context.now_s))

    def handle(self, context: StepContext, event: Event) -> None:
        match context.mission.activity, event:
            case Steering(), Tick():
                ahead = Twist2D(linear_x=context.rules.approach_speed_m_s)
                context.request(do.SetVelocity(ahead, context.rules.lease_s))
            case Steering(), DetectionsSeen(detections=seen):
                _follow(context, seen)
            case _:
                pass

    def on_timeout(self, context: StepContext) -> None:
        context.stop_motion()
        context.transition_to(MissionState.CENTERING, "one step closer: looking again")


class PlainDepthCheck(DepthCheck):
    takes_unasked = True
    looks_closer = False

    def once_beyond_m(self, rules: Rules) -> float:
        return rules.near_m


def _ahead(context: StepContext) -> Steering:
    distance_m = context.candidate.distance_m or context.rules.near_m
    until_s = context.now_s + distance_m / context.rules.approach_speed_m_s + OVERTIME_S
    return Steering(until_s=until_s, moving_s=context.now_s)


def _tick(context: StepContext, steering: Steering) -> None:
    rules, now = context.rules, context.now_s
    if now - context.candidate.seen_s > rules.centering_lost_s:
        context.stop_motion()
        context.transition_to(MissionState.CENTERING, "out of view: looking again")
        return
    if context.mission.robot.speed_m_s > STILL_M_S:
        steering = replace(steering, moving_s=now)
    if now - steering.moving_s > BLOCKED_S:
        context.stop_motion()
        _stands_still(context, steering.held)
        return
    context.request(do.SetVelocity(Twist2D(linear_x=rules.approach_speed_m_s), rules.lease_s))
    context.set_activity(steering)


def _stands_still(context: StepContext, end: MotionEnd) -> None:
    reaction = react(context, MotionEnded(0, end, text=end.sentence))
    if reaction is Reaction.AS_NEAR_AS_IT_GETS:
        found(context, context.candidate.distance_m, "no nearer straight ahead: an obstacle is in the way")
    elif reaction is Reaction.SET_ASIDE:
        set_aside(context, end.sentence)


def _follow(context: StepContext, seen: Detections) -> bool:
    """Keeps to it, until it drifts from the middle of the picture. Returns False if it is not there to be measured."""
    sighting = tracked(context.mission, context.candidate, seen)
    if sighting is None:
        return False
    follow(context, sighting)
    if abs(sighting.error_px) <= context.rules.drift_px:
        return True
    context.stop_motion()
    context.transition_to(MissionState.CENTERING, "no longer centred: turning to it again")
    return False


def _check_depth(context: StepContext, steering: Steering) -> None:
    measurement = context.candidate.sighting.measurement
    if not measurement.answered:
        context.stop_motion()
        retry_or_abort(context, "robot_bridge", measurement.text)
        return
    context.update(failures=0)
    context.set_activity(replace(steering, next_depth_s=context.now_s + context.rules.depth_period_s))
    take_measurement(context, measurement)
    if measurement.distance_m is not None and measurement.distance_m <= context.rules.reach_m:
        context.stop_motion()
        found(context, measurement.distance_m, "within reach")
