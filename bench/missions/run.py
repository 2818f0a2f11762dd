"""One mission from its scenario to its verdict: the coordinator's own app, its other services simulated."""

import asyncio
import contextlib
from collections.abc import AsyncGenerator
from dataclasses import dataclass, field

import numpy as np

from bench.missions.bridge import SimulatedBridge
from bench.missions.bus import SimulatedBus
from bench.missions.eyes import SimulatedEyes, SimulatedMemory
from bench.missions.place import SimulatedPlace
from bench.missions.scenario import Scenario, remembered_views
from bench.world.clock import SimulatedClock
from contracts.geometry import Pose2D
from contracts.mission import Mission, MissionEvent, MissionState
from contracts.vision import ParsedTarget
from coordinator.adapters.interrupted import interrupted
from coordinator.app import create_app
from coordinator.commands.mission_service import MissionService
from coordinator.settings import Settings
from mesh.errors import MeshError
from support.memory_log import MemoryLog

SLACK_S = 60.0
AFTER_S = 8.0
STILL_AFTER_S = 4.0
"""A mission that is over or paused may be braking, or waiting for a call to be refused, no longer than this."""


@dataclass
class Run:
    """What happened, for the verdict."""

    scenario: Scenario
    mission: Mission | None = None
    refused: str = ""
    """Why no mission was begun."""
    events: list[MissionEvent] = field(default_factory=list[MissionEvent])
    problems: list[str] = field(default_factory=list[str])
    """Hangs, crashes, and motion where none may be."""
    pose: Pose2D = field(default_factory=lambda: Pose2D(x=0.0, y=0.0, yaw=0.0))
    took_s: float = 0.0
    way_m: float = 0.0
    recording: tuple[str, ...] = ()


@dataclass
class Stage:
    """The simulated services and the coordinator's life in the middle of them."""

    bridge: SimulatedBridge
    bus: SimulatedBus
    eyes: SimulatedEyes
    memory: SimulatedMemory
    settings: Settings
    log: MemoryLog
    run: Run
    missions: MissionService | None = None
    quiet_since_s: float = float("inf")
    quiet_from: Pose2D | None = None

    @contextlib.asynccontextmanager
    async def coordinator(self) -> AsyncGenerator[MissionService]:
        """The service from its composition root, without HTTP; leaving the block is its death."""
        app = create_app(
            self.settings, bus=self.bus, robot=self.bridge, inference=self.eyes, memory=self.memory, log=self.log,
            clock=SimulatedClock(), on_death=lambda: self.run.problems.append("crash: a background task died"),
        )  # fmt: skip
        async with app.router.lifespan_context(app) as state:
            assert state is not None, "the app's own"
            self.missions = missions = state["missions"]
            yield missions
            self.missions = None

    @property
    def may_move(self) -> bool:
        if self.missions is None:
            return False
        mission = self.missions.runner.mission
        return mission.running and not mission.paused and not mission.state.resting

    def asked(self, what: str) -> None:
        if not self.may_move:
            state = self.missions.runner.mission.state.value if self.missions is not None else "dead"
            self.run.problems.append(f"motion: {what} was asked for while {state} or paused")

    async def watch(self) -> None:
        """The robot stands still while nothing may move it."""
        while True:
            await asyncio.sleep(0.2)
            now_s, pose = asyncio.get_running_loop().time(), self.bridge.wheels.pose
            if self.may_move and not self.bridge.stop.latched:
                self.quiet_since_s, self.quiet_from = float("inf"), None
                continue
            self.quiet_since_s = min(self.quiet_since_s, now_s)
            limit_s = 0.3 if self.bridge.stop.latched else STILL_AFTER_S
            if now_s - self.quiet_since_s < limit_s:
                continue
            if self.quiet_from is not None and np.hypot(pose.x - self.quiet_from.x, pose.y - self.quiet_from.y) > 0.01:
                late_s = now_s - self.quiet_since_s
                self.run.problems.append(f"motion: the robot moved {late_s:.1f} s after it should stand")
            self.quiet_from = pose


async def run_mission(place: SimulatedPlace, one: Scenario) -> Run:
    """Plays the scenario to its end; an error is the simulation's own, or a hang."""
    rng = np.random.default_rng([one.seed, 3])
    start = one.start or (place.dock if one.docked else place.random_pose(rng))
    run, log = Run(one), MemoryLog()
    bus = SimulatedBus(one.faults, np.random.default_rng([one.seed, 4]))
    bridge = SimulatedBridge(place, start, one.faults, bus, one.seed, docked=one.docked)
    task = ParsedTarget(
        said=one.command,
        yolo_class=one.kind,
        memory_object=one.kind,
        description=f"{one.asked_colour} {one.kind}",
        parser="given",
    )
    eyes = SimulatedEyes(bridge, bus, one.faults, task, one.seed)
    memory = SimulatedMemory(remembered_views(place, one, rng), one.kind, one.faults, one.seed)
    stage = Stage(bridge, bus, eyes, memory, Settings.model_validate(one.rules), log, run)
    bridge.asked = stage.asked
    async with asyncio.TaskGroup() as group:
        others = [group.create_task(work) for work in (bridge.run(), eyes.run(), stage.watch())]
        await _lived(stage)
        for other in others:
            other.cancel()
    run.pose, run.way_m = bridge.wheels.pose, bridge.wheels.way_m
    return run


