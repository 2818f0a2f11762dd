"""MOVING: the plain motions that were asked for, one leg after another (`core/motions.py`)."""

import math
from dataclasses import replace

from contracts.causes import GoalCause
from contracts.geometry import Pose2D
from contracts.mission import EndCause, EventFacts, EventKind, Outcome
from contracts.robot import CandidatePose, GoalStatus
from coordinator.core import actions as do
from coordinator.core.activities import AwaitingFrame, Driving, Navigating, Rotating, Starting
from coordinator.core.events import DetectionsSeen, Event, GoalEnded, MotionEnded
from coordinator.core.motions import (
    FaceLeg,
    Leg,
    LookLeg,
    PlaceLeg,
    PlainMotion,
    RoundLeg,
    StraightLeg,
    TurnLeg,
    looks_round,
    next_step_rad,
)
from coordinator.core.outcomes import abort, end
from coordinator.core.reactions import Reaction, react
from coordinator.core.report import others_in_words
from coordinator.core.sightings import count_other_objects
from coordinator.core.states.scanning import no_picture
from coordinator.core.states.state import State
from coordinator.core.states.travelling import is_here
from coordinator.core.step_context import StepContext
from geometry.poses import apart_m, wrap

FACED_RAD = 0.015
DRIVEN_M = 0.03
"""What is left of a leg that was broken off and is as good as done."""
ASIDE_RAD = 0.3
"""Turned by more than this since it began, a straight drive is not taken up again."""
TRIES = 2
"""Of a goal that Nav2 gave up: a person who stood in the way may be gone."""


class Moving(State):
    def begin(self, context: StepContext) -> None:
        legs = _motion(context).legs
        if not legs:
            _done(context)
            return
        match legs[0]:
            case PlaceLeg() as place:
                _go(context, place)
            case TurnLeg() as turn:
                _turn(context, turn)
            case RoundLeg():
                _instead(context, looks_round(context.rules, _heading_rad(context)))
            case FaceLeg(heading_rad=heading_rad):
                left_rad = wrap(heading_rad - _heading_rad(context))
                if abs(left_rad) <= FACED_RAD:
                    _next(context)
                else:
                    context.turn(left_rad, context.rules.scan_speed_rad_s)
            case StraightLeg() as straight:
                _drive(context, straight)
            case LookLeg():
                context.look(context.rules.look_timeout_s)

    def handle(self, context: StepContext, event: Event) -> None:
        match context.mission.activity, event:
            case Navigating(), GoalEnded():
                _goal_ended(context, event)
            case ((Rotating() | Driving()), MotionEnded()):
                _motion_ended(context, event)
            case AwaitingFrame(after_s=after_s), DetectionsSeen(detections=seen) if seen.stamp_s >= after_s:
                context.update_search(blind_looks=0)
                pose = seen.pose or context.mission.robot.pose
                if pose is not None:
                    context.request(do.RecordLook(pose, seen))
                count_other_objects(context, seen)
                _next(context)
            case _:
                pass

    def on_timeout(self, context: StepContext) -> None:
        no_picture(context)


def _motion(context: StepContext) -> PlainMotion:
    assert context.mission.motion is not None, "this state has motions to do"
    return context.mission.motion


def _heading_rad(context: StepContext) -> float:
    """By odometry, which does not jump as the place on the map does."""
    odometry = context.mission.robot.odometry
    return odometry.yaw if odometry is not None else context.mission.robot.yaw


def _instead(context: StepContext, legs: tuple[Leg, ...]) -> None:
    """The first leg is done by these."""
    motion = _motion(context)
    context.update(motion=replace(motion, legs=(*legs, *motion.legs[1:])))


def _next(context: StepContext) -> None:
    _instead(context, ())
    context.set_activity(Starting())


def _turn(context: StepContext, turn: TurnLeg) -> None:
    """What a step that was broken off had turned already counts."""
    heading_rad = _heading_rad(context)
    done_rad = 0.0 if turn.from_rad is None else wrap(heading_rad - turn.from_rad)
    left_rad = turn.angle_rad - done_rad
    if abs(left_rad) <= FACED_RAD:
        _next(context)
        return
    _instead(context, (TurnLeg(left_rad, heading_rad),))
    context.turn(next_step_rad(left_rad), context.rules.scan_speed_rad_s)


def _go(context: StepContext, place: PlaceLeg) -> None:
    here = context.mission.robot.pose
    yaw = place.yaw
    if yaw is None:
        far = here is not None and math.hypot(place.x - here.x, place.y - here.y) > DRIVEN_M
        yaw = math.atan2(place.y - here.y, place.x - here.x) if here is not None and far else context.mission.robot.yaw
    goal = Pose2D(x=place.x, y=place.y, yaw=wrap(yaw))
    if place.yaw is None and is_here(context, goal):
        _reached(context, place)
        return
    context.log_event(EventKind.NAVIGATION, f"driving to {place.name}", EventFacts(goal=goal))
    context.navigate((CandidatePose(pose=goal),))


