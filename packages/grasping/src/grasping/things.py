"""A thing to be grasped, as it was measured, and how things of its kind are taken hold of; pure."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from contracts.manipulation import GraspKind

Vector = NDArray[np.float64]

SIDE_LABELS: Final = frozenset({"bottle", "cup", "wine glass", "vase"})
"""Things that stand and hold something: they stay upright in the jaw."""
TOP_HEIGHT_M_MAX: Final = 0.08
"""What is lower is taken from above."""


@dataclass(frozen=True, slots=True)
class MeasuredThing:
    """In base_link, m and rad: the middle of the upright box round it, the box's length, width and height, and where
    its length points. What is round has the same length and width, and no direction."""

    x_m: float
    y_m: float
    z_m: float
    length_m: float
    width_m: float
    height_m: float
    yaw_rad: float = 0.0
    round: bool = True

    def __post_init__(self) -> None:
        """Raises ValueError for what is no thing."""
        numbers = (self.x_m, self.y_m, self.z_m, self.yaw_rad)
        sizes = (self.length_m, self.width_m, self.height_m)
        if not all(map(np.isfinite, (*numbers, *sizes))) or min(sizes) <= 0.0:
            raise ValueError(f"a thing has a finite place and a size above 0, not {numbers} and {sizes}")

    @property
    def centre(self) -> Vector:
        return np.array((self.x_m, self.y_m, self.z_m))

    @property
    def top_m(self) -> float:
        return self.z_m + self.height_m / 2

    @property
    def bottom_m(self) -> float:
        return self.z_m - self.height_m / 2

    @property
    def radius_m(self) -> float:
        """Of the circle round its footprint."""
        if self.round:
            return max(self.length_m, self.width_m) / 2
        return float(np.hypot(self.length_m, self.width_m)) / 2

    def across_m(self, direction_rad: float) -> float:
        """How wide it is between two jaws that close along a direction in the plane."""
        if self.round:
            return max(self.length_m, self.width_m)
        turn = direction_rad - self.yaw_rad
        return float(abs(np.cos(turn)) * self.length_m + abs(np.sin(turn)) * self.width_m)


def grasp_kind_of(label: str, height_m: float) -> GraspKind:
    """From the side what stands and holds something, and what is high; from above what is low."""
    if label in SIDE_LABELS or height_m > TOP_HEIGHT_M_MAX:
        return GraspKind.SIDE
    return GraspKind.TOP
