"""MEMORY_NAV and MOVING_TO_SCAN: where to look next, and driving there (requirements A5, A6, A13)."""

import math

from contracts.geometry import Pose2D
from contracts.mission import EndCause, EventKind, MissionState
from contracts.robot import GoalStatus
from coordinator.core import actions as do
from coordinator.core.activities import ChoosingPath, Navigating, PlanningCoverage, Starting, Undocking, Waking
from coordinator.core.events import CoveragePlanned, DetectionsSeen, Event, GoalEnded, PathChosen, Undocked
from coordinator.core.geometry import around, distance_m, near_any, wrap
from coordinator.core.mission import Sighting
from coordinator.core.outcomes import abort, abort_for_the_map, give_up
from coordinator.core.rules import CoverageRule
from coordinator.core.sightings import is_near_rejected, is_worth_pursuing, new_candidate, sightings
from coordinator.core.step_context import StepContext

ARRIVED_M = 0.3
GLIMPSE_S = 2.0


def undock_first(context: StepContext) -> bool:
    """True when the robot stands on its dock and was asked to leave it: the state is taken up again afterwards.

    Once a mission: what the base says of its dock lags behind.
    """
    if context.mission.robot.docked is not True or context.search.undocks > 0:
        return False
    call, limit_s = context.call(), context.rules.undock_timeout_s
    context.request(do.Undock(call, limit_s))
    context.set_activity(Undocking(call, context.now_s + limit_s + context.rules.call_margin_s))
    context.log_event(EventKind.UNDOCK, "leaving the dock first")
    return True


def undocked(context: StepContext) -> None:
    context.update_search(undocks=context.search.undocks + 1)
    context.log_event(
        EventKind.UNDOCK,
        "off the dock; waiting for the camera to start",
    )
    context.set_activity(Waking(context.now_s + context.rules.wake_s_max))


def awake(context: StepContext) -> None:
    """The first picture after the dock has come, or the time for it is up."""
    context.set_activity(Starting())


def new_scan(context: StepContext, reason: str, *, start_rad: float | None = None) -> None:
    """A 420 degree look round in equal steps that overlap in the picture, from the heading that promises most."""
    rules = context.rules
    start = context.mission.robot.yaw if start_rad is None else start_rad
    widest = rules.camera_hfov_rad * (1.0 - rules.scan_overlap_min)
    count = math.ceil(rules.scan_angle_rad / min(rules.scan_step_rad, widest) - 1e-6)
    step = rules.scan_angle_rad / count
    headings = tuple(start + k * step for k in range(count + 1))
    context.update_search(headings=headings, sweeps=0, scan_from=context.mission.robot.pose)
    context.transition_to(MissionState.SCANNING, reason)


def next_place(context: StepContext, reason: str) -> None:
    """After a scan: the next remembered view, else exploration."""
    drop_views_looked_at(context)
    if context.search.views:
        context.transition_to(
            MissionState.MEMORY_NAV, f"{reason}; next remembered place ({context.search.views[0].reason})"
        )
    else:
        context.transition_to(MissionState.MOVING_TO_SCAN, f"{reason}; continuing with the next search place")


def drop_views_looked_at(context: StepContext) -> None:
    search, near_m = context.search, context.rules.view_separation_m
    context.update_search(views=tuple(v for v in search.views if not near_any(v.pose, search.visited, near_m)))


def begin_memory_nav(context: StepContext) -> None:
    if undock_first(context):
        return
    drop_views_looked_at(context)
    if not context.search.views:
        if context.search.visited:
            context.transition_to(MissionState.MOVING_TO_SCAN, "no remembered places left: exploring")
        else:
            new_scan(context, "no remembered place could be reached: looking around here first")
        return
    place = context.search.views[0]
    if _is_here(context, place.pose):
        _arrive(context)
        return
    context.log_event(
        EventKind.NAVIGATION, f"driving to a remembered place: {place.reason}", goal=place.pose.model_dump()
    )
    _choose(context, place.pose)


def begin_moving(context: StepContext) -> None:
    if undock_first(context):
        return
    rules, search = context.rules, context.search
    if rules.coverage_rule is CoverageRule.VIEWPOINTS or search.plans == 0:
        action = do.PlanCoverage(context.call(), (*search.visited, *search.unreachable), rules.plan_timeout_s)
        context.request(action)
        context.set_activity(PlanningCoverage(action.call, context.now_s + action.timeout_s + rules.call_margin_s))
        return
    _to_next_point(context)


def handle(context: StepContext, event: Event) -> None:
    """Both states: they differ in where the next place comes from."""
    match context.mission.activity, event:
        case Undocking(), Undocked():
            undocked(context)
        case Waking(), DetectionsSeen():
            awake(context)
        case PlanningCoverage(), CoveragePlanned(trouble=trouble) if trouble is not None:
            abort_for_the_map(context, trouble)
        case PlanningCoverage(), CoveragePlanned(points=points):
            context.update_search(points=points[: context.rules.scan_points_max], plans=context.search.plans + 1)
            _to_next_point(context)
        case ChoosingPath(poses=poses), PathChosen(index=index) if index is not None and index < len(poses):
            context.navigate(poses[index])
        case ChoosingPath(), PathChosen(error=error):
            _skip(context, f"no path there ({error or 'no reason given'})")
        case Navigating(), GoalEnded():
            _goal_ended(context, event)
        case ((ChoosingPath() | Navigating() | PlanningCoverage()), DetectionsSeen()):
            _maybe_seen(context, event)
        case _:
            pass


