"""APPROACHING by place: once localised, the robot drives to a reachable pose round the object, turns to it, looks once
more where looking is possible, and drives the rest straight on odometry ("Geometry to mind" in the requirements).
"""

import math
from dataclasses import replace

from contracts.measuring import Measurement
from contracts.mission import EventFacts, EventKind, MissionState
from contracts.robot import GoalStatus
from coordinator.core.activities import AwaitingFrame, Driving, Navigating, Rotating, Stage
from coordinator.core.approach_poses import approach_candidates, surface_distance_m, target_in_base
from coordinator.core.events import DetectionsSeen, Event, GoalEnded, MotionEnded, Tick
from coordinator.core.mission import Approach
from coordinator.core.obstruction import furniture_before, hindrance
from coordinator.core.outcomes import found, retry_or_abort
from coordinator.core.reactions import Reaction, react
from coordinator.core.search import set_aside
from coordinator.core.sightings import follow, tracked
from coordinator.core.states.depth_check import take_measurement
from coordinator.core.states.state import State
from coordinator.core.step_context import StepContext

TURN_SPEED_RAD_S = 0.8
JUMP_M = 0.5
DRIVES_MAX = 3
DISPUTES_MAX = 4
SETTLED_RAD = 0.12
APPROACH_TIMEOUT_S = 240.0


class Approaching(State):
    def begin(self, context: StepContext) -> None:
        """After a failure of a look it looks once more, from where it stands."""
        if context.mission.failures > 0 and context.approach.stage in {Stage.LOOK, Stage.CONFIRM}:
            context.look(context.rules.look_again_s)
            return
        there = target_in_base(context)
        if there is None:
            context.transition_to(MissionState.CENTERING, "its position is unknown: looking again")
            return
        context.update(approach=Approach(until_s=context.now_s + APPROACH_TIMEOUT_S))
        candidates = approach_candidates(context, context.rules.ring_radii_m)
        if there.distance_m <= context.rules.ring_skip_m or not candidates:
            _face(context)
        else:
            context.log_event(EventKind.NAVIGATION, "driving to a place in front of it")
            context.navigate(candidates, ring_radius_m=0.0)

    def handle(self, context: StepContext, event: Event) -> None:
        stage = context.approach.stage
        match context.mission.activity, event:
            case _, Tick() if context.now_s >= context.approach.until_s:
                _on_overtime(context)
            case Navigating(), GoalEnded():
                _goal_ended(context, event)
            case Rotating(), MotionEnded() as ended:
                if _goes_on(context, ended):
                    _turned(context, stage)
            case AwaitingFrame(after_s=after_s) as awaiting, DetectionsSeen(detections=seen) if seen.stamp_s >= after_s:
                sighting = tracked(context.mission, context.candidate, seen)
                if sighting is not None:
                    follow(context, sighting)
                    furniture = furniture_before(seen, sighting.box.bbox_xyxy)
                    context.update_approach(furniture=furniture or context.approach.furniture)
                    if not sighting.measurement.answered:
                        context.set_activity(replace(awaiting, unmeasured=sighting.measurement.text))
                    else:
                        context.update(failures=0)
                        _measured(context, stage, sighting.measurement)
            case Driving(), MotionEnded():
                _driven(context, event)
            case _:
                pass

    def on_timeout(self, context: StepContext) -> None:
        """It is out of the picture from here, as expected of something high: the place measured before counts. What was
        in the picture and not measured is measured first: robot_bridge fails.
        """
        activity = context.mission.activity
        if isinstance(activity, AwaitingFrame) and activity.unmeasured is not None:
            retry_or_abort(context, "robot_bridge", activity.unmeasured)
            return
        _go_on(context, context.approach.stage)


def _driven(context: StepContext, ended: MotionEnded) -> None:
    """Something in the way may end the approach; what cut the drive off for another reason never does."""
    if not ended.end.completed:
        text = f"the drive ended after {ended.driven_m:.2f} m: {ended.text or ended.end.sentence}"
        context.log_event(EventKind.MOTION, text, EventFacts(moved_m=round(ended.driven_m, 3), end=ended.end))
    if _goes_on(context, ended):
        context.update_approach(stage=Stage.CONFIRM, ended=ended.end)
        context.look(context.rules.look_again_s / 2)


def _goes_on(context: StepContext, ended: MotionEnded) -> bool:
    """False when the approach is paused, waits, or is over by this end."""
    reaction = react(context, ended)
    if reaction is Reaction.SET_ASIDE:
        set_aside(context, ended.text or ended.end.sentence)
    return reaction in {Reaction.GO_ON, Reaction.AS_NEAR_AS_IT_GETS}


def _on_overtime(context: StepContext) -> None:
    context.stop_motion()
    if _seen_from_afar_only(context):
        _look_afresh(context)
        return
    distance_m = surface_distance_m(context)
    if _within_reach(context, distance_m) or context.approach.got_there:
        found(context, distance_m, "as near as could be reached in time")
    else:
        set_aside(context, "not reached in time")


def _goal_ended(context: StepContext, event: GoalEnded) -> None:
    refused = event.status in {GoalStatus.CANCELED, GoalStatus.REJECTED} and context.search.refusals == 0
    context.update_search(refusals=1 if refused else 0)
    if refused:
        context.retry_later("navigation", f"{event.status.value} {event.error}".strip(), stopped=event.stopped)
        return
    if event.status is not GoalStatus.SUCCEEDED:
        why = f"{event.error or event.status.value}: driving straight ahead from here"
        context.log_event(EventKind.NAVIGATION, why, EventFacts(error_code=event.error_code))
    _face(context)


def _face(context: StepContext) -> None:
    context.update_approach(stage=Stage.FACE)
    _turn_or(context, Stage.FACE, context.rules.face_tolerance_rad)


