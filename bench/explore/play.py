"""Plays one exploration of a simulated home that nobody has mapped, and writes down what was seen and what happened.

One process on a simulated clock: `sim.World` with its errors, the mapper that stands in for slam_toolbox, the Nav2
stand-in, robot_bridge from its composition root with its own arbiter and safety filter, and the coordinator's
`ExplorationRunner` over robot_bridge's routes. No language model: the pilots of `bench.explore.pilots`.
"""

import math
import random
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.explore.pilots import HostileModel, NobodyToAsk, SensibleModel
from bench.world.bus import WorldBus
from bench.world.clock import TOOK_S, NothingLeftError, SimulatedClock, SpinningError, run_simulated
from bench.world.drawn import drawn_from
from bench.world.line import Line
from bench.world.mesh import URL, Process
from bench.world.robot import WorldRobot
from bench.world.wire import Wire, open_socket
from contracts.exploration import ExplorationMemory, ExplorationMode
from contracts.geometry import Pose2D
from contracts.robot import EmergencyStopRequest
from coordinator.adapters.robot_bridge import RobotBridgeClient
from coordinator.execution.exploration_runner import ExplorationRunner
from coordinator.exploration.commands import AskModel
from coordinator.exploration.rules import ExplorationRules
from coordinator.exploration.views import view_hash
from coordinator.exploration_ports import Pilot, PilotAnswer
from coordinator.settings import Settings as CoordinatorSettings
from geometry.poses import compose
from mesh.errors import UnavailableError
from mesh.tasks import Tasks
from robot_bridge.app import create_app as create_bridge
from robot_bridge.settings import Settings as BridgeSettings
from sim.home import Home
from sim.nav.mapper import Mapper
from sim.world import OccupancyGrid, World
from sim.world.occupancy import reachable
from sim.world.robot import ROBOT_RADIUS_M

STARTED_S = 1_000_000.0
SETTLE_S = 3.0
KILLED_AFTER_S = 60.0
STOPPED_AFTER_S, STOPPED_FOR_S = 90.0, 10.0
STEP_S = 1.0
FEEL_S = 0.05
LIFTED_M = 5.0
LASER_M = 0.14
"""The laser's height above the floor: it sees nothing that is lower."""
MARKS = (0.5, 0.8, 0.9, 0.95)

M = ExplorationMode
POLICIES: dict[str, ExplorationMode] = {
    "sensible": M.MODEL,
    "frontiers": M.FRONTIERS,
    "reactive": M.REACTIVE,
    "hostile": M.MODEL,
    "killed": M.MODEL,
}
"""Who leads; `killed` is the sensible model whose server dies after a minute."""


class KilledModel:
    """Answers for a while; then nobody is there."""

    def __init__(self, clock: SimulatedClock) -> None:
        self._clock, self._model = clock, SensibleModel(clock)
        self._until_s = clock.now_s() + KILLED_AFTER_S

    async def decide(self, question: AskModel) -> PilotAnswer:
        if self._clock.now_s() >= self._until_s:
            raise UnavailableError("model", "connection refused")
        return await self._model.decide(question)


class WorldEye:
    """The newest picture of the simulated camera, rendered when it is asked for."""

    def __init__(self, robot: WorldRobot) -> None:
        self._robot = robot

    async def view(self) -> int | None:
        picture = self._robot.senses.rgb.value
        return view_hash(picture.pixels) if picture is not None else None


@dataclass
class KeptMemory:
    """What was written, newest last."""

    written: int = 0
    last: ExplorationMemory = field(default_factory=ExplorationMemory)

    async def read(self, home: str) -> ExplorationMemory:
        del home
        return self.last

    def write(self, home: str, memory: ExplorationMemory) -> None:
        del home
        self.written += 1
        self.last = memory


