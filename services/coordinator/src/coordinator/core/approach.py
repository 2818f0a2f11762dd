"""APPROACHING by place: once localised, the robot drives to a reachable pose round the object, turns to it, looks once
more where looking is possible, and drives the rest straight on odometry ("Geometry to mind" in the requirements).
"""

import math

from contracts.mission import EventKind, MissionState
from contracts.robot import GoalStatus, LocalizeReply
from coordinator.core.activities import ChoosingPath, Driving, Going, Looking, Measuring, Stage, Turning
from coordinator.core.approach_poses import ring_groups, surface_distance_m, too_near_for_a_goal, whereabouts
from coordinator.core.centering import set_aside
from coordinator.core.depth_check import take_measurement
from coordinator.core.events import DetectionsSeen, Event, GoalEnded, Localized, MotionEnded, PathChosen
from coordinator.core.mission import Approach
from coordinator.core.obstruction import furniture_before, hindrance
from coordinator.core.outcomes import found
from coordinator.core.plausibility import plausible
from coordinator.core.reactions import Reaction, react
from coordinator.core.sightings import follow, tracked
from coordinator.core.step_context import Draft

TURN_SPEED_RAD_S = 0.8
JUMP_M = 0.5
DRIVES_MAX = 3
DISPUTES_MAX = 4
SETTLED_RAD = 0.12
APPROACH_TIMEOUT_S = 240.0


def begin(draft: Draft) -> None:
    there = whereabouts(draft)
    if there is None:
        draft.go(MissionState.CENTERING, "its place is not known: looking again")
        return
    draft.set(approach=Approach(until_s=draft.now_s + APPROACH_TIMEOUT_S))
    groups, costs = ring_groups(draft, draft.rules.ring_radii_m)
    if there.distance_m <= draft.rules.ring_skip_m or not groups:
        _face(draft)
    else:
        draft.choose_path(groups, costs)


def handle(draft: Draft, event: Event) -> None:
    stage = draft.approach.stage
    match draft.mission.activity, event:
        case ChoosingPath(poses=poses), PathChosen(index=index) if index is not None and index < len(poses):
            if too_near_for_a_goal(draft, poses[index]):
                _face(draft)
                return
            draft.say(EventKind.NAVIGATION, "to a place in front of it", goal=poses[index].model_dump())
            draft.navigate(poses[index])
        case ChoosingPath(), PathChosen(error=error):
            draft.say(EventKind.NAVIGATION, f"no place round it can be reached ({error}): straight on")
            _face(draft)
        case Going(), GoalEnded():
            _goal_ended(draft, event)
        case Turning(), MotionEnded() as ended:
            if _goes_on(draft, ended):
                _turned(draft, stage)
        case Looking(after_s=after_s), DetectionsSeen(detections=seen) if seen.stamp_s >= after_s:
            sighting = tracked(draft.mission, draft.candidate, seen)
            if sighting is not None:
                follow(draft, sighting)
                furniture = furniture_before(seen, sighting.box.bbox_xyxy)
                draft.set_approach(furniture=furniture or draft.approach.furniture)
                draft.localize(sighting.box)
        case Measuring(), Localized(reply=reply):
            _measured(draft, stage, plausible(reply, draft.rules))
        case Driving(), MotionEnded():
            _driven(draft, event)
        case _:
            pass


def _driven(draft: Draft, ended: MotionEnded) -> None:
    """Something in the way may end the approach; what cut the drive off for another reason never does."""
    if not ended.end.completed:
        text = f"the drive ended after {ended.driven_m:.2f} m: {ended.text or ended.end.sentence}"
        draft.say(EventKind.MOTION, text, moved_m=round(ended.driven_m, 3), end=ended.end.value)
    if _goes_on(draft, ended):
        draft.set_approach(stage=Stage.CONFIRM, ended=ended.end)
        draft.look(draft.rules.look_again_s / 2)


