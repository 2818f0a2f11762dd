"""The shell's side of coverage: the newest map, what was looked at on it, and the plan of what is left."""

import asyncio
from collections.abc import Sequence

from contracts.description import RobotDescription
from contracts.geometry import Pose2D
from contracts.robot import Map
from coordinator.core.area import SearchArea
from coordinator.core.rules import CoverageRule, Rules
from coordinator.coverage.areas import mask_of
from coordinator.coverage.baselines import in_random_order, nearest_frontiers
from coordinator.coverage.coverage_tracker import CoverageTracker
from coordinator.coverage.lawnmower import Coverage, lawnmower
from coordinator.coverage.viewpoints import viewpoints
from coordinator.ports import Robot
from geometry.grids import decode
from mesh.errors import UnavailableError

LOOKS_MAX = 5000
PLANNING_TASK = "plan-coverage"
READING_TASK = "plan-map"


class ExploredSpace:
    """One per mission. A map is read and planned on in a thread: a large one takes seconds."""

    def __init__(
        self, robot: Robot, rules: Rules, body: RobotDescription | None, area: SearchArea | None = None
    ) -> None:
        self._robot = robot
        self._rules = rules
        self._body = body
        self._area = area
        self._map: Map | None = None
        self._space: CoverageTracker | None = None
        self._looks: list[Pose2D] = []
        self._reading = asyncio.Lock()

    def look(self, pose: Pose2D) -> float | None:
        """The share of the free space looked at, or none while there is no map yet, or none on it."""
        if len(self._looks) < LOOKS_MAX:
            self._looks.append(pose)
        if self._space is None:
            return None
        self._mark(self._space, pose)
        return self._space.share

    async def refresh(self) -> CoverageTracker:
        """Fetches the map; where it has changed, what was looked at is marked on the new one.

        Raises `UnavailableError`, `UpstreamError`, `geometry.grids.MapError`.
        """
        async with self._reading:
            newest = await self._robot.map()
            if self._space is not None and self._map == newest:
                return self._space
            looks = tuple(self._looks)
            reading = asyncio.to_thread(self._space_of, newest, looks)
            space = await asyncio.create_task(reading, name=READING_TASK)
            for pose in self._looks[len(looks) :]:  # taken meanwhile
                self._mark(space, pose)
            self._map, self._space = newest, space
            return space

    async def plan(self, start: Pose2D | None, avoid: tuple[Pose2D, ...]) -> Coverage:
        """What is still worth a scan, in order. Raises as `refresh` does."""
        if self._body is None:
            raise UnavailableError("robot_bridge", "it has not described its robot yet")
        space = await self.refresh()
        planning = asyncio.to_thread(plan_coverage, space, self._rules, self._body.footprint_radius_m, start, avoid)
        return await asyncio.create_task(planning, name=PLANNING_TASK)

    def _space_of(self, newest: Map, looks: Sequence[Pose2D]) -> CoverageTracker:
        grid = decode(newest)
        space = CoverageTracker(grid, mask_of(self._area, grid) if self._area is not None else None)
        for pose in looks:
            self._mark(space, pose)
        return space

    def _mark(self, space: CoverageTracker, pose: Pose2D) -> None:
        space.mark(pose, hfov_rad=self._rules.camera_hfov_rad, reach_m=self._rules.look_range_m)


def plan_coverage(
    space: CoverageTracker, rules: Rules, radius_m: float, start: Pose2D | None, avoid: tuple[Pose2D, ...]
) -> Coverage:
    seen = space.seen.copy()
    match rules.coverage_rule:
        case CoverageRule.LAWNMOWER:
            return lawnmower(space.grid, radius_m=radius_m, within=space.within)
        case CoverageRule.FRONTIER:
            return nearest_frontiers(
                space.grid, radius_m=radius_m, start=start, seen=seen, avoid=avoid, within=space.within
            )
        case CoverageRule.VIEWPOINTS | CoverageRule.RANDOM | CoverageRule.BELIEF as rule:
            coverage = viewpoints(
                space.grid,
                radius_m=radius_m,
                start=start,
                reach_m=rules.look_range_m,
                seen=seen,
                avoid=avoid,
                points_max=rules.scan_points_max,
                within=space.within,
            )
            return in_random_order(coverage) if rule is CoverageRule.RANDOM else coverage
