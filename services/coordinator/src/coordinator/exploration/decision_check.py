"""Every decision is held against the newest scan before anything moves (requirement C7).

What is accepted here still goes through robot_bridge's arbiter and safety filter like all else: this check refuses what
is not sensible, the filter keeps from touching.
"""

import math
from dataclasses import dataclass, replace
from typing import Final, assert_never

from contracts.exploration import (
    STEP_M_MAX,
    CheckPathClear,
    DecisionVerdict,
    ExplorationDecision,
    MoveToward,
    NavigateToGoal,
    ObserveScene,
    ReportDiscovery,
    RotateBy,
    StopRobot,
)
from contracts.geometry import Pose2D
from coordinator.exploration.frontiers import Chart, Frontier
from coordinator.exploration.surroundings import Surroundings
from geometry.poses import apart_m, compose, inverse, wrap

TRIES_KEPT: Final = 20
WAY_HALF_RAD: Final = 0.35
"""What a path as wide as the footprint takes up at the least clear distance, to each side."""
FRONTIER_MOVED_M: Final = 1.0
"""A frontier that was told is still one where the newest map has one this near."""


@dataclass(frozen=True, slots=True)
class CheckLimits:
    """Distances are from the footprint along the way, m."""

    footprint_radius_m: float = 0.19
    side_margin_m: float = 0.05
    """Kept free on each side of the path of the footprint."""
    reject_m: float = 0.5
    """Less clear than this is refused."""
    slow_m: float = 1.0
    """What ends with less clear ahead than this is driven slowly."""
    keep_m: float = 0.25
    """No step ends nearer to something than this."""
    scan_age_s_max: float = 0.5
    tries_max: int = 2
    tries_within_s: float = 15.0
    same_way_rad: float = math.radians(20.0)
    speed_m_s: float = 0.25
    slow_speed_m_s: float = 0.12

    @property
    def half_width_m(self) -> float:
        return self.footprint_radius_m + self.side_margin_m


@dataclass(frozen=True, slots=True)
class BlockedTry:
    """A direction of the map that was blocked when it was tried."""

    heading_rad: float
    stamp_s: float


@dataclass(frozen=True, slots=True)
class Knowledge:
    """What a decision is judged by: the newest of everything."""

    surroundings: Surroundings | None
    pose: Pose2D | None
    """base_link in map."""
    chart: Chart | None
    told: tuple[Frontier, ...] = ()
    """The frontiers whose numbers whoever decides was told."""
    tries: tuple[BlockedTry, ...] = ()
    now_s: float = 0.0


@dataclass(frozen=True, slots=True)
class TurnBy:
    angle_rad: float


@dataclass(frozen=True, slots=True)
class Advance:
    """Turn to a bearing, then straight ahead; checked anew when it has turned."""

    bearing_rad: float
    distance_m: float
    speed_m_s: float


@dataclass(frozen=True, slots=True)
class GoTo:
    """A goal for Nav2, in the map."""

    pose: Pose2D


Motion = TurnBy | Advance | GoTo


@dataclass(frozen=True, slots=True)
class Checked:
    """`motion` is none where nothing may move, and for the tools that move nothing. `clear_m`: how far the way asked
    for is clear, where it was measured."""

    verdict: DecisionVerdict
    motion: Motion | None = None
    clear_m: float | None = None
    tries: tuple[BlockedTry, ...] = ()


def check(decision: ExplorationDecision, known: Knowledge, limits: CheckLimits) -> Checked:
    """What may be done of it. Never raises; never a motion that `limits` forbid."""
    checked = _checked(decision, known, limits)
    return replace(checked, tries=checked.tries or known.tries)


def _checked(decision: ExplorationDecision, known: Knowledge, limits: CheckLimits) -> Checked:
    match decision:
        case StopRobot() | ObserveScene() | ReportDiscovery():
            return Checked(DecisionVerdict.ACCEPTED)
        case CheckPathClear(bearing_rad=bearing_rad, distance_m=distance_m):
            return _look(bearing_rad, distance_m, known, limits)
        case MoveToward(bearing_rad=bearing_rad, distance_m=distance_m):
            return _advance(bearing_rad, distance_m, known, limits)
        case RotateBy(angle_rad=angle_rad):
            scan = _fresh(known, limits)
            if isinstance(scan, DecisionVerdict):
                return Checked(scan)
            return Checked(DecisionVerdict.ACCEPTED, TurnBy(angle_rad))
        case NavigateToGoal():
            return _go_to(decision, known, limits)
        case _:
            assert_never(decision)


def _fresh(known: Knowledge, limits: CheckLimits) -> Surroundings | DecisionVerdict:
    """The scan, where it is new enough to move on; one from the future is none."""
    scan = known.surroundings
    if scan is None or not 0.0 <= known.now_s - scan.stamp_s <= limits.scan_age_s_max:
        return DecisionVerdict.NO_SCAN
    return scan


def _look(bearing_rad: float, distance_m: float, known: Knowledge, limits: CheckLimits) -> Checked:
    scan = _fresh(known, limits)
    if isinstance(scan, DecisionVerdict):
        return Checked(scan)
    if scan.says_nothing_about(bearing_rad, WAY_HALF_RAD):
        return Checked(DecisionVerdict.BLIND)
    clear_m = scan.clear_m(bearing_rad, limits.half_width_m)
    clear = clear_m >= max(limits.reject_m, distance_m + limits.keep_m)
    return Checked(DecisionVerdict.ACCEPTED if clear else DecisionVerdict.BLOCKED, None, clear_m)


