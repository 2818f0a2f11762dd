"""Which grasps of a thing the arm can make, the best first, or why none; pure: the arm is asked through a Protocol."""

import itertools
import math
from dataclasses import dataclass
from typing import Final, Protocol

from contracts.manipulation import FetchCause, GraspKind
from grasping.candidates import GraspCandidate, TipPose, candidates_for, fits_any
from grasping.hands import Hand
from grasping.reachability import ReachabilityMap
from grasping.things import MeasuredThing

Joints = tuple[float, ...]
WANTED: Final = 3
"""Grasps in a plan, at most."""
_PREFERENCE, _MARGIN, _ROOM = 1.0, 0.6, 0.4
"""What the pitch, the joints' margin and the jaw's are worth beside one another."""
_TILTS_RAD: Final = (0.0, -0.26, 0.26)
"""Raised, the hand may point so much more or less steeply than when it took hold."""


class ArmSolver(Protocol):
    """Knows the arm's kinematics, and what stands round it."""

    def solve(self, pose: TipPose, start: Joints) -> Joints | None:
        """The arm's joints with the tip there, found from `start`; None if it does not come there."""
        ...

    def touches(self, joints: Joints, jaw_rad: float, thing: MeasuredThing | None) -> tuple[str, ...]:
        """What the arm would touch in that posture: the floor, the robot, itself, the thing."""
        ...

    def margin(self, joints: Joints) -> float:
        """Of the joint nearest to the end of its range, as a share of half of it."""
        ...


@dataclass(frozen=True, slots=True)
class PlannedGrasp:
    """Joints by which it is made: `way_in` from beside the thing to round it, `way_up` from there to raised."""

    candidate: GraspCandidate
    jaw_rad: float
    way_in: tuple[Joints, ...]
    way_up: tuple[Joints, ...]
    score: float


@dataclass(frozen=True, slots=True)
class GraspPlan:
    grasps: tuple[PlannedGrasp, ...]
    cause: FetchCause | None = None
    """Why there is none: what came nearest to one was refused for it."""


def plan_grasps(
    thing: MeasuredThing, kind: GraspKind, hand: Hand, foot_x_m: float, reach: ReachabilityMap, arm: ArmSolver
) -> GraspPlan:
    """Candidates in the order of their preference, until enough can be made."""
    if not fits_any(thing, hand):
        return GraspPlan((), FetchCause.TOO_WIDE)
    found: list[PlannedGrasp] = []
    no_room = False
    for candidate in candidates_for(thing, kind, hand, foot_x_m):
        outcome = _make(candidate, thing, hand, foot_x_m, reach, arm)
        if isinstance(outcome, PlannedGrasp):
            found.append(outcome)
        no_room = no_room or outcome is FetchCause.NO_ROOM
        if len(found) == WANTED:
            break
    if found:
        return GraspPlan(tuple(sorted(found, key=lambda one: -one.score)))
    return GraspPlan((), FetchCause.NO_ROOM if no_room else FetchCause.OUT_OF_REACH)


def way_between(
    arm: ArmSolver, begin: Joints, end: Joints, jaw_rad: float, thing: MeasuredThing | None, by: tuple[Joints, ...]
) -> tuple[Joints, ...] | None:
    """From one posture to another, straight in joint space or by one of the postures `by`, touching nothing; None where
    there is no such way."""
    for middle in (None, *by):
        way = (begin, end) if middle is None else (begin, middle, end)
        if all(
            not arm.touches(each, jaw_rad, thing)
            for one, other in itertools.pairwise(way)
            for each in _between(one, other)
        ):
            return way
    return None


def _between(one: Joints, other: Joints) -> list[Joints]:
    """Postures no more than 0.1 rad apart, the last included."""
    count = max(1, math.ceil(max(abs(a - b) for a, b in zip(one, other, strict=True)) / 0.1))
    return [tuple(a + (b - a) * k / count for a, b in zip(one, other, strict=True)) for k in range(1, count + 1)]


def _make(
    candidate: GraspCandidate, thing: MeasuredThing, hand: Hand, foot_x_m: float, reach: ReachabilityMap, arm: ArmSolver
) -> PlannedGrasp | FetchCause:
    start = _start(candidate.before, hand, foot_x_m, reach)
    if start is None:
        return FetchCause.OUT_OF_REACH
    jaw_rad = hand.angle_for(candidate.gap_m)
    way_in = _line(arm, candidate.before, candidate.tip, start, pieces=5)
    if way_in is None:
        return FetchCause.OUT_OF_REACH
    way_up = None
    for tilt_rad in _TILTS_RAD:
        way_up = way_up or _line(arm, candidate.tip, candidate.raised.tilted(tilt_rad), way_in[-1], pieces=3)
    if way_up is None:
        return FetchCause.OUT_OF_REACH
    if arm.touches(way_in[-1], jaw_rad, thing):
        way_in = way_in[:-1]  # the hand is a little too wide for that depth: hold it less deep
        way_up = (way_in[-1], *way_up[1:])
    if any(arm.touches(each, jaw_rad, thing) for each in way_in) or any(
        arm.touches(each, jaw_rad, None) for each in way_up
    ):
        return FetchCause.NO_ROOM
    margin = min(map(arm.margin, (*way_in, *way_up)))
    room = (candidate.gap_m - candidate.width_m) / hand.widest_m
    score = _PREFERENCE * candidate.preference + _MARGIN * margin + _ROOM * room
    return PlannedGrasp(candidate, jaw_rad, way_in, way_up[1:], score)


def _line(arm: ArmSolver, begin: TipPose, end: TipPose, start: Joints, *, pieces: int) -> tuple[Joints, ...] | None:
    """Postures along the straight way of the tip, both ends included; None where the arm leaves it."""
    found: list[Joints] = []
    for k in range(pieces + 1):
        joints = arm.solve(begin.towards(end, k / pieces), found[-1] if found else start)
        if joints is None:
            return None
        found.append(joints)
    return tuple(found)


def _start(pose: TipPose, hand: Hand, foot_x_m: float, reach: ReachabilityMap) -> Joints | None:
    """A posture near by of the arm's table; None where the table has none."""
    x, y = float(pose.at[0]) - foot_x_m - hand.pan_from_foot_m, float(pose.at[1])
    posture = reach.posture_at(math.hypot(x, y), float(pose.at[2]), pose.pitch_rad)
    if posture is None:
        return None
    bearing = math.atan2(y, x)
    lateral = (math.sin(bearing), -math.cos(bearing), 0.0)
    cosine = sum(float(a) * b for a, b in zip(pose.opens, lateral, strict=True))
    # the hand opens upwards with the last joint at 0, and to the left a quarter further
    return (-bearing, *posture, math.copysign(math.pi / 2, -cosine))
