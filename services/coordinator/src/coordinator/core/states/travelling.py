"""MEMORY_NAV and MOVING_TO_SCAN: driving to where to look next (requirements A5, A6, A13)."""

from abc import ABC, abstractmethod

from contracts.geometry import Pose2D
from contracts.mission import EndCause, EventFacts, EventKind, MissionState
from contracts.robot import CandidatePose, GoalStatus
from coordinator.core import actions as do
from coordinator.core.activities import Navigating, PlanningCoverage
from coordinator.core.approach_poses import look_candidates
from coordinator.core.events import CoveragePlanned, DetectionsSeen, Event, GoalEnded
from coordinator.core.geometry import near_any, relative
from coordinator.core.mission import Sighting
from coordinator.core.outcomes import abort, abort_for_the_map, give_up
from coordinator.core.search import drop_views_looked_at, new_scan
from coordinator.core.sightings import (
    is_near_rejected,
    is_worth_pursuing,
    keep_what_is_elsewhere,
    new_candidate,
    sightings,
)  # fmt: skip
from coordinator.core.states.state import State
from coordinator.core.states.weighing import revisit
from coordinator.core.step_context import StepContext
from geometry.poses import apart_m, wrap

ARRIVED_M = 0.3
NEAR_POINT_M = 0.35
GLIMPSE_S = 2.0


class Travelling(State, ABC):
    """Both states. They differ in where the next place comes from."""

    @abstractmethod
    def on_arrival(self, context: StepContext) -> None: ...

    @abstractmethod
    def drop_place(self, context: StepContext) -> None:
        """The next place is one that cannot be reached."""

    def handle(self, context: StepContext, event: Event) -> None:
        match context.mission.activity, event:
            case Navigating(), GoalEnded():
                self._goal_ended(context, event)
            case ((Navigating() | PlanningCoverage()), DetectionsSeen()):
                stop_if_seen(context, event)
            case _:
                pass

    def on_call_failed(self, context: StepContext, detail: str) -> bool:
        """Another place is tried when the call for this one failed twice in a row."""
        del detail
        context.update_search(place_failures=context.search.place_failures + 1)
        if context.search.place_failures <= 1 or not isinstance(context.mission.activity, Navigating):
            return False
        self._skip(context, "two requests failed")
        context.count_failure()
        return True

    def _goal_ended(self, context: StepContext, event: GoalEnded) -> None:
        what = f"{event.status.value} {event.error_code or ''} {event.error}".strip()
        if event.status not in {GoalStatus.REJECTED, GoalStatus.CANCELED}:
            context.update_search(refusals=0)
        match event.status:
            case GoalStatus.SUCCEEDED:
                self.arrive(context)
            case GoalStatus.REJECTED | GoalStatus.CANCELED:
                self._refused(context, what, stopped=event.stopped)
            case _:
                self._skip(context, what)

    def _refused(self, context: StepContext, what: str, *, stopped: bool) -> None:
        """A rejecting server is likely inactive, and others may have cancelled a goal: once more, after a pause."""
        failures, refusals = context.search.place_failures + 1, context.search.refusals + 1
        context.update_search(place_failures=failures, refusals=refusals)
        if refusals >= context.rules.failures_max:
            abort(context, EndCause.NAVIGATION, f"navigation refused {refusals} goals in a row: {what}")
        elif failures > 1:
            self._skip(context, what)
        else:
            context.retry_later("navigation", what, stopped=stopped)

    def _skip(self, context: StepContext, why: str) -> None:
        missed = context.search.consecutive_unreachable + 1
        context.update_search(consecutive_unreachable=missed)
        if missed >= context.rules.places_missed_max:
            reached_none = f"navigation reached none of {missed} places in a row; the last one: {why}"
            abort(context, EndCause.NAVIGATION, reached_none)
            return
        self.drop_place(context)
        context.transition_to(context.mission.state, f"skipping this place: {why}")

    def arrive(self, context: StepContext) -> None:
        context.update_search(place_failures=0, consecutive_unreachable=0)
        self.on_arrival(context)


