"""slam_toolbox's part, of its stand-in (`sim.nav.mapper`): a map that begins with what is seen first, and grows."""

from collections.abc import Callable
from typing import Final

from contracts.geometry import Pose2D
from geometry.poses import compose
from sim.nav.mapper import PASSES_MIN, Mapper
from sim.ros.realtime import Duty
from sim.world import OccupancyGrid, Scan, World
from sim.world.robot import LIDAR

MAP_HZ: Final = 0.5
"""slam_toolbox's map_update_interval is 5 s; demos set 2 s or less."""


class Mapping:
    """In the World's thread. `take` gets each map with its time in ns."""

    def __init__(self, take: Callable[[OccupancyGrid, int], None]) -> None:
        self._mapper = Mapper()
        self._take = take

    def begin(self, world: World, pose: Pose2D) -> OccupancyGrid:
        """What is seen from where the robot stands, before it is anywhere else."""
        laser = compose(pose, LIDAR)
        for _ in range(PASSES_MIN):
            self._mapper.observe(world.scan(), laser)
        grid = self._mapper.grid()
        assert grid is not None, "two scans make a map"
        return grid

    def on_scan(self, scan: Scan, laser: Pose2D) -> None:
        self._mapper.observe(scan, laser)

    def duty(self) -> Duty:
        return Duty("map", MAP_HZ, self._grow)

    def _grow(self, _: World, stamp_ns: int) -> None:
        grid = self._mapper.grid()
        if grid is not None:
            self._take(grid, stamp_ns)