def _turn_or(context: StepContext, stage: Stage, tolerance_rad: float) -> None:
    there = target_in_base(context)
    if there is not None and abs(there.bearing_rad) > tolerance_rad:
        context.turn(there.bearing_rad, TURN_SPEED_RAD_S)
    else:
        _turned(context, stage)


def _turned(context: StepContext, stage: Stage) -> None:
    match stage:
        case Stage.RING | Stage.FACE:
            context.update_approach(stage=Stage.LOOK)
            context.look(context.rules.look_again_s)
        case Stage.LOOK | Stage.AIM:
            _drive(context)
        case Stage.DRIVE | Stage.CONFIRM | Stage.SETTLE:
            _finish(context)


def _measured(context: StepContext, stage: Stage, reply: Measurement) -> None:
    """Takes the new place where it is near the old one. Of one that jumps a second has to say the same to count:
    either it, or what was believed so far, is wrong.
    """
    old = context.candidate.map_xy
    new = (reply.map_point.x, reply.map_point.y) if reply.map_point is not None else None
    if reply.distance_m is None or new is None:
        _go_on(context, stage)
    elif old is not None and math.dist(old, new) > JUMP_M and not _said_before(context, new):
        context.log_event(
            EventKind.DEPTH, f"measured {math.dist(old, new):.1f} m from its known position: measuring again"
        )
        context.update_approach(disputed=(*context.approach.disputed, new))
        if len(context.approach.disputed) < DISPUTES_MAX:
            context.look(context.rules.look_again_s)
        else:
            _go_on(context, stage)
    else:
        if old is not None and math.dist(old, new) > JUMP_M:
            context.update_candidate(map_xy=None, odom_xy=None)
        context.update_approach(disputed=())
        take_measurement(context, reply)
        context.log_event(
            EventKind.DEPTH, f"{reply.distance_m:.2f} m away", EventFacts(distance_m=round(reply.distance_m, 3))
        )
        _go_on(context, stage)


def _said_before(context: StepContext, new: tuple[float, float]) -> bool:
    return any(math.dist(new, other) <= JUMP_M for other in context.approach.disputed)


def _go_on(context: StepContext, stage: Stage) -> None:
    if stage in {Stage.RING, Stage.FACE, Stage.LOOK}:
        context.update_approach(stage=Stage.AIM)
        _turn_or(context, Stage.AIM, context.rules.face_tolerance_rad)
        return
    left_m = surface_distance_m(context)
    again = left_m is not None and left_m > context.rules.reach_m + 0.03 and not context.approach.blocked
    if again and context.approach.drives < DRIVES_MAX:
        context.update_approach(stage=Stage.AIM)
        _turn_or(context, Stage.AIM, context.rules.face_tolerance_rad)
    else:
        context.update_approach(stage=Stage.SETTLE)
        _turn_or(context, Stage.SETTLE, SETTLED_RAD)


def _drive(context: StepContext) -> None:
    """The rest of the way, or what ends the approach where nothing is left of it."""
    left_m, rules = surface_distance_m(context), context.rules
    rest_m = 0.0 if left_m is None else left_m - min(rules.stand_off_m, rules.reach_m)
    if rest_m <= 0.03:
        context.update_approach(stage=Stage.SETTLE)
        _turn_or(context, Stage.SETTLE, SETTLED_RAD)
        return
    context.update_approach(stage=Stage.DRIVE, drives=context.approach.drives + 1)
    context.drive(min(rest_m, 2.0))


def _seen_from_afar_only(context: StepContext) -> bool:
    """What was never measured from near is no find, wherever the robot stands: the one place it has may be wrong."""
    return context.candidate.distance_m is not None and context.candidate.distance_m > context.rules.near_m


def _look_afresh(context: StepContext) -> None:
    """Forgets the place; where it is not seen again either, it is told as what may have been it."""
    context.update_candidate(map_xy=None, odom_xy=None)
    context.transition_to(MissionState.CENTERING, "seen only from far away so far: looking again")


def _finish(context: StepContext) -> None:
    if _seen_from_afar_only(context):
        _look_afresh(context)
        return
    distance, approach = surface_distance_m(context), context.approach
    if _within_reach(context, distance):
        found(context, distance, "within reach")
        return
    if distance is None:
        set_aside(context, "its distance is unknown")
        return
    may_try = approach.alternatives < context.rules.alternatives_max
    if distance > context.rules.blocked_alternative_m and may_try and _other_side(context):
        return
    if approach.ended is not None and not approach.got_there:
        set_aside(context, f"{distance:.2f} m short of it: {approach.ended.sentence}")
        return
    found(context, distance, f"as near as the map allows: {hindrance(approach.blocked, approach.furniture)}")


def _within_reach(context: StepContext, distance_m: float | None) -> bool:
    return distance_m is not None and distance_m <= context.rules.reach_m + 0.05


def _other_side(context: StepContext) -> bool:
    """True when another part of the ring is to be tried."""
    pose, xy = context.mission.robot.pose, context.candidate.map_xy
    if pose is None or xy is None:
        return False
    here_rad = math.atan2(pose.y - xy[1], pose.x - xy[0])
    tried = (*context.approach.tried_rad, here_rad)
    candidates = approach_candidates(context, context.rules.ring_radii_m[:2], tried)
    if not candidates:
        return False
    alternatives = context.approach.alternatives + 1
    context.update_approach(stage=Stage.RING, alternatives=alternatives, tried_rad=tried, ended=None, drives=0)
    context.log_event(EventKind.NAVIGATION, "stopped too far away: trying from another side")
    context.navigate(candidates, ring_radius_m=0.0)
    return True
