"""Asks Nav2 whether a pose can be reached before the robot sets out, and for another one near it where it cannot."""

import asyncio
import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import structlog
from pydantic import Field

from contracts.geometry import Point3D, Pose2D
from contracts.robot import CandidatePose, PathReply
from geometry.poses import apart_m
from mesh.clock import Clock
from mesh.errors import UnavailableError
from robot_bridge.body import BodyLimits
from robot_bridge.navigation.candidate_poses import ClearanceMap, by_clearance, candidate_poses, length_m
from robot_bridge.navigation.goal_states import (
    NO_VALID_PATH,
    START_OCCUPIED,
    error_name,
    says_nothing_of_the_goal,
)
from robot_bridge.navigation.maps import clearance_map, why_not_in
from robot_bridge.ports import Path, Robot
from robot_bridge.sensing.sensor_readings import Grid

BESIDE_M = 0.6
"""Farther than NavFn's tolerance would let a plan end that does not move at all."""
log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class GoalRegion:
    """Poses that would do, and how far from the first the robot may end, looking where."""

    candidates: tuple[CandidatePose, ...]
    radius_m: float
    look_at: Point3D | None = None


@dataclass(frozen=True, slots=True)
class PathCheck:
    """`pose` is none where nothing can be reached; `error_code` is Nav2's for the pose asked for first (0 = none)."""

    pose: Pose2D | None
    candidate: int | None = None
    """Which one `pose` is; none where it lies on the ring."""
    plan: tuple[Pose2D, ...] = ()
    tried: int = 0
    error_code: int = 0
    ends_off_m: float | None = None
    """How far from the wanted pose Nav2's plan ended, where it gave one that ended elsewhere."""

    @property
    def unreachable(self) -> bool:
        """Nav2 would only find out the same; where the planner's trouble is another one, Nav2 may get over it."""
        return self.pose is None and not says_nothing_of_the_goal(self.error_code)

    @property
    def reason(self) -> str:
        if self.pose is not None:
            return ""
        others = f", nor to {self.tried - 1} poses round it" if self.tried > 1 else ""
        if self.error_code == START_OCCUPIED:
            return "Nav2 finds no way out of where the robot stands"
        if self.ends_off_m is not None:
            return f"no path leads there (Nav2's plan ends {self.ends_off_m:.2f} m from it){others}"
        return f"no path leads there ({error_name(self.error_code)}){others}"


class Choice(NamedTuple):
    """A pose to ask for a path to, in the order of asking. `least_m` is what it costs at least, `number` which
    candidate it is; none on the ring."""

    rank: int
    least_m: float
    pose: Pose2D
    cost_m: float = 0.0
    number: int | None = None


class PathLimits(BodyLimits):
    ring_clearance_m: float = Field(default=0.08, ge=0.0, description="of the footprint, for poses on the ring")
    preflight_poses_max: int = Field(default=40, ge=1, le=100, description="asked of the planner before a goal")
    preflight_s_max: float = Field(default=4.0, gt=0.0, description="for all questions to the planner before a goal")
    plan_end_off_m_max: float = Field(
        default=0.15, gt=0.0, le=2.0, description="a plan that ends farther from its goal does not lead there"
    )
    costmap_timeout_s: float = Field(default=1.0, gt=0.0, description="for Nav2 to clear its costmaps")
    fresh_scan_wait_s_max: float = Field(default=1.5, ge=0.0, description="for a scan to fill the cleared costmaps")


