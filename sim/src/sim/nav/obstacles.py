"""What the laser sees that the map does not hold: the obstacle layers of the stand-in for Nav2."""

from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage  # pyright: ignore[reportMissingTypeStubs]

from contracts.geometry import Pose2D
from sim.nav.costmap import Costmap
from sim.world.types import Scan

MARK_RANGE_M: Final = 2.5
_MAP_TOLERANCE_M: Final = 0.15
_SEEN_THROUGH_M: Final = 0.15


def valid(scan: Scan) -> NDArray[np.bool_]:
    """(N,): this ray came back from something within the laser's range."""
    return np.isfinite(scan.ranges_m) & (scan.ranges_m >= scan.range_min_m) & (scan.ranges_m <= scan.range_max_m)


def hits_m(scan: Scan, laser: Pose2D, *, range_max_m: float) -> NDArray[np.float64]:
    """(M, 2) hits within `range_max_m`, in the frame that `laser` (the laser's pose) is given in."""
    near = valid(scan) & (scan.ranges_m <= range_max_m)
    bearings = laser.yaw + scan.angle_min + np.flatnonzero(near) * scan.angle_increment
    ranges = scan.ranges_m[near].astype(np.float64)
    return np.stack([laser.x + ranges * np.cos(bearings), laser.y + ranges * np.sin(bearings)], axis=-1)


class ObstacleLayer:
    """Cells the laser hit where the static map is free. They stay until seen through, or cleared."""

    def __init__(self, static: Costmap) -> None:
        self._static = static
        # Walls are seen a little off their place by a robot that is a little wrong about its own.
        reach = round(_MAP_TOLERANCE_M / static.grid.resolution_m)
        y, x = np.ogrid[-reach : reach + 1, -reach : reach + 1]
        self._known: NDArray[np.bool_] = cast(Any, ndimage).binary_dilation(
            static.occupied, x * x + y * y <= reach * reach
        )
        self.marked: NDArray[np.bool_] = np.zeros_like(static.occupied)
        """(rows, columns); replaced, never changed in place, so that another thread may hold on to it."""

    def clear(self) -> None:
        self.marked = np.zeros_like(self.marked)

    def observe(self, scan: Scan, laser: Pose2D) -> bool:
        """Marks hits and forgets what the laser now looks through; `laser` is its pose in the map.

        True when the layer changed.
        """
        marked = self.marked & ~self._seen_through(scan, laser)
        rows, columns = self._static.grid.cells(hits_m(scan, laser, range_max_m=MARK_RANGE_M))
        unknown = ~self._known[rows, columns]
        marked[rows[unknown], columns[unknown]] = True
        if np.array_equal(marked, self.marked):
            return False
        self.marked = marked
        return True

    def _seen_through(self, scan: Scan, laser: Pose2D) -> NDArray[np.bool_]:
        through = np.zeros_like(self.marked)
        cells = np.argwhere(self.marked)
        if not len(cells):
            return through
        offset = self._static.grid.centres(cells[:, 0], cells[:, 1]) - (laser.x, laser.y)
        distance, bearing = np.hypot(*offset.T), np.arctan2(offset[:, 1], offset[:, 0]) - laser.yaw
        turn = 2 * np.pi
        rays = np.rint(np.mod(bearing - scan.angle_min, turn) / scan.angle_increment).astype(np.intp)
        seen = rays < len(scan.ranges_m)
        rays = np.minimum(rays, len(scan.ranges_m) - 1)
        measured = np.where(valid(scan)[rays], scan.ranges_m[rays], 0.0)
        gone = seen & (distance <= MARK_RANGE_M) & (measured > distance + _SEEN_THROUGH_M)
        through[cells[gone, 0], cells[gone, 1]] = True
        return through