async def _lived(stage: Stage) -> None:
    faults, run = stage.run.scenario.faults, stage.run
    loop = asyncio.get_running_loop()
    async with stage.coordinator() as missions:
        await asyncio.sleep(1.0)
        began_s = loop.time()
        for wire in (stage.bridge.wire, stage.eyes.wire, stage.memory.wire):
            wire.started_s = began_s
        try:
            mission_id = await _started(missions, run)
        except MeshError as error:
            run.refused = f"{type(error).__name__}: {error.detail}"
            return
        whims = asyncio.ensure_future(_whims(stage, missions, mission_id, began_s))
        settings = stage.settings
        limit_s = settings.mission_timeout_s + settings.pause_timeout_s + SLACK_S
        while (await missions.get(mission_id)).outcome is None:
            await asyncio.sleep(0.5)
            elapsed_s = loop.time() - began_s
            if faults.coordinator_dies_s is not None and elapsed_s > faults.coordinator_dies_s:
                break
            if elapsed_s > limit_s:
                run.problems.append(f"hang: not over after {elapsed_s:.0f} s")
                break
        run.took_s = loop.time() - began_s
        ended = (await missions.get(mission_id)).outcome is not None
        if ended or faults.coordinator_dies_s is None:
            await asyncio.sleep(AFTER_S)
            await _rested(stage, missions)
        run.mission = await missions.get(mission_id)
        run.recording = await stage.log.recording(mission_id)
        run.events = list(await missions.log.events(mission_id, after=-1, limit=5000))
        await _ended(whims)
    if not ended and faults.coordinator_dies_s is not None:
        await _reborn(stage, mission_id)


async def _started(missions: MissionService, run: Run) -> str:
    begun = await missions.start(run.scenario.command)
    assert isinstance(begun, Mission), "the command starts one"
    return begun.id


async def _rested(stage: Stage, missions: MissionService) -> None:
    """After its ending a mission leaves the coordinator IDLE, or stopped while the stop is latched."""
    state = missions.runner.mission.state
    stopped = stage.bridge.stop.latched and state is MissionState.EMERGENCY_STOP
    if state is not MissionState.IDLE and not stopped:
        stage.run.problems.append(f"hang: {state.value} {AFTER_S:.0f} s after the ending")


async def _reborn(stage: Stage, mission_id: str) -> None:
    """After its death the coordinator comes back idle, and nothing resumes. Its log says what the real one would."""
    await asyncio.sleep(2.0)
    left = await stage.log.get(mission_id)
    if left is not None and left.outcome is None:
        stage.log.upsert(interrupted(left, asyncio.get_running_loop().time()))
    async with stage.coordinator() as missions:
        await asyncio.sleep(AFTER_S)
        if missions.runner.mission.state not in {MissionState.IDLE, MissionState.EMERGENCY_STOP}:
            stage.run.problems.append("motion: something resumed after the coordinator's restart")
        stage.run.mission = await missions.get(mission_id)


async def _whims(stage: Stage, missions: MissionService, mission_id: str, began_s: float) -> None:
    """What the person does, and when."""
    faults = stage.run.scenario.faults

    async def at(when_s: float | None) -> bool:
        if when_s is None:
            return False
        await asyncio.sleep(max(0.0, began_s + when_s - asyncio.get_running_loop().time()))
        return True

    async def stop() -> None:
        if await at(faults.stop_s):
            await stage.bridge.latch("pressed in the campaign")
            if await at(faults.reset_s):
                await stage.bridge.reset()

    async def pause() -> None:
        if await at(faults.pause_s):
            with contextlib.suppress(MeshError):
                await missions.pause(mission_id)
        if await at(faults.resume_s):
            with contextlib.suppress(MeshError):
                await missions.resume(mission_id)

    async def cancel() -> None:
        if await at(faults.cancel_s):
            with contextlib.suppress(MeshError):
                await missions.cancel(mission_id)

    await asyncio.gather(stop(), pause(), cancel())


async def _ended(task: "asyncio.Task[None] | asyncio.Future[None]") -> None:
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task