def _goes_on(draft: Draft, ended: MotionEnded) -> bool:
    """False when the approach is paused, waits, or is over by this end."""
    reaction = react(draft, ended)
    if reaction is Reaction.SET_ASIDE:
        set_aside(draft, ended.text or ended.end.sentence)
    return reaction in {Reaction.GO_ON, Reaction.AS_NEAR_AS_IT_GETS}


def on_look_timeout(draft: Draft) -> None:
    """It is out of the picture from here, as expected of something high: the place measured before counts."""
    _go_on(draft, draft.approach.stage)


def on_overtime(draft: Draft) -> None:
    draft.stop_motion()
    if _seen_from_afar_only(draft):
        _look_afresh(draft)
        return
    distance_m = surface_distance_m(draft)
    if _within_reach(draft, distance_m) or draft.approach.got_there:
        found(draft, distance_m, "as near as could be reached in time")
    else:
        set_aside(draft, "not reached in time")


def on_failure(draft: Draft) -> None:
    """A measurement failed; what is known is enough to go on."""
    _go_on(draft, draft.approach.stage)


def _goal_ended(draft: Draft, event: GoalEnded) -> None:
    going = draft.mission.activity
    assert isinstance(going, Going)
    if event.status is GoalStatus.ABORTED and going.tries == 0:
        why = f"aborted with error {event.error_code}: clearing the costmaps, once more from here"
        draft.say(EventKind.NAVIGATION, why, error_code=event.error_code)
        draft.navigate(going.goal, tries=1)
        return
    refused = event.status in {GoalStatus.CANCELED, GoalStatus.REJECTED} and draft.search.refusals == 0
    draft.set_search(refusals=1 if refused else 0)
    if refused:
        draft.fail("navigation", f"{event.status.value} {event.error}".strip(), stopped=event.stopped)
        return
    if event.status is not GoalStatus.SUCCEEDED:
        draft.say(EventKind.NAVIGATION, f"{event.status.value} {event.error_code}: straight on from here",
                  error_code=event.error_code)  # fmt: skip
    _face(draft)


def _face(draft: Draft) -> None:
    draft.set_approach(stage=Stage.FACE)
    _turn_or(draft, Stage.FACE, draft.rules.face_tolerance_rad)


def _turn_or(draft: Draft, stage: Stage, tolerance_rad: float) -> None:
    there = whereabouts(draft)
    if there is not None and abs(there.bearing_rad) > tolerance_rad:
        draft.turn(there.bearing_rad, TURN_SPEED_RAD_S)
    else:
        _turned(draft, stage)


def _turned(draft: Draft, stage: Stage) -> None:
    match stage:
        case Stage.RING | Stage.FACE:
            draft.set_approach(stage=Stage.LOOK)
            draft.look(draft.rules.look_again_s)
        case Stage.LOOK | Stage.AIM:
            _drive(draft)
        case Stage.DRIVE | Stage.CONFIRM | Stage.SETTLE:
            _finish(draft)


def _measured(draft: Draft, stage: Stage, reply: LocalizeReply) -> None:
    """Takes the new place where it is near the old one. Of one that jumps a second has to say the same to count:
    either it, or what was believed so far, is wrong.
    """
    old = draft.candidate.map_xy
    new = (reply.map_point.x, reply.map_point.y) if reply.map_point is not None else None
    if reply.distance_m is None or new is None:
        _go_on(draft, stage)
    elif old is not None and math.dist(old, new) > JUMP_M and not _said_before(draft, new):
        draft.say(EventKind.DEPTH, f"measured {math.dist(old, new):.1f} m beside its place: not counted yet")
        draft.set_approach(disputed=(*draft.approach.disputed, new))
        if len(draft.approach.disputed) < DISPUTES_MAX:
            draft.look(draft.rules.look_again_s)
        else:
            _go_on(draft, stage)
    else:
        if old is not None and math.dist(old, new) > JUMP_M:
            draft.set_candidate(map_xy=None, odom_xy=None)
        draft.set_approach(disputed=())
        take_measurement(draft, reply)
        draft.say(EventKind.DEPTH, f"{reply.distance_m:.2f} m away", distance_m=round(reply.distance_m, 3), map_xy=new)
        _go_on(draft, stage)


