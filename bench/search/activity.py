"""Where the seconds went: what the mission was at, looked at ten times a second."""

import asyncio
from collections import Counter

from coordinator.commands.mission_service import MissionService
from sim.world import World

PERIOD_S = 0.1
STILL_M_S, STILL_RAD_S = 0.01, 0.05
NAMES = {
    "Navigating": "drive to a place",
    "ChoosingPath": "choose a way",
    "PlanningCoverage": "plan where to look",
    "Rotating": "turn",
    "AwaitingFrame": "wait for a picture",
    "Validating": "vote",
    "Driving": "drive straight",
    "Steering": "drive straight",
    "Waiting": "wait for a service",
    "Undocking": "undock",
}
"""Of the core's activities; what is not named is told as it is."""


class Activity:
    """`seconds`: by state and activity; `standing_s`: of all of it, while neither driving nor turning."""

    def __init__(self) -> None:
        self.seconds: Counter[str] = Counter()
        self.standing_s = 0.0

    async def watch(self, missions: MissionService, world: World) -> None:
        while True:
            await asyncio.sleep(PERIOD_S)
            mission = missions.runner.mission
            if not mission.running:
                continue
            doing = type(mission.activity).__name__
            self.seconds[f"{mission.state.value}: {NAMES.get(doing, doing.lower())}"] += 1
            twist = world.truth.twist
            if abs(twist.linear_x) < STILL_M_S and abs(twist.angular_z) < STILL_RAD_S:
                self.standing_s += PERIOD_S

    def told(self) -> dict[str, float]:
        return {name: round(count * PERIOD_S, 1) for name, count in sorted(self.seconds.items())}
