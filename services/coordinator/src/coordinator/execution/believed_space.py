"""The shell's side of the belief: one a mission, on the newest map, told of every look; choosing runs in a thread."""

import asyncio
import threading
from collections.abc import Sequence

from contracts.description import RobotDescription
from contracts.geometry import Pose2D
from contracts.vision import Detections, Target
from coordinator.belief.belief_map import BeliefMap, Glance, box_bearings
from coordinator.belief.clues import Clue
from coordinator.belief.next_view import Choice, MotionTimes, NextView, next_view
from coordinator.core.actions import PlanCoverage
from coordinator.core.rules import Rules
from coordinator.coverage.explored_space import LOOKS_MAX, PLANNING_TASK
from geometry.grids import OccupancyGrid
from geometry.poses import apart_m, wrap

BESIDE_M, BESIDE_RAD = 0.5, 0.35


class BelievedSpace:
    def __init__(self, rules: Rules, body: RobotDescription, target: Target, clues: tuple[Clue, ...]) -> None:
        self._rules = rules
        self._body = body
        self._target = target
        self._clues = clues
        self._belief: BeliefMap | None = None
        self._glances: list[Glance] = []
        self._told = 0
        self._chosen: NextView | None = None
        self._choosing = threading.Lock()

    def look(self, pose: Pose2D, seen: Detections | None) -> None:
        if seen is None or len(self._glances) >= LOOKS_MAX:
            return
        boxes = (
            box_bearings(one.bbox_xyxy[0], one.bbox_xyxy[2], seen.image_width_px, self._rules.camera_hfov_rad)
            for one in seen.detections
            if self._target.may_be(one.label, one.colour)
        )
        self._glances.append(Glance(pose, self._rules.camera_hfov_rad, tuple(boxes)))

    async def choose(self, grid: OccupancyGrid, here: Pose2D, asked: PlanCoverage) -> Choice:
        choosing = asyncio.to_thread(self._choose, grid, here, asked)
        return await asyncio.create_task(choosing, name=PLANNING_TASK)

    def _choose(self, grid: OccupancyGrid, here: Pose2D, asked: PlanCoverage) -> Choice:
        """The belief is touched here alone, one call after another: the thread of a cancelled one goes on."""
        with self._choosing:
            body, rules, belief = self._body, self._rules, self._belief
            if belief is None or belief.grid is not grid:
                self._told = 0
                belief = self._belief = BeliefMap(
                    grid, label=self._target.label, clues=self._clues, radius_m=body.footprint_radius_m, start=here
                )
            told = len(self._glances)
            new = self._glances[self._told : told]
            for glance in new:
                belief.look(glance)
            self._spend(belief, new)
            self._told = told
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
            choice = next_view(belief, here, pace, avoid=asked.avoid)
            self._chosen = choice.view
            return choice

    def _spend(self, belief: BeliefMap, new: Sequence[Glance]) -> None:
        """The robot stops a little beside the place it chose, and turned a little beside the heading."""
        if (chosen := self._chosen) is None:
            return
        for heading in chosen.headings:
            for glance in new:
                near = apart_m(glance.pose, chosen.pose) <= BESIDE_M
                if near and abs(wrap(glance.pose.yaw - heading)) <= BESIDE_RAD:
                    for place in (glance.pose, chosen.pose):
                        turned = place.model_copy(update={"yaw": heading})
                        belief.spend(turned, self._rules.camera_hfov_rad)
