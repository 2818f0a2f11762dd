"""What an arm reaches, and where the robot may stand for it: a table made once per arm; pure."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from geometry.poses import wrap
from grasping.candidates import BACK_M, LIFT_M
from grasping.things import MeasuredThing

CELL_M: Final = 0.02
CELL_RAD: Final = math.radians(15.0)
_OUT_M: Final = 0.62
_LOW_M, _HIGH_M = 0.0, 0.84
_STEEPEST_RAD: Final = math.radians(97.5)
SHAPE: Final = (
    round(_OUT_M / CELL_M), round((_HIGH_M - _LOW_M) / CELL_M), round(2 * _STEEPEST_RAD / CELL_RAD)
)  # fmt: skip
"""Cells: how far the tip is from the first joint's axis, how high above the floor, how steeply it points down."""

Floats = NDArray[np.float32]


@dataclass(frozen=True)
class ReachabilityMap:
    """`margin` (SHAPE): how far from the end of its range the joint is that is nearest to one, as a share of half the
    range, of the best posture with the tip in that cell; -1 = there is none. `postures` (SHAPE, 3): the joints between
    the first and the last of it, rad: a good place for inverse kinematics to begin."""

    margin: Floats
    postures: Floats

    def __post_init__(self) -> None:
        """Raises ValueError for tables of another shape."""
        if self.margin.shape != SHAPE or self.postures.shape != (*SHAPE, 3):
            raise ValueError(f"tables of {self.margin.shape} and {self.postures.shape} cells, not {SHAPE}")

    def margin_at(self, out_m: float, height_m: float, pitch_rad: float) -> float:
        """-1 where the arm does not come."""
        cell = cell_of(out_m, height_m, pitch_rad)
        return float(self.margin[cell]) if cell is not None else -1.0

    def posture_at(self, out_m: float, height_m: float, pitch_rad: float) -> tuple[float, ...] | None:
        """Of the cell, or of the nearest one beside it that has one."""
        cell = cell_of(out_m, height_m, pitch_rad)
        if cell is None:
            return None
        low = [max(0, index - 1) for index in cell]
        near = self.margin[low[0] : cell[0] + 2, low[1] : cell[1] + 2, low[2] : cell[2] + 2]
        if self.margin[cell] >= 0.0:
            return tuple(self.postures[cell].tolist())
        if near.max() < 0.0:
            return None
        best = np.unravel_index(int(near.argmax()), near.shape)
        found = tuple(int(a) + b for a, b in zip(best, low, strict=True))
        return tuple(self.postures[found].tolist())


def cell_of(out_m: float, height_m: float, pitch_rad: float) -> tuple[int, int, int] | None:
    """None where it is outside of the table."""
    cell = (
        math.floor(out_m / CELL_M), math.floor((height_m - _LOW_M) / CELL_M),
        math.floor((pitch_rad + _STEEPEST_RAD) / CELL_RAD),
    )  # fmt: skip
    return cell if all(0 <= index < size for index, size in zip(cell, SHAPE, strict=True)) else None


def table_of(
    out_m: NDArray[np.float64], height_m: NDArray[np.float64], pitch_rad: NDArray[np.float64],
    margin: NDArray[np.float64], postures: NDArray[np.float64],
) -> ReachabilityMap:  # fmt: skip
    """Of many postures (N) and (N, 3), those that touch nothing: in each cell the one with the greatest margin."""
    margins = np.full(SHAPE, -1.0, np.float32)
    best = np.zeros((*SHAPE, 3), np.float32)
    for index in np.argsort(margin).tolist():  # the greatest last
        cell = cell_of(float(out_m[index]), float(height_m[index]), float(pitch_rad[index]))
        if cell is not None:
            margins[cell], best[cell] = margin[index], postures[index]
    return ReachabilityMap(margins, best)


@dataclass(frozen=True, slots=True)
class Stance:
    """Where the robot may stand for a thing: base_link in the frame that the thing is told in, and how good it is."""

    pose: Pose2D
    score: float


BASE_CLEAR_M: Final = 0.03
"""Between the robot's base and the thing."""


def distance_scores(
    reach: ReachabilityMap, height_m: float, pitches_rad: tuple[float, ...], pan_x_m: float, nearest_m: float
) -> list[tuple[float, float]]:
    """(distance, score) of standing with the thing's grasp straight ahead so far from base_link, the best first.

    A distance counts by the worst of the way in, the grasp and the way up, at the pitch that is best for all of it, and
    by the worst of itself and its neighbours: the robot does not stop to the centimetre.
    """
    outs = np.arange(CELL_M / 2, _OUT_M, CELL_M)
    best = np.array([max(_whole_way(reach, out, height_m, pitch) for pitch in pitches_rad) for out in outs.tolist()])
    padded = np.concatenate(([-1.0], best, [-1.0]))
    sure = np.minimum(np.minimum(padded[:-2], padded[2:]), best)
    found = [
        (out + pan_x_m, score)
        for out, score in zip(outs.tolist(), sure.tolist(), strict=True)
        if score >= 0.0 and out + pan_x_m >= nearest_m
    ]
    return sorted(found, key=lambda each: -each[1])


def _whole_way(reach: ReachabilityMap, out_m: float, height_m: float, pitch_rad: float) -> float:
    """The least margin of a grasp's stations."""
    back_m, up_m = BACK_M * math.cos(pitch_rad), BACK_M * math.sin(pitch_rad)
    return min(
        reach.margin_at(out_m - back_m, height_m + up_m, pitch_rad),
        reach.margin_at(out_m, height_m, pitch_rad),
        reach.margin_at(out_m, height_m + LIFT_M, pitch_rad),
    )


def stances_for(
    thing: MeasuredThing, distances: list[tuple[float, float]], here: Pose2D, *, bearings: int = 12
) -> list[Stance]:
    """All round the thing, facing it, the best first; a turn round it costs a little. `thing` and `here` are in one
    frame. Whoever drives there knows which of them are free."""
    from_thing = math.atan2(here.y - thing.y_m, here.x - thing.x_m)
    found: list[Stance] = []
    for distance_m, score in distances:
        for k in range(bearings):
            angle = from_thing + 2 * math.pi * k / bearings
            x, y = thing.x_m + distance_m * math.cos(angle), thing.y_m + distance_m * math.sin(angle)
            round_share = abs(wrap(angle - from_thing)) / math.pi
            pose = Pose2D(x=x, y=y, yaw=wrap(angle + math.pi))
            found.append(Stance(pose, score - 0.3 * round_share))
    return sorted(found, key=lambda one: -one.score)