def _said_before(draft: Draft, new: tuple[float, float]) -> bool:
    return any(math.dist(new, other) <= JUMP_M for other in draft.approach.disputed)


def _go_on(draft: Draft, stage: Stage) -> None:
    if stage in {Stage.RING, Stage.FACE, Stage.LOOK}:
        draft.set_approach(stage=Stage.AIM)
        _turn_or(draft, Stage.AIM, draft.rules.face_tolerance_rad)
        return
    left_m = surface_distance_m(draft)
    again = left_m is not None and left_m > draft.rules.reach_m + 0.03 and not draft.approach.blocked
    if again and draft.approach.drives < DRIVES_MAX:
        draft.set_approach(stage=Stage.AIM)
        _turn_or(draft, Stage.AIM, draft.rules.face_tolerance_rad)
    else:
        draft.set_approach(stage=Stage.SETTLE)
        _turn_or(draft, Stage.SETTLE, SETTLED_RAD)


def _drive(draft: Draft) -> None:
    """The rest of the way, or what ends the approach where nothing is left of it."""
    left_m, rules = surface_distance_m(draft), draft.rules
    rest_m = 0.0 if left_m is None else left_m - min(rules.stand_off_m, rules.reach_m)
    if rest_m <= 0.03:
        draft.set_approach(stage=Stage.SETTLE)
        _turn_or(draft, Stage.SETTLE, SETTLED_RAD)
        return
    draft.set_approach(stage=Stage.DRIVE, drives=draft.approach.drives + 1)
    draft.drive(min(rest_m, 2.0))


def _seen_from_afar_only(draft: Draft) -> bool:
    """What was never measured from near is no find, wherever the robot stands: the one place it has may be wrong."""
    return draft.candidate.distance_m is not None and draft.candidate.distance_m > draft.rules.near_m


def _look_afresh(draft: Draft) -> None:
    """Forgets the place; where it is not seen again either, it is told as what may have been it."""
    draft.set_candidate(map_xy=None, odom_xy=None)
    draft.go(MissionState.CENTERING, "not to be seen from near, only from afar before: looking again")


def _finish(draft: Draft) -> None:
    if _seen_from_afar_only(draft):
        _look_afresh(draft)
        return
    distance, approach = surface_distance_m(draft), draft.approach
    if _within_reach(draft, distance):
        found(draft, distance, "within reach")
        return
    if distance is None:
        set_aside(draft, "nobody knows how far off it is")
        return
    may_try = approach.alternatives < draft.rules.alternatives_max
    if distance > draft.rules.blocked_alternative_m and may_try and _other_side(draft):
        return
    if approach.ended is not None and not approach.got_there:
        set_aside(draft, f"{distance:.2f} m were left: {approach.ended.sentence}")
        return
    found(draft, distance, f"as near as the map allows: {hindrance(approach.blocked, approach.furniture)}")


def _within_reach(draft: Draft, distance_m: float | None) -> bool:
    return distance_m is not None and distance_m <= draft.rules.reach_m + 0.05


def _other_side(draft: Draft) -> bool:
    """True when another part of the ring is to be tried."""
    pose, xy = draft.mission.robot.pose, draft.candidate.map_xy
    if pose is None or xy is None:
        return False
    here_rad = math.atan2(pose.y - xy[1], pose.x - xy[0])
    tried = (*draft.approach.tried_rad, here_rad)
    groups, costs = ring_groups(draft, draft.rules.ring_radii_m[:2], tried)
    if not groups:
        return False
    alternatives = draft.approach.alternatives + 1
    draft.set_approach(stage=Stage.RING, alternatives=alternatives, tried_rad=tried, ended=None, drives=0)
    draft.say(EventKind.NAVIGATION, "stopped too far off: trying another side of it")
    draft.choose_path(groups, costs)
    return True