@dataclass
class Measured:
    """Ground truth: of the floor that the robot could stand on, how much its map holds, by the second."""

    world: World
    mapper: Mapper
    room: NDArray[np.bool_]
    began_s: float = 0.0
    share: float = 0.0
    reached: dict[float, tuple[float, float]] = field(default_factory=dict[float, tuple[float, float]])
    modes: Counter[str] = field(default_factory=Counter[str])
    touched: Counter[str] = field(default_factory=Counter[str])
    touching: frozenset[str] = frozenset()

    async def feel(self, clock: SimulatedClock) -> None:
        """For ever: what the robot begins to touch, by name."""
        while True:
            now = frozenset(self.world.truth.touching)
            self.touched.update(now - self.touching)
            self.touching = now
            await clock.sleep(FEEL_S)

    def look(self, mode: ExplorationMode) -> None:
        truth = self.world.truth
        self.modes[mode.value] += 1
        grid = self.mapper.grid()
        if grid is None:
            return
        self.share = seen_share(self.world.grid, self.room, grid)
        for mark in MARKS:
            if self.share >= mark and mark not in self.reached:
                self.reached[mark] = (round(truth.stamp_s - self.began_s, 1), round(truth.path_length_m, 2))


def seen_share(recorded: OccupancyGrid, room: NDArray[np.bool_], grown: OccupancyGrid) -> float:
    """Of the cells of `room`, which lie on `recorded`, the share that `grown` knows."""
    rows, columns = np.nonzero(room)
    shift_y = round((recorded.origin_y_m - grown.origin_y_m) / grown.resolution_m)
    shift_x = round((recorded.origin_x_m - grown.origin_x_m) / grown.resolution_m)
    rows, columns = rows + shift_y, columns + shift_x
    height, width = grown.data.shape
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    known = grown.data[rows[inside], columns[inside]] >= 0
    return float(np.count_nonzero(known)) / max(1, len(rows))


def below_the_laser(world: World, name: str) -> bool:
    """Truth: no part of it is as high as the laser."""
    try:
        volumes = world.volumes(name)
    except KeyError:
        return False
    return all(float(volume.corners()[:, 2].max()) < LASER_M for volume in volumes)


def clear_floor(world: World) -> int:
    """Lifts what stands on the floor and is lower than the laser out of the robot's way; how many things that was."""
    low = [
        thing
        for thing in world.truth.things
        if not thing.furniture and thing.z_m < LASER_M and below_the_laser(world, thing.id)
    ]
    for thing in low:
        world.move_thing(thing.id, thing.x_m, thing.y_m, LIFTED_M, 0.0)
    return len(low)


def played(
    home_seed: int, policy: str, *, seed: int = 0, duration_s: float = 900.0, floor_things: bool = False
) -> dict[str, Any]:
    """The record of one exploration. Without `floor_things` nothing stands on the floor that the laser cannot see."""
    began_s = time.process_time()
    with drawn_from(seed), World(Home.generate(home_seed)) as parked:
        start = compose(parked.scene.dock, Pose2D(x=-0.6, y=0.0, yaw=math.pi))
        with World(Home.generate(home_seed), seed=seed, start=start) as world, tempfile.TemporaryDirectory() as disk:
            lifted = 0 if floor_things else clear_floor(world)
            rules = ExplorationRules(pilot=POLICIES[policy], duration_s=duration_s)
            main = partial(_explore, world, start, policy, rules, Path(disk), seed)
            try:
                record = run_simulated(main, start_s=STARTED_S, took_s=TOOK_S)
            except (NothingLeftError, SpinningError) as error:
                record = {"problem": f"hang: {error}"}
    return {
        "home": home_seed, "policy": policy, "seed": seed, "lifted": lifted, **record,
        "cpu_s": round(time.process_time() - began_s, 1),
    }  # fmt: skip


def pilot_of(policy: str, clock: SimulatedClock, seed: int) -> Pilot:
    makers: dict[str, Callable[[], Pilot]] = {
        "sensible": lambda: SensibleModel(clock),
        "hostile": lambda: HostileModel(clock, random.Random(seed)),
        "killed": lambda: KilledModel(clock),
    }
    return makers.get(policy, NobodyToAsk)()