def _reached(context: StepContext, place: PlaceLeg) -> None:
    motion, here = _motion(context), context.mission.robot.pose
    visited = (*context.search.visited, *((here,) if here is not None else ()))
    context.update_search(place_failures=0, refusals=0, visited=visited)
    context.update(motion=replace(motion, legs=motion.legs[1:], reached=(*motion.reached, place.name)))
    context.log_event(EventKind.NAVIGATION, f"at {place.name}")
    context.set_activity(Starting())


def _goal_ended(context: StepContext, ended: GoalEnded) -> None:
    place = _motion(context).legs[0]
    assert isinstance(place, PlaceLeg), "only a place is driven to by a goal"
    what = f"{ended.status.value} {ended.error_code or ''} {ended.error}".strip()
    failures, refusals = context.search.place_failures + 1, context.search.refusals + 1
    match ended.status:
        case GoalStatus.SUCCEEDED:
            _reached(context, place)
        case GoalStatus.REJECTED | GoalStatus.CANCELED if refusals < context.rules.failures_max:
            context.update_search(refusals=refusals)
            context.retry_later("navigation", what, stopped=ended.stopped)
        case GoalStatus.ABORTED | GoalStatus.TIMED_OUT if ended.cause is not GoalCause.UNREACHABLE and failures < TRIES:
            context.update_search(place_failures=failures)
            context.retry_later("navigation", what)
        case _:
            _missed(context, place, what)


def _missed(context: StepContext, place: PlaceLeg, what: str) -> None:
    """A place that may be missed is left, and what was to be done there."""
    motion = _motion(context)
    missed = replace(motion, missed=(*motion.missed, place.name))
    unreachable = (*context.search.unreachable, Pose2D(x=place.x, y=place.y, yaw=0.0))
    context.update_search(unreachable=unreachable, place_failures=0, refusals=0)
    rest = motion.legs[1:]
    following = next((k for k, leg in enumerate(rest) if isinstance(leg, PlaceLeg)), None)
    if not place.may_miss or (following is None and not motion.reached):
        context.update(motion=missed)
        abort(context, EndCause.NAVIGATION, f"{place.name} could not be reached: {what}")
        return
    context.update(motion=replace(missed, legs=() if following is None else rest[following:]))
    context.log_event(EventKind.NAVIGATION, f"{place.name} could not be reached: {what}; going on without it")
    context.set_activity(Starting())


def _drive(context: StepContext, straight: StraightLeg) -> None:
    here = context.mission.robot.odometry
    if straight.start is None and here is not None:
        straight = replace(straight, start=here)
        _instead(context, (straight,))
    left_m = straight.distance_m - _driven_m(context, straight)
    if here is not None and straight.start is not None and abs(wrap(here.yaw - straight.start.yaw)) > ASIDE_RAD:
        done = f"driven {_driven_m(context, straight):.2f} m of {straight.distance_m:.2f} m"
        abort(context, EndCause.CANNOT_MOVE, f"{done}: it was turned meanwhile, straight ahead is another way now")
    elif left_m <= DRIVEN_M:
        _next(context)
    else:
        context.drive(left_m)


def _driven_m(context: StepContext, straight: StraightLeg) -> float:
    here = context.mission.robot.odometry
    return apart_m(here, straight.start) if here is not None and straight.start is not None else 0.0


def _motion_ended(context: StepContext, ended: MotionEnded) -> None:
    leg, why = _motion(context).legs[0], ended.text or ended.end.sentence
    match react(context, ended):
        case Reaction.GO_ON if isinstance(leg, TurnLeg):
            left_rad = leg.angle_rad - next_step_rad(
                leg.angle_rad
            )  # what it ended short of is within what a turn is off by
            _instead(context, (TurnLeg(left_rad),) if abs(left_rad) > FACED_RAD else ())
            context.set_activity(Starting())
        case Reaction.GO_ON:
            _next(context)
        case Reaction.END:
            done = "the turn ended early"
            if isinstance(leg, StraightLeg):
                done = f"driven {_driven_m(context, leg):.2f} m of {leg.distance_m:.2f} m"
            facts = EventFacts(end=ended.end, moved_m=round(ended.driven_m, 3))
            context.log_event(EventKind.MOTION, f"{done}: {why}", facts)
            abort(context, EndCause.CANNOT_MOVE, f"{done}: {why}")
        case _:
            pass


def _done(context: StepContext) -> None:
    motion = _motion(context)
    missed = f"could not reach {', '.join(motion.missed)}" if motion.missed else ""
    seen = others_in_words(context.mission, "seen")
    end(context, Outcome.DONE, "; ".join(filter(None, (motion.what, missed, seen))), None)
