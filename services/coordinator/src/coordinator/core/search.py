"""How a search goes on: off the dock, round a scan, to the next place, back from a candidate (requirements A5, A6)."""

from contracts.mission import EventKind, MissionKind, MissionState
from coordinator.core import actions as do
from coordinator.core.activities import Undocking, Waking
from coordinator.core.geometry import near_any
from coordinator.core.headings import headings_round
from coordinator.core.rules import CoverageRule
from coordinator.core.sightings import lose
from coordinator.core.step_context import StepContext
from geometry.poses import apart_m

MOVED_AWAY_M = 1.0
OFF_THE_DOCK = frozenset({
    MissionState.MEMORY_NAV, MissionState.SCANNING, MissionState.MOVING_TO_SCAN, MissionState.MOVING,
    MissionState.EXPLORING,
})  # fmt: skip


def undock_first(context: StepContext) -> bool:
    """True when a mission begins on the dock, which is left first: the state is taken up again afterwards.

    Once a mission: what the base says of its dock lags behind.
    """
    mission = context.mission
    if mission.state not in OFF_THE_DOCK or mission.kind is MissionKind.DOCK:
        return False
    if mission.robot.docked is not True or context.search.undocks > 0:
        return False
    call, limit_s = context.call(), context.rules.undock_timeout_s
    context.request(do.Undock(call, limit_s))
    context.set_activity(Undocking(call, context.now_s + limit_s + context.rules.call_margin_s))
    context.log_event(EventKind.UNDOCK, "leaving the dock first")
    return True


def undocked(context: StepContext) -> None:
    context.update_search(undocks=context.search.undocks + 1)
    context.log_event(EventKind.UNDOCK, "off the dock; waiting for the camera to start")
    context.set_activity(Waking(context.now_s + context.rules.wake_s_max))


def new_scan(context: StepContext, reason: str, *, start_rad: float | None = None) -> None:
    """A 420 degree look round in equal steps that overlap in the picture, from the heading that promises most.

    By belief there is none: how much of a turn is worth it is chosen with the place.
    """
    rules = context.rules
    if start_rad is None and _begins_outside(context):
        context.transition_to(MissionState.MOVING_TO_SCAN, f"not in {context.mission.area_called}: going there first")
        return
    if rules.coverage_rule is CoverageRule.BELIEF and context.mission.target is not None:
        context.update_search(headings=(), sweeps=0, scan_from=None)
        context.transition_to(MissionState.SCANNING, reason)
        return
    start = context.mission.robot.yaw if start_rad is None else start_rad
    headings = headings_round(rules, start, rules.scan_angle_rad)
    context.update_search(headings=headings, sweeps=0, scan_from=context.mission.robot.pose)
    context.transition_to(MissionState.SCANNING, reason)


def _begins_outside(context: StepContext) -> bool:
    """It is to look in rooms that it is not in, and has been nowhere yet."""
    mission, here = context.mission, context.mission.robot.pose
    if mission.area is None or here is None or mission.state not in {MissionState.IDLE, MissionState.MEMORY_NAV}:
        return False
    return not mission.search.visited and not mission.area.is_near(here)


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


def back_to_search(context: StepContext, reason: str) -> None:
    """SCANNING goes on where it was, or starts afresh where the robot has moved meanwhile."""
    here, started = context.mission.robot.pose, context.search.scan_from
    moved = here is not None and started is not None and apart_m(here, started) > MOVED_AWAY_M
    if moved:
        new_scan(context, f"{reason}; looking around from here")
    elif started is None:
        new_scan(context, f"{reason}; looking around")
    else:
        context.transition_to(MissionState.SCANNING, f"{reason}; looking around again")


def set_aside(context: StepContext, why: str) -> None:
    """The candidate stays one that may be it, with the reason; the search goes on elsewhere."""
    lose(context, f"could not be driven up to ({why})")
    back_to_search(context, f"it could not be driven up to: {why}")