async def _explore(
    world: World, start: Pose2D, policy: str, rules: ExplorationRules, disk: Path, seed: int
) -> dict[str, Any]:
    died, asked = list[str](), Counter[str]()
    clock, bus, line, mapper = SimulatedClock(), WorldBus(Line()), Line(), Mapper()
    nothing = OccupancyGrid(np.full((20, 20), -1, np.int8), 0.05, start.x - 0.5, start.y - 0.5)
    robot = WorldRobot(world, nothing, on_death=lambda: died.append("the robot"), mapper=mapper)
    bridge = Process(
        "robot_bridge",
        lambda: create_bridge(
            BridgeSettings(state_dir=disk), bus=bus, robot=robot, clock=clock,
            on_death=lambda: died.append("robot_bridge"),
        ),
        asked, line,
    )  # fmt: skip
    await bridge.begin()
    client = RobotBridgeClient(
        CoordinatorSettings(robot_bridge_url=URL),
        transport=Wire("coordinator", bridge.served, line),
        open_socket=partial(open_socket, bridge.served),
    )
    measured = Measured(world, mapper, reachable(world.grid, start, ROBOT_RADIUS_M))
    pilot, journal = pilot_of(policy, clock, seed), KeptMemory()
    try:
        async with Tasks(on_death=lambda: died.append("the exploration")) as tasks:
            runner = ExplorationRunner(
                client, pilot, rules=rules, clock=clock, tasks=tasks, journal=journal,
                eye=WorldEye(robot) if rules.pilot is M.MODEL else None,
            )  # fmt: skip
            tasks.start("session", client.hold_session())
            tasks.start("exploration", runner.run())
            tasks.start("touch", measured.feel(clock))
            await clock.sleep(SETTLE_S)
            measured.began_s = world.time_s
            stopped_m = await _watched(world, runner, client, measured, clock, stops=policy == "hostile")
    finally:
        await client.aclose()
        await bridge.end()
        await robot.end()
    told = _told(world, start, runner, pilot, journal, measured, stopped_m, died)
    return {**told, "asked_of_the_bridge": dict(sorted(asked.items()))}


async def _watched(
    world: World,
    runner: ExplorationRunner,
    client: RobotBridgeClient,
    measured: Measured,
    clock: SimulatedClock,
    *,
    stops: bool,
) -> float | None:
    """To its end. With `stops` somebody presses the emergency stop under way, and begins anew afterwards; the metres
    driven while stopped are answered."""
    home = runner.exploration.pose or world.truth.pose
    await runner.begin(home)
    stopped_m = None
    while not runner.ended.is_set():
        await clock.sleep(STEP_S)
        measured.look(runner.exploration.mode)
        if stops and stopped_m is None and world.time_s - measured.began_s >= STOPPED_AFTER_S:
            await client.emergency_stop("the bench presses it")
            await clock.sleep(1.0)
            before_m = world.truth.path_length_m
            await runner.begin(home)
            await clock.sleep(STOPPED_FOR_S)
            stopped_m = world.truth.path_length_m - before_m
            await client.call("POST", "/emergency-stop/reset", body=EmergencyStopRequest(reason="bench", by="bench"))
            await clock.sleep(1.0)
            await runner.begin(home)
    measured.look(runner.exploration.mode)
    return stopped_m


def _told(
    world: World,
    start: Pose2D,
    runner: ExplorationRunner,
    pilot: Pilot,
    journal: KeptMemory,
    measured: Measured,
    stopped_m: float | None,
    died: list[str],
) -> dict[str, Any]:
    one, truth = runner.exploration, world.truth
    return {
        "end": one.end.value if one.end is not None else None,
        "why": one.why,
        "seen": round(measured.share, 4),
        "room_m2": round(float(np.count_nonzero(measured.room)) * 0.05**2, 1),
        "reached": {str(mark): at for mark, at in measured.reached.items()},
        "seconds": round(world.time_s - measured.began_s, 1),
        "metres": round(truth.path_length_m, 2),
        "collisions": truth.collisions,
        "touched": dict(measured.touched),
        "touched_in_sight": {
            name: count for name, count in measured.touched.items() if not below_the_laser(world, name)
        },
        "from_home_m": round(math.hypot(truth.pose.x - start.x, truth.pose.y - start.y), 2),
        "stopped_m": None if stopped_m is None else round(stopped_m, 4),
        "seconds_by_mode": dict(measured.modes),
        "calls": one.spent.calls,
        "tokens": one.spent.tokens,
        "calls_by_reason": {reason.value: count for reason, count in one.spent.by_reason},
        "verdicts": {verdict.value: count for verdict, count in one.verdicts},
        "attacks": pilot.kinds if isinstance(pilot, HostileModel) else {},
        "attacks_read": pilot.read if isinstance(pilot, HostileModel) else {},
        "motions": one.motions,
        "actions": one.memory.actions_done,
        "written": journal.written,
        "given_up": len(one.memory.given_up),
        "died": died,
    }