class MemoryNav(Travelling):
    def begin(self, context: StepContext) -> None:
        drop_views_looked_at(context)
        if not context.search.views:
            if context.search.visited:
                context.transition_to(MissionState.MOVING_TO_SCAN, "no remembered places left: exploring")
            else:
                new_scan(context, "no remembered place could be reached: looking around here first")
            return
        place = context.search.views[0]
        if is_here(context, place.pose):
            self.arrive(context)
            return
        candidates = look_candidates(context, place)
        context.log_event(
            EventKind.NAVIGATION, f"driving to a remembered place: {place.reason}", EventFacts(goal=candidates[0].pose)
        )
        context.navigate(candidates)

    def on_arrival(self, context: StepContext) -> None:
        place, *others = context.search.views
        context.update_search(views=tuple(others))
        here, start_rad = context.mission.robot.pose, place.pose.yaw
        if here is not None and place.thing_xy is not None:
            start_rad = relative(*place.thing_xy, here).bearing_rad + here.yaw
        new_scan(context, "arrived where it was seen before: looking around", start_rad=start_rad)

    def drop_place(self, context: StepContext) -> None:
        place, *others = context.search.views
        unreachable = (*context.search.unreachable, place.pose)
        context.update_search(views=tuple(others), unreachable=unreachable, place_failures=0)


class MovingToScan(Travelling):
    def begin(self, context: StepContext) -> None:
        """Plans afresh for each place: what was seen on the way need not be looked at again."""
        search, rules = context.search, context.rules
        action = do.PlanCoverage(context.call(), (*search.visited, *search.unreachable), rules.plan_timeout_s)
        context.request(action)
        context.set_activity(PlanningCoverage(action.call, context.now_s + action.timeout_s + rules.call_margin_s))

    def handle(self, context: StepContext, event: Event) -> None:
        match context.mission.activity, event:
            case PlanningCoverage(), CoveragePlanned(trouble=trouble) if trouble is not None:
                abort_for_the_map(context, trouble)
            case PlanningCoverage(), CoveragePlanned(points=points):
                plans, points = context.search.plans + 1, points[: context.rules.scan_points_max]
                context.update_search(points=points, plans=plans)
                self.to_next_point(context)
            case _:
                super().handle(context, event)

    def to_next_point(self, context: StepContext) -> None:
        search = context.search
        done = (*search.visited, *search.unreachable)
        points = tuple(p for p in search.points if not near_any(p, done, NEAR_POINT_M))
        context.update_search(points=points)
        if not points:
            if revisit(context):
                return
            if search.unreachable:
                give_up(context, EndCause.NO_PLACE_LEFT, "no other place could be reached")
            else:
                give_up(context, EndCause.ALL_LOOKED, "every place was looked at")
            return
        to_go = f"driving to the next search place, {len(points)} left"
        context.log_event(EventKind.NAVIGATION, to_go, EventFacts(goal=points[0]))
        if is_here(context, points[0]):
            self.arrive(context)
        else:
            context.navigate((CandidatePose(pose=points[0]),))

    def on_arrival(self, context: StepContext) -> None:
        context.update_search(points=context.search.points[1:])
        new_scan(context, "arrived at the search place: looking around")

    def drop_place(self, context: StepContext) -> None:
        if context.search.points:
            place, *others = context.search.points
            unreachable = (*context.search.unreachable, place)
            context.update_search(points=tuple(others), unreachable=unreachable, place_failures=0)


def is_here(context: StepContext, pose: Pose2D) -> bool:
    here = context.mission.robot.pose
    return here is not None and apart_m(here, pose) <= ARRIVED_M


def stop_if_seen(context: StepContext, event: DetectionsSeen) -> None:
    """A drive is stopped for what two pictures in a row show: for a flicker it would end in one more look round."""
    keep_what_is_elsewhere(context, event.detections, confidence_min=context.rules.moving_confidence_min)
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
    context.log_event(
        EventKind.SIGHTING, "seen on the way", EventFacts(confidence=sighting.confidence, colour=sighting.colour)
    )
    context.transition_to(MissionState.CENTERING, "spotted on the way: stopping to look")


def _again(sighting: Sighting, before: tuple[Sighting, ...], within_rad: float) -> bool:
    return any(
        0.0 < sighting.stamp_s - other.stamp_s <= GLIMPSE_S
        and abs(wrap(sighting.bearing_rad - other.bearing_rad)) <= within_rad
        for other in before
    )
