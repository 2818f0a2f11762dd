"""MEMORY_NAV and MOVING_TO_SCAN: where to look next, and driving there (requirements A5, A6, A13)."""

import math

from contracts.geometry import Pose2D
from contracts.mission import EndCause, EventKind, MissionState
from contracts.robot import GoalStatus
from coordinator.core import actions as do
from coordinator.core.activities import ChoosingPath, Entering, Going, PlanningCoverage, Undocking, Waking
from coordinator.core.events import CoveragePlanned, DetectionsSeen, Event, GoalEnded, PathChosen, Undocked
from coordinator.core.geometry import around, distance_m, near_any, wrap
from coordinator.core.mission import Sighting
from coordinator.core.outcomes import abort, abort_for_the_map, give_up
from coordinator.core.rules import CoverageRule
from coordinator.core.sightings import may_be_rejected, new_candidate, sightings, worth_it
from coordinator.core.step_context import Draft

ARRIVED_M = 0.3
GLIMPSE_S = 2.0


def undock_first(draft: Draft) -> bool:
    """True when the robot stands on its dock and was asked to leave it: the state is taken up again afterwards.

    Once a mission: what the base says of its dock lags behind.
    """
    if draft.mission.robot.docked is not True or draft.search.undocks > 0:
        return False
    call, limit_s = draft.call(), draft.rules.undock_timeout_s
    draft.act(do.Undock(call, limit_s))
    draft.be(Undocking(call, draft.now_s + limit_s + draft.rules.call_margin_s))
    draft.say(EventKind.UNDOCK, "leaving the dock first")
    return True


def undocked(draft: Draft) -> None:
    draft.set_search(undocks=draft.search.undocks + 1)
    draft.say(
        EventKind.UNDOCK,
        "off the dock; waiting for a picture, for a robot may turn its camera and lidar off on the dock",
    )
    draft.be(Waking(draft.now_s + draft.rules.wake_s_max))


def awake(draft: Draft) -> None:
    """The first picture after the dock has come, or the time for it is up."""
    draft.be(Entering())


def new_scan(draft: Draft, reason: str, *, start_rad: float | None = None) -> None:
    """A 420 degree look round in equal steps that overlap in the picture, from the heading that promises most."""
    rules = draft.rules
    start = draft.mission.robot.yaw if start_rad is None else start_rad
    widest = rules.camera_hfov_rad * (1.0 - rules.scan_overlap_min)
    count = math.ceil(rules.scan_angle_rad / min(rules.scan_step_rad, widest) - 1e-6)
    step = rules.scan_angle_rad / count
    headings = tuple(start + k * step for k in range(count + 1))
    draft.set_search(headings=headings, sweeps=0, scan_from=draft.mission.robot.pose)
    draft.go(MissionState.SCANNING, reason)


def next_place(draft: Draft, reason: str) -> None:
    """After a scan: the next remembered view, else exploration."""
    drop_views_looked_at(draft)
    if draft.search.views:
        draft.go(MissionState.MEMORY_NAV, f"{reason}; next remembered place ({draft.search.views[0].reason})")
    else:
        draft.go(MissionState.MOVING_TO_SCAN, f"{reason}; on to the next place of the search")


def drop_views_looked_at(draft: Draft) -> None:
    search, near_m = draft.search, draft.rules.view_separation_m
    draft.set_search(views=tuple(v for v in search.views if not near_any(v.pose, search.looked, near_m)))


def begin_memory_nav(draft: Draft) -> None:
    if undock_first(draft):
        return
    drop_views_looked_at(draft)
    if not draft.search.views:
        if draft.search.looked:
            draft.go(MissionState.MOVING_TO_SCAN, "no remembered place is left: exploring")
        else:
            new_scan(draft, "no remembered place could be reached: looking round here first")
        return
    place = draft.search.views[0]
    if _is_here(draft, place.pose):
        _arrive(draft)
        return
    draft.say(EventKind.NAVIGATION, f"to a remembered place: {place.reason}", goal=place.pose.model_dump())
    _choose(draft, place.pose)


def begin_moving(draft: Draft) -> None:
    if undock_first(draft):
        return
    rules, search = draft.rules, draft.search
    if rules.coverage_rule is CoverageRule.VIEWPOINTS or search.plans == 0:
        action = do.PlanCoverage(draft.call(), (*search.looked, *search.unreachable), rules.plan_timeout_s)
        draft.act(action)
        draft.be(PlanningCoverage(action.call, draft.now_s + action.timeout_s + rules.call_margin_s))
        return
    _to_next_point(draft)


def handle(draft: Draft, event: Event) -> None:
    """Both states: they differ in where the next place comes from."""
    match draft.mission.activity, event:
        case Undocking(), Undocked():
            undocked(draft)
        case Waking(), DetectionsSeen():
            awake(draft)
        case PlanningCoverage(), CoveragePlanned(trouble=trouble) if trouble is not None:
            abort_for_the_map(draft, trouble)
        case PlanningCoverage(), CoveragePlanned(points=points):
            draft.set_search(points=points[: draft.rules.scan_points_max], plans=draft.search.plans + 1)
            _to_next_point(draft)
        case ChoosingPath(poses=poses), PathChosen(index=index) if index is not None and index < len(poses):
            draft.navigate(poses[index])
        case ChoosingPath(), PathChosen(error=error):
            _skip(draft, f"no path there ({error or 'no reason given'})")
        case Going(), GoalEnded():
            _goal_ended(draft, event)
        case ((ChoosingPath() | Going() | PlanningCoverage()), DetectionsSeen()):
            _maybe_seen(draft, event)
        case _:
            pass