def _advance(bearing_rad: float, distance_m: float, known: Knowledge, limits: CheckLimits) -> Checked:
    scan = _fresh(known, limits)
    if isinstance(scan, DecisionVerdict):
        return Checked(scan)
    if known.pose is None:
        return Checked(DecisionVerdict.NO_POSE)
    heading_rad = wrap(known.pose.yaw + bearing_rad)
    if tried_too_often(known.tries, heading_rad, known.now_s, limits):
        return Checked(DecisionVerdict.TRIED_TOO_OFTEN)
    if scan.says_nothing_about(bearing_rad, WAY_HALF_RAD):
        return Checked(DecisionVerdict.BLIND)
    clear_m = scan.clear_m(bearing_rad, limits.half_width_m)
    if clear_m < limits.reject_m:
        return Checked(DecisionVerdict.BLOCKED, None, clear_m, blocked(known.tries, heading_rad, known.now_s))
    allowed_m = min(distance_m, STEP_M_MAX, clear_m - limits.keep_m)
    speed_m_s = speed_for(clear_m, allowed_m, limits)
    slow = speed_m_s < limits.speed_m_s
    verdict = DecisionVerdict.SLOWED if slow else DecisionVerdict.ACCEPTED
    shortened = DecisionVerdict.SHORTENED if allowed_m < distance_m else verdict
    return Checked(shortened, Advance(bearing_rad, allowed_m, speed_m_s), clear_m)


def _go_to(decision: NavigateToGoal, known: Knowledge, limits: CheckLimits) -> Checked:
    scan = _fresh(known, limits)
    if isinstance(scan, DecisionVerdict):
        return Checked(scan)
    if known.pose is None or known.chart is None:
        return Checked(DecisionVerdict.NO_POSE)
    goal = _goal_of(decision, known.told, known.chart, known.pose)
    if goal is None:
        return Checked(DecisionVerdict.NO_SUCH_FRONTIER)
    if not known.chart.has_room_at(goal.x, goal.y):
        return Checked(DecisionVerdict.GOAL_NOT_FREE)
    in_base = compose(inverse(known.pose), goal)
    near_m = scan.nearest_m(in_base.x, in_base.y)
    if near_m < limits.footprint_radius_m:  # something stands there that the map does not hold
        return Checked(DecisionVerdict.GOAL_NOT_FREE)
    refused = None if decision.frontier is not None else _made_up(in_base, near_m, known.pose, scan, known, limits)
    return Checked(refused) if refused is not None else Checked(DecisionVerdict.ACCEPTED, GoTo(goal))


def _made_up(
    in_base: Pose2D, near_m: float, pose: Pose2D, scan: Surroundings, known: Knowledge, limits: CheckLimits
) -> DecisionVerdict | None:
    """Why a place that no map proposed is refused: it is held to the rules of a drive straight there, so that none of
    them is got round by naming the place. None where it is not.
    """
    bearing_rad = math.atan2(in_base.y, in_base.x)
    if tried_too_often(known.tries, wrap(pose.yaw + bearing_rad), known.now_s, limits):
        return DecisionVerdict.TRIED_TOO_OFTEN
    if scan.says_nothing_about(bearing_rad, WAY_HALF_RAD):
        return DecisionVerdict.BLIND
    return DecisionVerdict.GOAL_NOT_FREE if near_m < limits.half_width_m + limits.reject_m else None


def _goal_of(decision: NavigateToGoal, told: tuple[Frontier, ...], chart: Chart, pose: Pose2D) -> Pose2D | None:
    """None for a frontier that was not told, or is none on the newest map any more."""
    if decision.x_m is not None and decision.y_m is not None:
        yaw = math.atan2(decision.y_m - pose.y, decision.x_m - pose.x)
        return Pose2D(x=decision.x_m, y=decision.y_m, yaw=yaw)
    wanted = next((one.pose for one in told if one.number == decision.frontier), None)
    if wanted is None:
        return None
    now = min(chart.frontiers, key=lambda one: apart_m(one.pose, wanted), default=None)
    return now.pose if now is not None and apart_m(now.pose, wanted) <= FRONTIER_MOVED_M else None


def speed_for(clear_m: float, distance_m: float, limits: CheckLimits) -> float:
    """Of a drive that far on a way that is clear so far, m/s: slow where it ends near to something."""
    return limits.slow_speed_m_s if clear_m - distance_m < limits.slow_m else limits.speed_m_s


def tried_too_often(tries: tuple[BlockedTry, ...], heading_rad: float, now_s: float, limits: CheckLimits) -> bool:
    """This direction was blocked as often as it may be tried, within the time that counts."""
    lately = (
        one
        for one in tries
        if now_s - one.stamp_s <= limits.tries_within_s
        and abs(wrap(one.heading_rad - heading_rad)) <= limits.same_way_rad
    )
    return sum(1 for _ in lately) >= limits.tries_max


def blocked(tries: tuple[BlockedTry, ...], heading_rad: float, now_s: float) -> tuple[BlockedTry, ...]:
    """One try more; the oldest are forgotten."""
    return (*tries, BlockedTry(heading_rad, now_s))[-TRIES_KEPT:]


def end_of(pose: Pose2D, motion: Advance) -> Pose2D:
    """Where it ends, in the map."""
    turned = compose(pose, Pose2D(x=0.0, y=0.0, yaw=wrap(motion.bearing_rad)))
    return compose(turned, Pose2D(x=motion.distance_m, y=0.0, yaw=0.0))
