"""What befalls a mission in a world: services die and come back, a person stops, pauses, cancels or takes the stick."""

import asyncio
import contextlib
import math
from collections.abc import AsyncGenerator
from dataclasses import dataclass, field

import numpy as np

from bench.world.mesh import Mesh
from bench.world.wire import open_socket
from contracts.geometry import Pose2D, Twist2D
from contracts.robot import EmergencyStopReply, EmergencyStopRequest, VelocityRequest
from mesh.errors import MeshError

PERIOD_S = 0.1
REBORN_AFTER_S = 2.0
"""So soon the supervisor starts a coordinator anew."""
STILL_M = 0.01
STILL_AFTER_S, STILL_AFTER_STOP_S = 4.0, 0.5
"""A mission that is over or paused may be braking, or waiting for a call to be refused, no longer than this; a stopped
robot no longer than its brakes take."""
CUTTABLE = ("coordinator POST robot_bridge/rotate", "coordinator POST robot_bridge/drive")
TAKEN_S = 0.3
"""For so long a person's stick has the wheels."""


@dataclass
class Fate:
    """One mission's, by `mesh.line.faults`; times count from `begun_s`. `problems`: motion where none may be."""

    mesh: Mesh
    mission_id: str
    begun_s: float
    seed: int = 0
    problems: list[str] = field(default_factory=list[str])
    latched: bool = False

    @contextlib.asynccontextmanager
    async def at_work(self) -> AsyncGenerator["Fate"]:
        faults = self.mesh.line.faults
        deeds = [self._outage(one.service, one.from_s, one.to_s) for one in faults.outages]
        deeds += [self._stop(), self._pause(), self._cancel(), self._coordinator_dies(), self._cut_turns()]
        tasks = [asyncio.create_task(deed) for deed in (*deeds, self._watch())]
        try:
            yield self
        finally:
            for task in tasks:
                task.cancel()
            for failed in await asyncio.gather(*tasks, return_exceptions=True):
                if isinstance(failed, Exception):
                    raise failed

    async def _at(self, when_s: float | None) -> bool:
        if when_s is None:
            return False
        await asyncio.sleep(max(0.0, self.begun_s + when_s - asyncio.get_running_loop().time()))
        return True

    async def _outage(self, service: str, from_s: float, to_s: float) -> None:
        await self._at(from_s)
        await self.mesh.processes[service].die()
        await self._at(to_s)
        await self.mesh.processes[service].begin()

    async def _coordinator_dies(self) -> None:
        if await self._at(self.mesh.line.faults.coordinator_dies_s):
            await self.mesh.processes["coordinator"].die()
            await asyncio.sleep(REBORN_AFTER_S)
            await self.mesh.processes["coordinator"].begin()

    async def _stop(self) -> None:
        """A person presses it until it is heard: the bridge may be down."""
        faults = self.mesh.line.faults
        if await self._at(faults.stop_s):
            await self._press("/emergency-stop")
            self.latched = True
            if await self._at(faults.reset_s):
                await self._press("/emergency-stop/reset")
                self.latched = False

    async def _press(self, button: str) -> None:
        person = self.mesh.client(self.mesh.bridge)
        request = EmergencyStopRequest(reason="pressed in the campaign", by="a person")
        while True:
            with contextlib.suppress(MeshError):
                await person.post(button, request, EmergencyStopReply)
                return
            await asyncio.sleep(1.0)

    async def _pause(self) -> None:
        faults = self.mesh.line.faults
        if await self._at(faults.pause_s) and self._missions_live:
            with contextlib.suppress(MeshError):
                await self.mesh.missions.pause(self.mission_id)
        if await self._at(faults.resume_s) and self._missions_live:
            with contextlib.suppress(MeshError):
                await self.mesh.missions.resume(self.mission_id)

    async def _cancel(self) -> None:
        if await self._at(self.mesh.line.faults.cancel_s) and self._missions_live:
            with contextlib.suppress(MeshError):
                await self.mesh.missions.cancel(self.mission_id)

    async def _cut_turns(self) -> None:
        """Now and then a person takes the stick while the robot turns or drives straight, and lets go of it."""
        chance, rng, calls = self.mesh.line.faults.motion_cut, np.random.default_rng([self.seed, 420]), self.mesh.calls
        if chance == 0.0:
            return
        before = sum(calls[name] for name in CUTTABLE)
        while True:
            await asyncio.sleep(PERIOD_S)
            now = sum(calls[name] for name in CUTTABLE)
            cut, before = now > before and rng.random() < chance, now
            if cut:
                await asyncio.sleep(float(rng.uniform(0.1, 1.5)))
                with contextlib.suppress(OSError):
                    await self._take_the_stick()

    async def _take_the_stick(self) -> None:
        lease = VelocityRequest(twist=Twist2D(), source="a person", epoch=0, duration_s=TAKEN_S)
        async with open_socket(self.mesh.bridge, "ws://service/velocity") as stick:
            await stick.send(lease.model_dump_json())
            await stick.recv()
            await asyncio.sleep(TAKEN_S)

    # --- the robot stands while nothing may move it

    @property
    def _missions_live(self) -> bool:
        return self.mesh.processes["coordinator"].served.up

    @property
    def _may_move(self) -> bool:
        if not self._missions_live or self.latched:
            return False
        mission = self.mesh.missions.runner.mission
        return mission.running and not mission.paused and not mission.state.resting

    async def _watch(self) -> None:
        loop, world = asyncio.get_running_loop(), self.mesh.robot.world
        quiet_since_s, stood = math.inf, None
        while True:
            await asyncio.sleep(2 * PERIOD_S)
            now_s, pose = loop.time(), world.truth.pose
            if self._may_move:
                quiet_since_s, stood = math.inf, None
                continue
            quiet_since_s = min(quiet_since_s, now_s)
            if now_s - quiet_since_s < (STILL_AFTER_STOP_S if self.latched else STILL_AFTER_S):
                continue
            if stood is not None and _away_m(pose, stood) > STILL_M:
                self.problems.append(f"motion: the robot moved {now_s - quiet_since_s:.1f} s after it should stand")
            stood = pose


def _away_m(one: Pose2D, other: Pose2D) -> float:
    return math.hypot(one.x - other.x, one.y - other.y)
