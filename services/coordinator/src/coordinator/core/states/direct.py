"""The direct approach: what was seen is driven up to at once; its place and its votes come on the way. Without a
measurement the robot drives in the direction it was seen in, until there is one.

The evidence of a find is the usual one: the votes by the mission's rule, measurements that agree, and a last one from
near. What is not sure when the robot arrives is centred on, measured and judged standing, as always.
"""

import math

from contracts.geometry import Pose2D
from contracts.mission import EventKind, MissionState
from contracts.robot import CandidatePose, GoalStatus
from contracts.vision import Detections, Validation
from coordinator.core.activities import Navigating
from coordinator.core.approach_poses import approach_candidates
from coordinator.core.events import CallFailed, DetectionsSeen, Event, GoalEnded, Tick, Validated
from coordinator.core.mission import Approach, NearGoal
from coordinator.core.search import back_to_search
from coordinator.core.sightings import follow, reject, tracked
from coordinator.core.states.approaching import APPROACH_TIMEOUT_S, Approaching
from coordinator.core.states.centering import Centering, leave_for_its_colour, other_colour
from coordinator.core.states.depth_check import (
    ask_votes,
    in_words,
    is_no_clear_no,
    is_out_of_range,
    label_of,
    take_votes,
    unseen,
)
from coordinator.core.step_context import StepContext
from coordinator.core.tracking import Track
from geometry.poses import wrap

SHIFT_M = 0.35
"""A goal that is wrong by more than this is replaced on the way: each new one costs a second or two of standing."""
TOWARDS_M = (2.0, 1.5, 1.0, 0.6)
DETOUR = 3.0
"""So many metres of way a metre in its direction is worth."""
GOAL_S_MIN = 3.0
GOALS_MAX = 4
VOTES_PERIOD_S = 1.0
UNJUDGED_S = 3.0
STANDING_M = 1.3
"""What is in doubt this near is judged standing: from nearer a table may hide what stands on it."""
CLEAR_NOES = 2
"""One picture from a moving robot may be a bad one."""


class DirectCentering(Centering):
    """Only what has no place, or was not settled on the way, is turned to."""

    def begin(self, context: StepContext) -> None:
        candidate = context.candidate
        first = candidate.rounds == 0 and context.mission.robot.pose is not None
        if first and (candidate.track is not None or is_out_of_range(candidate.sighting)):
            known = "its place is measured: driving up to it at once"
            text = known if candidate.track is not None else "too far away to measure: driving towards it"
            context.update_candidate(rounds=1, since_s=context.now_s)
            context.transition_to(MissionState.APPROACHING, text)
        else:
            super().begin(context)


class DirectApproach(Approaching):
    def begin(self, context: StepContext) -> None:
        candidate, near_m = context.candidate, context.rules.near_m
        settled = candidate.confirmed and (candidate.distance_m is None or candidate.distance_m <= near_m)
        if settled or (candidate.track is None and candidate.map_xy is not None):
            super().begin(context)
            return
        context.update(approach=Approach(until_s=context.now_s + APPROACH_TIMEOUT_S))
        if candidate.track is None:
            _drive_towards(context)
        elif not _drive_on(context, "driving to a place in front of it"):
            _look_standing(context)

    def handle(self, context: StepContext, event: Event) -> None:
        on_the_way = context.approach.goal is not None
        match context.mission.activity, event:
            case Navigating(), DetectionsSeen(detections=seen) if on_the_way:
                _seen(context, seen)
            case _, Validated(validation=validation):
                _judged(context, validation)
            case _, CallFailed():
                context.update_approach(votes_call=0, votes_due_s=context.now_s + UNJUDGED_S)
            case _, Tick() if on_the_way and context.now_s >= context.approach.until_s:
                context.stop_motion()
                _look_standing(context)
            case Navigating(), GoalEnded(status=status) if on_the_way:
                arrived = status is GoalStatus.SUCCEEDED
                if arrived and _is_stale(context) and _drive_on(context, "its place is known better: driving on"):
                    return
                if _is_settled(context):
                    context.update_approach(goal=None)
                    super().handle(context, event)
                else:
                    _look_standing(context)
            case _:
                super().handle(context, event)


def _drive_towards(context: StepContext) -> None:
    """In the direction it was seen in. A place that only a long way round leads to is not worth it."""
    pose, bearing_rad = context.mission.robot.pose, context.candidate.sighting.bearing_rad
    assert pose is not None, "what is driven towards was seen from somewhere"
    context.update_approach(goal=NearGoal(None, 0.0, context.now_s))
    context.navigate(
        tuple(
            CandidatePose(
                pose=Pose2D(
                    x=pose.x + metres * math.cos(bearing_rad),
                    y=pose.y + metres * math.sin(bearing_rad),
                    yaw=wrap(bearing_rad),
                ),
                cost_m=DETOUR * (TOWARDS_M[0] - metres),
            )
            for metres in TOWARDS_M
        ),
        ring_radius_m=0.0,
    )