def _maybe_seen(draft: Draft, event: DetectionsSeen) -> None:
    """A drive is stopped for what two pictures in a row show: for a flicker it would end in one more look round."""
    sure = tuple(
        s
        for s in sightings(draft.mission, event.detections)
        if s.confidence >= draft.rules.moving_confidence_min
        and worth_it(draft.mission, s)
        and not may_be_rejected(draft.mission, s)
    )
    before = draft.search.glimpsed
    if sure != before:
        draft.set_search(glimpsed=sure)
    sighting = next((s for s in sure if not draft.rules.moving_twice or _again(s, before, draft.rules.track_rad)), None)
    if sighting is None:
        return
    draft.stop_motion()
    new_candidate(draft, sighting)
    draft.set_search(headings=(), glimpsed=())
    draft.say(EventKind.SIGHTING, "seen on the way", confidence=sighting.confidence, colour=sighting.colour)
    draft.go(MissionState.CENTERING, "seen on the way: stopping to look")


def _again(sighting: Sighting, before: tuple[Sighting, ...], within_rad: float) -> bool:
    return any(
        0.0 < sighting.stamp_s - other.stamp_s <= GLIMPSE_S
        and abs(wrap(sighting.bearing_rad - other.bearing_rad)) <= within_rad
        for other in before
    )


def _goal_ended(draft: Draft, event: GoalEnded) -> None:
    going = draft.mission.activity
    assert isinstance(going, Going)
    what = f"{event.status.value} {event.error_code or ''} {event.error}".strip()
    if event.status not in {GoalStatus.REJECTED, GoalStatus.CANCELED}:
        draft.set_search(refusals=0)
    match event.status:
        case GoalStatus.SUCCEEDED:
            _arrive(draft)
        case GoalStatus.ABORTED if going.tries == 0:
            draft.say(EventKind.NAVIGATION, f"{what}: clearing the costmaps and trying once more from here",
                      error_code=event.error_code)  # fmt: skip
            draft.navigate(going.goal, tries=1)
        case GoalStatus.REJECTED | GoalStatus.CANCELED:
            _refused(draft, what, stopped=event.stopped)
        case _:
            _skip(draft, what)


def _refused(draft: Draft, what: str, *, stopped: bool) -> None:
    """A rejecting server is likely inactive, and a goal that others cancelled was cut off: once more after a pause."""
    search = draft.search
    draft.set_search(place_failures=search.place_failures + 1, refusals=search.refusals + 1)
    if draft.search.refusals >= draft.rules.failures_max:
        abort(draft, EndCause.NAVIGATION, f"navigation refused {draft.search.refusals} goals in a row: {what}")
    elif draft.search.place_failures > 1:
        _skip(draft, what)
    else:
        draft.fail("navigation", what, stopped=stopped)


def skip_after_failure(draft: Draft) -> bool:
    """True when the call for this place failed twice in a row: another place is tried."""
    draft.set_search(place_failures=draft.search.place_failures + 1)
    if draft.search.place_failures <= 1 or not isinstance(draft.mission.activity, Going | ChoosingPath):
        return False
    _skip(draft, "its calls failed twice")
    return True


def _skip(draft: Draft, why: str) -> None:
    search = draft.search
    missed = search.missed_in_row + 1
    draft.set_search(missed_in_row=missed)
    if missed >= draft.rules.places_missed_max:
        abort(
            draft,
            EndCause.NAVIGATION,
            f"navigation reached none of {missed} places in a row, the last one because: {why}",
        )
        return
    if draft.mission.state is MissionState.MEMORY_NAV:
        lost, views = search.views[0].pose, search.views[1:]
        draft.set_search(views=views, unreachable=(*search.unreachable, lost), place_failures=0)
    elif search.points:
        draft.set_search(
            points=search.points[1:], unreachable=(*search.unreachable, search.points[0]), place_failures=0
        )
    draft.go(draft.mission.state, f"skipping this place: {why}")


def _arrive(draft: Draft) -> None:
    draft.set_search(place_failures=0, missed_in_row=0)
    if draft.mission.state is MissionState.MEMORY_NAV:
        place = draft.search.views[0]
        draft.set_search(views=draft.search.views[1:])
        new_scan(draft, "arrived where it was seen: looking round", start_rad=place.pose.yaw)
    else:
        draft.set_search(points=draft.search.points[1:])
        new_scan(draft, "arrived at the next place: looking round")


def _to_next_point(draft: Draft) -> None:
    search, near_m = draft.search, 0.35
    done = (*search.looked, *search.unreachable)
    points = tuple(p for p in search.points if not near_any(p, done, near_m))
    draft.set_search(points=points)
    if not points:
        if search.unreachable:
            give_up(draft, EndCause.NO_PLACE_LEFT, "no other place could be reached")
        else:
            give_up(draft, EndCause.ALL_LOOKED, "every place was looked at")
        return
    draft.say(
        EventKind.NAVIGATION, f"to the next place of the search, {len(points)} to go", goal=points[0].model_dump()
    )
    if _is_here(draft, points[0]):
        _arrive(draft)
    else:
        _choose(draft, points[0])


def _choose(draft: Draft, pose: Pose2D) -> None:
    """The wanted pose itself, else one of a ring round it (half the failures in A19 were path rejections)."""
    groups = ((pose,), around(pose, 0.35, 6), around(pose, 0.7, 8))
    draft.choose_path(groups, tuple(0.0 for group in groups for _ in group))


def _is_here(draft: Draft, pose: Pose2D) -> bool:
    here = draft.mission.robot.pose
    return here is not None and distance_m(here, pose) <= ARRIVED_M
