"""Where the jaw may stand round a thing, by geometry alone; pure."""

import itertools
import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from contracts.manipulation import GraspKind
from grasping.hands import Hand
from grasping.things import MeasuredThing, Vector

BESIDE_M: Final = 0.008
"""Between the still jaw and the thing before the jaw closes: so far it is pushed, or measured wrong."""
DEPTH_M: Final = 0.015
"""The fingertips go so far past the thing's middle: less, and a jaw that turns squeezes it out."""
BACK_M: Final = 0.075
"""From where the jaw goes straight in."""
LIFT_M: Final = 0.16
OPEN_MORE_M: Final = 0.022
"""The jaw opens so much wider than the thing, if it can."""
OPEN_MORE_M_MIN: Final = 0.008
SQUARE_RAD: Final = math.radians(15.0)
"""The jaws may close so far off a right angle to the sides of what is not round."""
FLOOR_M: Final = 0.008
"""Between fingertips and whatever the thing stands on."""
TOP_GRIP_M: Final = 0.035
"""From above the fingertips reach so far below the thing's top, or to its middle if that is lower."""
SIDE_GRIPS: Final = (0.55, 0.7, 0.8, 0.88)
"""Shares of a standing thing's height at which it is taken from the side, the preferred first: a hand that points down
steeply has room for no more of it than stands above its fingers."""

PITCHES_DEG: Final[dict[GraspKind, tuple[float, ...]]] = {
    GraspKind.SIDE: (0.0, 15.0, 30.0, 45.0, 60.0, 75.0),
    GraspKind.TOP: (90.0, 75.0, 60.0, 45.0),
}
"""How steeply the hand may point down, the preferred first."""


@dataclass(frozen=True, slots=True)
class TipPose:
    """Of the hand's tip in base_link: its origin (m), x (`approach`) and z (`opens`), unit vectors at right angles."""

    at: Vector
    approach: Vector
    opens: Vector

    @property
    def rotation(self) -> Vector:
        """Its axes as columns."""
        return np.column_stack((self.approach, np.cross(self.opens, self.approach), self.opens))

    def moved(self, by: Vector) -> "TipPose":
        return TipPose(self.at + by, self.approach, self.opens)

    def tilted(self, angle_rad: float) -> "TipPose":
        """Pointing down so much more steeply, turned about the level line across it."""
        level = np.array((-self.approach[1], self.approach[0], 0.0))
        axis = level / max(1e-9, float(np.linalg.norm(level)))
        return TipPose(self.at, _turned(self.approach, axis, angle_rad), _turned(self.opens, axis, angle_rad))

    def towards(self, other: "TipPose", share: float) -> "TipPose":
        """On the straight way to another; its axes turn along with it."""
        approach = (1.0 - share) * self.approach + share * other.approach
        approach = approach / np.linalg.norm(approach)
        opens = (1.0 - share) * self.opens + share * other.opens
        opens = opens - (opens @ approach) * approach
        return TipPose(self.at + share * (other.at - self.at), approach, opens / np.linalg.norm(opens))

    @property
    def pitch_rad(self) -> float:
        """Downwards."""
        return math.asin(max(-1.0, min(1.0, -float(self.approach[2]))))


@dataclass(frozen=True, slots=True)
class GraspCandidate:
    kind: GraspKind
    tip: TipPose
    """With the jaw round the thing, before it closes."""
    width_m: float
    """Of the thing between the jaws."""
    gap_m: float
    """Between the open jaws."""
    preference: float
    """1 for the pitch and the height that such things are best taken at, falling to 0."""

    @property
    def before(self) -> TipPose:
        return self.tip.moved(-BACK_M * self.tip.approach)

    @property
    def raised(self) -> TipPose:
        return self.tip.moved(np.array((0.0, 0.0, LIFT_M)))


def _turned(vector: Vector, axis: Vector, angle_rad: float) -> Vector:
    """Rodrigues' rotation about a unit vector."""
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return cos * vector + sin * np.cross(axis, vector) + (1.0 - cos) * float(axis @ vector) * axis