def _drive_on(context: StepContext, text: str) -> bool:
    """False when no goal nearer to it is left to drive to."""
    track, rules = context.candidate.track, context.rules
    assert track is not None, "the direct way leads to a measured place"
    context.update_candidate(map_xy=track.place, odom_xy=None, sigma_m=track.sigma_m)
    radius_m = _radius_m(context)
    radii_m = (radius_m, *(r for r in rules.ring_radii_m if r > radius_m))
    candidates = approach_candidates(context, radii_m[:8])
    if not candidates or context.approach.goals >= GOALS_MAX:
        return False
    goal = NearGoal(track.place, radius_m, context.now_s)
    context.update_approach(goal=goal, goals=context.approach.goals + 1)
    context.log_event(EventKind.NAVIGATION, text)
    context.navigate(candidates, ring_radius_m=0.0)
    return True


def _radius_m(context: StepContext) -> float:
    """How near the goal may be chosen: nearer, the worse its place is known, would be into it."""
    track = context.candidate.track
    return context.rules.ring_radii_m[0] + (2.0 * track.sigma_m if track is not None and track.sigma_m > 0.1 else 0.0)


def _is_stale(context: StepContext) -> bool:
    track, goal = context.candidate.track, context.approach.goal
    if track is None or goal is None:
        return False
    if goal.thing_xy is None:
        return True
    return math.dist(track.place, goal.thing_xy) + max(0.0, goal.radius_m - _radius_m(context)) > SHIFT_M


def _seen(context: StepContext, seen: Detections) -> None:
    other = other_colour(context, seen)
    if other:
        leave_for_its_colour(context, other)
        return
    sighting = tracked(context.mission, context.candidate, seen)
    if sighting is None:
        return
    before = context.candidate.track
    follow(context, sighting)
    if before is not None and _is_another(context, before):
        context.log_event(EventKind.SIGHTING, "what is seen now stands elsewhere: judging it anew")
        context.update_candidate(confirmed=False, votes=(), log_odds=(), judged_s=None)
        context.update_approach(votes_call=0, votes_due_s=context.now_s, clear_noes=0)
    candidate, approach, rules = context.candidate, context.approach, context.rules
    distance_m = sighting.measurement.distance_m
    if candidate.track is not None:
        context.update_candidate(map_xy=candidate.track.place, sigma_m=candidate.track.sigma_m)
    if distance_m is not None:
        context.update_candidate(distance_m=distance_m)
        due = approach.votes_call == 0 and context.now_s >= approach.votes_due_s
        if due and not candidate.confirmed and distance_m <= rules.far_m:
            context.update_approach(votes_call=ask_votes(context, moving=True))
    goal = approach.goal
    if goal is None or not _is_stale(context):
        return
    if goal.thing_xy is None:
        _drive_on(context, "its place is measured: driving up to it")
    elif context.now_s - goal.since_s >= GOAL_S_MIN:
        _drive_on(context, "its place is known better: driving there instead")


def _is_another(context: StepContext, before: Track) -> bool:
    """After measurements in a row that fit the old place badly (`fused`): no vote was about what stands here."""
    track = context.candidate.track
    if track is None or track.hits >= before.hits:
        return False
    return math.dist(track.place, before.place) > context.rules.rejected_radius_m


def _judged(context: StepContext, validation: Validation) -> None:
    context.update_approach(votes_call=0, votes_due_s=context.now_s + VOTES_PERIOD_S)
    if take_votes(context, validation):
        context.update_approach(clear_noes=0)
        return
    votes, distance_m = validation.votes, context.candidate.distance_m or math.inf
    clear = not (unseen(votes) or is_no_clear_no(context, votes))
    context.update_approach(clear_noes=context.approach.clear_noes + clear)
    if context.approach.clear_noes >= CLEAR_NOES:
        context.stop_motion()
        reject(context, f"a {label_of(context)} {distance_m:.1f} m off ({in_words(votes)})", narrow=False)
        back_to_search(context, f"refused on the way ({in_words(votes)})")
    elif distance_m <= STANDING_M and context.approach.goal is not None:
        context.stop_motion()
        _look_standing(context)


def _is_settled(context: StepContext) -> bool:
    """Confirmed, and as many measurements agree as a depth check asks for."""
    candidate = context.candidate
    return candidate.confirmed and candidate.track is not None and candidate.track.hits >= context.rules.depth_agree


def _look_standing(context: StepContext) -> None:
    """It is turned to where it was seen last: its place may be wrong."""
    context.update_approach(goal=None, votes_call=0)
    context.update_candidate(map_xy=None, odom_xy=None)
    context.transition_to(MissionState.CENTERING, "not settled on the way: looking at it")
