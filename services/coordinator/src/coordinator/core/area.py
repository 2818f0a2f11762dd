"""The rooms that a search keeps to, as runs of cells: what lies in them. Pure."""

import math
from dataclasses import dataclass

from contracts.geometry import Pose2D
from contracts.mission import SearchedRoom
from vocabulary.rooms import called

BESIDE_M = 0.3
"""A place this little outside is taken to be inside: nothing is measured to the cell."""


@dataclass(frozen=True, slots=True)
class SearchArea:
    """Row 0 at the origin, as in a map. What stands in the rooms, and not on their floor, is in it too."""

    rooms: tuple[SearchedRoom, ...]
    origin: Pose2D
    resolution_m: float
    runs: tuple[tuple[int, int, int], ...]
    """Row, first column, and the column behind the last."""

    @property
    def called(self) -> str:
        """For a person: 'the kitchen', 'the bedroom and the bedroom 2'."""
        return " and ".join(called(one.name) for one in self.rooms)

    def holds(self, x_m: float, y_m: float, *, within_m: float = 0.0) -> bool:
        """Whether the point of the map frame is inside, or has a cell of it within `within_m`."""
        c, s = math.cos(self.origin.yaw), math.sin(self.origin.yaw)
        dx, dy = x_m - self.origin.x, y_m - self.origin.y
        column, row = (c * dx + s * dy) / self.resolution_m, (c * dy - s * dx) / self.resolution_m
        reach = within_m / self.resolution_m
        return any(
            math.hypot(max(at - row, row - at - 1.0, 0.0), max(first - column, column - behind, 0.0)) <= reach
            for at, first, behind in self.runs
        )

    def is_near(self, pose: Pose2D) -> bool:
        return self.holds(pose.x, pose.y, within_m=BESIDE_M)