def candidates_for(thing: MeasuredThing, kind: GraspKind, hand: Hand, foot_x_m: float) -> list[GraspCandidate]:
    """The preferred first; none where the jaw does not hold it. `foot_x_m`: of the arm, in base_link."""
    pitches, grips = PITCHES_DEG[kind], SIDE_GRIPS if kind is GraspKind.SIDE else SIDE_GRIPS[:1]
    pan = np.array((foot_x_m + hand.pan_from_foot_m, 0.0))
    found: list[GraspCandidate] = []
    for (i, degrees), (k, grip) in itertools.product(enumerate(pitches), enumerate(grips)):
        pitch = math.radians(degrees)
        z_m = _height(thing, kind, hand, pitch, grip)
        preference = 1.0 - 0.6 * i / len(pitches) - 0.4 * k / len(grips)
        for turn in (0.0, math.pi, math.pi / 2, -math.pi / 2) if degrees > 85.0 else (0.0, math.pi):
            one = _placed(thing, kind, hand, pan, pitch, turn, z_m, preference)
            if one is not None:
                found.append(one)
    return sorted(found, key=lambda one: -one.preference)


def fits_any(thing: MeasuredThing, hand: Hand) -> bool:
    """Whether the jaw holds it one way or the other."""
    return min(thing.across_m(thing.yaw_rad), thing.across_m(thing.yaw_rad + math.pi / 2)) <= hand.grip_m_max


def _placed(
    thing: MeasuredThing, kind: GraspKind, hand: Hand, pan: Vector, pitch: float, turn: float, z_m: float,
    preference: float,
) -> GraspCandidate | None:  # fmt: skip
    """The hand in the arm's plane, which turns about `pan`: its place and that plane depend on one another."""
    bearing = math.atan2(thing.y_m - pan[1], thing.x_m - pan[0])
    tip, width_m = None, 0.0
    for _ in range(8):
        sin, cos = math.sin(bearing), math.cos(bearing)
        approach = np.array((math.cos(pitch) * cos, math.cos(pitch) * sin, -math.sin(pitch)))
        lateral = np.array((sin, -cos, 0.0))
        # straight down the last joint is free: square to the thing's sides
        turned = turn + bearing - math.pi / 2 - thing.yaw_rad if pitch > 1.5 and not thing.round else turn
        opens = math.cos(turned) * lateral + math.sin(turned) * np.cross(approach, lateral)
        width_m = thing.across_m(math.atan2(opens[1], opens[0]))
        beside = width_m / 2 + BESIDE_M + hand.face_m
        level = np.array((approach[0], approach[1], 0.0))  # past the middle, at the height that was chosen
        at = np.array((thing.x_m, thing.y_m, z_m)) - beside * opens + DEPTH_M * level
        at[2] = z_m
        tip = TipPose(at, approach, opens)
        bearing = math.atan2(at[1] - pan[1], at[0] - pan[0])
    gap_m = min(width_m + BESIDE_M + OPEN_MORE_M, hand.widest_m)
    if tip is None or not _square(thing, tip.opens):
        return None
    if width_m > hand.grip_m_max or gap_m < width_m + BESIDE_M + OPEN_MORE_M_MIN:
        return None
    return GraspCandidate(kind, tip, width_m, gap_m, preference)


def _square(thing: MeasuredThing, opens: Vector) -> bool:
    """Whether the jaws close on its sides, not on its corners."""
    off = math.remainder(math.atan2(opens[1], opens[0]) - thing.yaw_rad, math.pi / 2)
    return thing.round or abs(off) <= SQUARE_RAD


def _height(thing: MeasuredThing, kind: GraspKind, hand: Hand, pitch: float, grip: float) -> float:
    """Of the tip, so that the fingers stay off what the thing stands on."""
    lowest_m = thing.bottom_m + FLOOR_M + hand.beyond_tip_m * math.sin(pitch) + 0.008 * math.cos(pitch)
    if kind is GraspKind.SIDE:
        return max(lowest_m, thing.bottom_m + grip * thing.height_m)
    return max(lowest_m, min(thing.z_m, thing.top_m - hand.beyond_tip_m), thing.top_m - TOP_GRIP_M)