class PathChecker:
    """One question at a time to Nav2's planner, bounded in number and in time."""

    def __init__(self, robot: Robot, limits: PathLimits) -> None:
        self._robot = robot
        self._limits = limits
        self._room: tuple[Grid, ClearanceMap] | None = None

    async def best(self, region: GoalRegion, start: Pose2D | None = None) -> PathCheck:
        """The best candidate that a path leads to, else the nearest pose on the ring. Raises `UnavailableError`."""
        here, grid = start or self._robot.senses.poses.newest(), self._robot.senses.map.value
        first: list[Choice] = []
        for number, each in enumerate(region.candidates):
            if grid is None or why_not_in(grid, each.pose) is None:
                crow_m = apart_m(each.pose, here) if here is not None else 0.0
                first.append(Choice(each.rank, each.cost_m + crow_m, each.pose, each.cost_m, number))
        return await self._best(sorted(first, key=lambda each: each[:2]) + _in_turn(self._ring(region)), start)

    def first(self, region: GoalRegion) -> int:
        """The number of the first candidate that lies in the map."""
        grid = self._robot.senses.map.value
        inside = (k for k, each in enumerate(region.candidates) if grid is None or why_not_in(grid, each.pose) is None)
        return next(inside, 0)

    async def roomier(self, region: GoalRegion, than: Pose2D) -> PathCheck:
        """A reachable pose of the ring with more room about it than `than` has."""
        room = self._known_room()
        if room is None:
            return PathCheck(None)
        more = [pose for pose in self._ring(region) if room.at(pose) > room.at(than) + room.grid.resolution_m]
        return await self._best(_in_turn(by_clearance(more, room)), None)

    async def clear_costmaps(self, clock: Clock) -> None:
        """So that ghosts of past obstacles do not reject the goal; then waits for a scan to fill them anew (A13)."""
        try:
            await asyncio.wait_for(self._robot.clear_costmaps(), self._limits.costmap_timeout_s)
        except (UnavailableError, TimeoutError) as error:
            log.warning("the costmaps were not cleared", error=str(error) or type(error).__name__)
        cleared_s, wait_s = clock.now_s(), self._limits.fresh_scan_wait_s_max
        scan = await self._robot.senses.scan.wait_for(lambda reading: reading.received_s > cleared_s, wait_s)
        if scan is None:
            log.warning("no fresh scan fills the cleared costmaps", waited_s=wait_s)

    async def _best(self, choices: list[Choice], start: Pose2D | None) -> PathCheck:
        """Not asked for is what cannot be better any more: of a higher rank, or dearer even as the crow flies."""
        found, rank, cheapest_m = PathCheck(None), 0, math.inf
        tried, code, off_m = 0, 0, None
        try:
            async with asyncio.timeout(self._limits.preflight_s_max):
                for choice in choices[: self._limits.preflight_poses_max]:
                    if found.pose is not None and (choice.rank > rank or choice.least_m >= cheapest_m):
                        break
                    plan = await self._robot.compute_path(choice.pose, start)
                    tried += 1
                    failed = self._failure(plan, choice.pose)
                    cost_m = choice.cost_m + length_m(plan.poses)
                    if not failed and cost_m < cheapest_m:
                        found, rank, cheapest_m = PathCheck(choice.pose, choice.number, plan.poses), choice.rank, cost_m
                    if tried == 1 and failed:
                        code, off_m = failed, _end_off_m(plan, choice.pose)
                        if failed == NO_VALID_PATH and await self._is_shut_in(start):
                            code = START_OCCUPIED
                    if says_nothing_of_the_goal(code if tried == 1 else failed):
                        break  # another goal would meet the same
        except TimeoutError:
            log.warning("the preflight ran out of time", tried=tried)
            code = code or (NO_VALID_PATH if found.pose is None else 0)
        return replace(found, tried=tried, error_code=code, ends_off_m=off_m)

    def _failure(self, plan: Path, pose: Pose2D) -> int:
        """Nav2's code; NO_VALID_PATH also for a plan that ends elsewhere: NavFn takes the nearest point it can reach
        (its `tolerance`), with code 0."""
        off_m = _end_off_m(plan, pose)
        elsewhere = off_m is None or off_m > self._limits.plan_end_off_m_max
        return plan.error_code or (NO_VALID_PATH if elsewhere else 0)

    async def _is_shut_in(self, start: Pose2D | None) -> bool:
        """Nav2 blames the goal where the robot itself stands too near something (208): asked once for a way to a roomy
        pose beside the start, it says the same."""
        here, room = start or self._robot.senses.poses.newest(), self._known_room()
        if here is None or room is None:
            return False
        clearance_m = self._limits.footprint_radius_m + self._limits.ring_clearance_m
        around = candidate_poses(here, room, radius_m=BESIDE_M, clearance_m_min=clearance_m)
        beside = next((pose for pose in around if apart_m(pose, here) > BESIDE_M - 0.1), None)
        if beside is None:
            return False
        return self._failure(await self._robot.compute_path(beside, start), beside) == NO_VALID_PATH

    def _ring(self, region: GoalRegion) -> list[Pose2D]:
        room = self._known_room()
        if room is None or region.radius_m <= 0.0:
            return []
        return candidate_poses(
            region.candidates[0].pose,
            room,
            radius_m=region.radius_m,
            clearance_m_min=self._limits.footprint_radius_m + self._limits.ring_clearance_m,
            look_at=region.look_at,
        )

    def _known_room(self) -> ClearanceMap | None:
        """Computed once for each map."""
        grid = self._robot.senses.map.value
        if grid is None:
            return None
        if self._room is None or self._room[0] is not grid:
            self._room = grid, clearance_map(grid)
        return self._room[1]


RING_RANK = 1_000_000


def _in_turn(poses: list[Pose2D]) -> list[Choice]:
    """The first that can be reached is taken."""
    return [Choice(RING_RANK + k, 0.0, pose) for k, pose in enumerate(poses)]


def path_reply(checked: PathCheck) -> PathReply:
    reachable = checked.pose is not None
    return PathReply(
        reachable=reachable,
        goal=checked.pose,
        length_m=length_m(checked.plan) if reachable else None,
        tried=checked.tried,
        error_code=checked.error_code,
        error_name=error_name(checked.error_code),
        poses=checked.plan,
    )


def _end_off_m(plan: Path, pose: Pose2D) -> float | None:
    """From where a plan ends to where it was to end; none without a plan."""
    return apart_m(plan.poses[-1], pose) if plan.poses else None


async def best_or_first(preflight: PathChecker, region: GoalRegion) -> PathCheck:
    """As `best`; the first candidate in the map where the planner does not answer, or the goal is not to blame."""
    try:
        checked = await preflight.best(region)
    except UnavailableError as error:
        log.warning("no preflight: the planner does not answer", error=error.detail)
        checked = None
    if checked is None or (checked.pose is None and not checked.unreachable):
        number = preflight.first(region)
        return PathCheck(region.candidates[number].pose, number)
    return checked
