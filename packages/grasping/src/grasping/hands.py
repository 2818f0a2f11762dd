"""What has to be known of a hand to place it round a thing, as data: m and rad, in the frame between its pads; pure."""

from dataclasses import dataclass
from typing import Final

import numpy as np


@dataclass(frozen=True, slots=True)
class Hand:
    """One jaw stands still, the other turns. The tip's frame has x out of the hand, z from the still jaw to the other,
    its origin between the still jaw's pad and the fingertip."""

    tip: str
    """The site of the model that is the tip's frame."""
    face_m: float
    """Of the still pad, along z."""
    beyond_tip_m: float
    """So far the fingertip reaches past the origin, along x."""
    angles_rad: tuple[float, ...]
    gaps_m: tuple[float, ...]
    """Between the pads, at these angles of the jaw; rising."""
    grip_m_max: float
    """The widest thing that it holds: wider ones the turning jaw pushes out."""
    pads: tuple[str, str]
    """Geoms of the model: of the still jaw, and of the other."""
    pan_from_foot_m: float
    """The first joint turns about a vertical axis so far ahead of the arm's foot."""

    @property
    def widest_m(self) -> float:
        return self.gaps_m[-1]

    def angle_for(self, gap_m: float) -> float:
        """Of the jaw, for a gap; the nearest it has."""
        return float(np.interp(gap_m, self.gaps_m, self.angles_rad))

    def gap_at(self, angle_rad: float) -> float:
        return float(np.interp(angle_rad, self.angles_rad, self.gaps_m))


SO101_HAND: Final = Hand(
    tip="gripperframe",
    face_m=0.0065,
    beyond_tip_m=0.006,
    angles_rad=(0.0, 0.23, 0.43, 0.63, 0.83, 1.03, 1.23, 1.43, 1.63),
    gaps_m=(0.005, 0.0225, 0.0377, 0.0521, 0.065, 0.0761, 0.0848, 0.0925, 0.0965),
    grip_m_max=0.078,
    pads=("fixed_jaw_pad", "moving_jaw_pad"),
    pan_from_foot_m=0.0388,
)
"""Read off the model's pads. What is wider than `grip_m_max` the jaw holds at more than 30 degrees."""