def _maybe_seen(context: StepContext, event: DetectionsSeen) -> None:
    """A drive is stopped for what two pictures in a row show: for a flicker it would end in one more look round."""
    sure = tuple(
        s
        for s in sightings(context.mission, event.detections)
        if s.confidence >= context.rules.moving_confidence_min
        and is_worth_pursuing(context.mission, s)
        and not is_near_rejected(context.mission, s)
    )
    before = context.search.tentative_sightings
    if sure != before:
        context.update_search(tentative_sightings=sure)
    sighting = next(
        (s for s in sure if not context.rules.moving_twice or _again(s, before, context.rules.track_rad)), None
    )
    if sighting is None:
        return
    context.stop_motion()
    new_candidate(context, sighting)
    context.update_search(headings=(), tentative_sightings=())
    context.log_event(EventKind.SIGHTING, "seen on the way", confidence=sighting.confidence, colour=sighting.colour)
    context.transition_to(MissionState.CENTERING, "spotted on the way: stopping to look")


def _again(sighting: Sighting, before: tuple[Sighting, ...], within_rad: float) -> bool:
    return any(
        0.0 < sighting.stamp_s - other.stamp_s <= GLIMPSE_S
        and abs(wrap(sighting.bearing_rad - other.bearing_rad)) <= within_rad
        for other in before
    )


def _goal_ended(context: StepContext, event: GoalEnded) -> None:
    going = context.mission.activity
    assert isinstance(going, Navigating)
    what = f"{event.status.value} {event.error_code or ''} {event.error}".strip()
    if event.status not in {GoalStatus.REJECTED, GoalStatus.CANCELED}:
        context.update_search(refusals=0)
    match event.status:
        case GoalStatus.SUCCEEDED:
            _arrive(context)
        case GoalStatus.ABORTED if going.tries == 0:
            context.log_event(EventKind.NAVIGATION, f"{what}: clearing the costmaps and trying again",
                      error_code=event.error_code)  # fmt: skip
            context.navigate(going.goal, tries=1)
        case GoalStatus.REJECTED | GoalStatus.CANCELED:
            _refused(context, what, stopped=event.stopped)
        case _:
            _skip(context, what)


def _refused(context: StepContext, what: str, *, stopped: bool) -> None:
    """A rejecting server is likely inactive, and a goal that others cancelled was cut off: once more after a pause."""
    search = context.search
    context.update_search(place_failures=search.place_failures + 1, refusals=search.refusals + 1)
    if context.search.refusals >= context.rules.failures_max:
        abort(context, EndCause.NAVIGATION, f"navigation refused {context.search.refusals} goals in a row: {what}")
    elif context.search.place_failures > 1:
        _skip(context, what)
    else:
        context.retry_later("navigation", what, stopped=stopped)


def skip_after_failure(context: StepContext) -> bool:
    """True when the call for this place failed twice in a row: another place is tried."""
    context.update_search(place_failures=context.search.place_failures + 1)
    if context.search.place_failures <= 1 or not isinstance(context.mission.activity, Navigating | ChoosingPath):
        return False
    _skip(context, "two requests failed")
    return True


def _skip(context: StepContext, why: str) -> None:
    search = context.search
    missed = search.consecutive_unreachable + 1
    context.update_search(consecutive_unreachable=missed)
    if missed >= context.rules.places_missed_max:
        abort(
            context,
            EndCause.NAVIGATION,
            f"navigation reached none of {missed} places in a row; the last one: {why}",
        )
        return
    if context.mission.state is MissionState.MEMORY_NAV:
        lost, views = search.views[0].pose, search.views[1:]
        context.update_search(views=views, unreachable=(*search.unreachable, lost), place_failures=0)
    elif search.points:
        context.update_search(
            points=search.points[1:], unreachable=(*search.unreachable, search.points[0]), place_failures=0
        )
    context.transition_to(context.mission.state, f"skipping this place: {why}")


def _arrive(context: StepContext) -> None:
    context.update_search(place_failures=0, consecutive_unreachable=0)
    if context.mission.state is MissionState.MEMORY_NAV:
        place = context.search.views[0]
        context.update_search(views=context.search.views[1:])
        new_scan(context, "arrived where it was seen before: looking around", start_rad=place.pose.yaw)
    else:
        context.update_search(points=context.search.points[1:])
        new_scan(context, "arrived at the search place: looking around")


def _to_next_point(context: StepContext) -> None:
    search, near_m = context.search, 0.35
    done = (*search.visited, *search.unreachable)
    points = tuple(p for p in search.points if not near_any(p, done, near_m))
    context.update_search(points=points)
    if not points:
        if search.unreachable:
            give_up(context, EndCause.NO_PLACE_LEFT, "no other place could be reached")
        else:
            give_up(context, EndCause.ALL_LOOKED, "every place was looked at")
        return
    context.log_event(
        EventKind.NAVIGATION, f"driving to the next search place, {len(points)} left", goal=points[0].model_dump()
    )
    if _is_here(context, points[0]):
        _arrive(context)
    else:
        _choose(context, points[0])


def _choose(context: StepContext, pose: Pose2D) -> None:
    """The wanted pose itself, else one of a ring round it (half the failures in A19 were path rejections)."""
    groups = ((pose,), around(pose, 0.35, 6), around(pose, 0.7, 8))
    context.choose_path(groups, tuple(0.0 for group in groups for _ in group))


def _is_here(context: StepContext, pose: Pose2D) -> bool:
    here = context.mission.robot.pose
    return here is not None and distance_m(here, pose) <= ARRIVED_M
