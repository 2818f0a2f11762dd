"""The shell's side of the belief: one a mission, on the newest map, told of every look; choosing runs in a thread."""

import asyncio
import threading

from contracts.belief import ChosenView, SearchBelief
from contracts.description import RobotDescription
from contracts.geometry import Pose2D
from contracts.vision import Detections, Target
from coordinator.belief.belief_map import BeliefMap, Glance, box_bearings
from coordinator.belief.clues import Clue
from coordinator.belief.next_view import Choice, MotionTimes, next_view
from coordinator.core.actions import PlanCoverage
from coordinator.core.area import SearchArea
from coordinator.core.events import MissionStarted
from coordinator.core.rules import CoverageRule, Rules
from coordinator.coverage.areas import mask_of
from coordinator.coverage.explored_space import LOOKS_MAX, PLANNING_TASK
from geometry import probability_grids
from geometry.grids import OccupancyGrid
from geometry.poses import apart_m, wrap

BESIDE_M, BESIDE_RAD = 0.5, 0.35


def believed(rules: Rules, body: RobotDescription | None, search: MissionStarted) -> "BelievedSpace | None":
    """None where the search goes by another rule, or the robot is not described."""
    if body is None or rules.coverage_rule is not CoverageRule.BELIEF:
        return None
    return BelievedSpace(rules, body, search.target, search.clues, search.area)


class BelievedSpace:
    def __init__(
        self,
        rules: Rules,
        body: RobotDescription,
        target: Target,
        clues: tuple[Clue, ...],
        area: SearchArea | None = None,
    ) -> None:
        self._rules = rules
        self._body = body
        self._target = target
        self._clues = clues
        self._area = area
        self._belief: BeliefMap | None = None
        self._glances: list[Glance] = []
        self._spent: list[Pose2D] = []
        self._told = 0
        self._chosen: Choice | None = None
        self._touching = threading.Lock()
        self._asking = asyncio.Lock()

    def look(self, pose: Pose2D, seen: Detections | None, *, moving: bool = False) -> None:
        if seen is None or len(self._glances) >= LOOKS_MAX:
            return
        boxes = (
            box_bearings(one.bbox_xyxy[0], one.bbox_xyxy[2], seen.image_width_px, self._rules.camera_hfov_rad)
            for one in seen.detections
            if self._target.may_be(one.label, one.colour)
        )
        self._glances.append(Glance(pose, self._rules.camera_hfov_rad, tuple(boxes), moving))

    async def choose(self, grid: OccupancyGrid, here: Pose2D, asked: PlanCoverage) -> Choice:
        choosing = asyncio.to_thread(self._choose, grid, here, asked)
        return await asyncio.create_task(choosing, name=PLANNING_TASK)

    async def report(self, mission_id: str, map_id: str | None, now_s: float) -> SearchBelief | None:
        """What is believed after every look so far; none before the first choice. Whoever asks changes no choice: the
        order of looks is no matter. One thread at a time: while a choice is under way the others wait without one.
        """
        async with self._asking:
            return await asyncio.to_thread(self._report, mission_id, map_id, now_s)

    def _choose(self, grid: OccupancyGrid, here: Pose2D, asked: PlanCoverage) -> Choice:
        """The belief is touched by one thread after another: that of a cancelled call goes on."""
        with self._touching:
            body, rules, belief = self._body, self._rules, self._belief
            if belief is None or belief.grid is not grid:
                belief = self._belief = BeliefMap(
                    grid,
                    label=self._target.label,
                    clues=self._clues,
                    radius_m=body.footprint_radius_m,
                    start=here,
                    within=mask_of(self._area, grid) if self._area is not None else None,
                )
                for glance in self._glances[: self._told]:
                    belief.look(glance)
                for pose in self._spent:
                    belief.spend(pose, rules.camera_hfov_rad)
            self._tell(belief)
            for x, y in asked.expected:
                belief.expect(x, y)
            for x, y in asked.refused:
                belief.refuse(x, y)
            pace = MotionTimes(
                speed_m_s=body.speed_m_s_max,
                turn_rad_s=rules.scan_speed_rad_s,
                hfov_rad=rules.camera_hfov_rad,
                step_rad=min(rules.scan_step_rad, rules.camera_hfov_rad * (1.0 - rules.scan_overlap_min)),
            )
            self._chosen = next_view(belief, here, pace, avoid=asked.avoid)
            return self._chosen

    def _report(self, mission_id: str, map_id: str | None, now_s: float) -> SearchBelief | None:
        with self._touching:
            belief, chosen = self._belief, self._chosen
            if belief is None or chosen is None:
                return None
            self._tell(belief)
            cells, absent = belief.cells, belief.absent
        view = chosen.view
        return SearchBelief(
            stamp_s=max(0.0, now_s),
            mission_id=mission_id,
            map_id=map_id,
            grid=probability_grids.encode(cells, resolution_m=belief.coarse.resolution_m, origin=belief.grid.origin),
            absent=min(1.0, absent),
            view=ChosenView(pose=view.pose, headings=view.headings, gain=min(1.0, view.gain), seconds=view.seconds)
            if view is not None
            else None,
            why=chosen.why[:500],
        )

    def _tell(self, belief: BeliefMap) -> None:
        told = len(self._glances)
        for glance in self._glances[self._told : told]:
            belief.look(glance)
            self._spend(belief, glance)
        self._told = told

    def _spend(self, belief: BeliefMap, glance: Glance) -> None:
        """The robot stops a little beside the place it chose, and turned a little beside the heading. What it sees in
        passing is no such look: it may not get there."""
        view = self._chosen.view if self._chosen is not None else None
        if glance.moving or view is None or apart_m(glance.pose, view.pose) > BESIDE_M:
            return
        for heading in view.headings:
            if abs(wrap(glance.pose.yaw - heading)) <= BESIDE_RAD:
                for place in (glance.pose, view.pose):
                    self._spent.append(place.model_copy(update={"yaw": heading}))
                    belief.spend(self._spent[-1], self._rules.camera_hfov_rad)
