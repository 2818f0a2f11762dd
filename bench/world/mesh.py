"""The four services and the robot in one process, wired as `make demo` wires them."""

import asyncio
import contextlib
from collections import Counter
from collections.abc import AsyncGenerator, Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from fastapi import FastAPI

from bench.world.bus import WorldBus
from bench.world.clock import SimulatedClock
from bench.world.line import Line
from bench.world.robot import WorldRobot
from bench.world.troubles import RobotTroubles
from bench.world.wire import Served, Wire, living, open_socket
from coordinator.adapters.inference import InferenceClient
from coordinator.adapters.memory import MemoryClient
from coordinator.adapters.robot_bridge import RobotBridgeClient
from coordinator.app import create_app as create_coordinator
from coordinator.commands.mission_service import MissionService
from coordinator.settings import Settings as CoordinatorSettings
from inference.adapters.bridge_camera import BridgeCamera
from inference.app import create_app as create_inference
from inference.perception.models import Loaded
from inference.settings import Settings as InferenceSettings
from memory.adapters.robot_bridge import RobotBridge
from memory.app import create_app as create_memory
from memory.settings import Settings as MemorySettings
from mesh.http import ServiceClient
from robot_bridge.app import create_app as create_bridge
from robot_bridge.settings import Settings as BridgeSettings
from sim.world import OccupancyGrid, World

URL = "http://service"


@dataclass(frozen=True)
class MeshSettings:
    """Of every service; what lies on the robot's disk is put into `disk`."""

    disk: Path
    coordinator: CoordinatorSettings = field(default_factory=CoordinatorSettings)
    inference: InferenceSettings = field(default_factory=InferenceSettings)
    memory: MemorySettings = field(default_factory=MemorySettings)
    bridge: BridgeSettings = field(default_factory=BridgeSettings)


class Process:
    """A service of the mesh, which may die and begin anew from what is on its disk."""

    def __init__(self, name: str, make: Callable[[], FastAPI], calls: Counter[str], line: Line) -> None:
        self.served = Served(name, make(), {}, calls)
        self._make = make
        self._line = line
        self._begun, self._over = asyncio.Event(), asyncio.Event()
        self._life: asyncio.Task[None] | None = None

    async def begin(self) -> None:
        """Raises whatever keeps it from starting."""
        if self._life is not None:
            self.served.app = self._make()
        self._line.dead.discard(self.served.name)
        self._begun, self._over = asyncio.Event(), asyncio.Event()
        self._life = asyncio.create_task(self._live(self._begun, self._over), name=f"process-{self.served.name}")
        begun = asyncio.create_task(self._begun.wait())
        await asyncio.wait((self._life, begun), return_when=asyncio.FIRST_COMPLETED)
        begun.cancel()
        if self._life.done():
            self._life.result()

    async def end(self) -> None:
        """In order, as by SIGTERM."""
        self._over.set()
        if self._life is not None:
            await self._life

    async def die(self) -> None:
        """As by SIGKILL to whoever it talks with: connections break, and nothing it still says arrives."""
        self._line.dead.add(self.served.name)
        await self.end()

    async def _live(self, begun: asyncio.Event, over: asyncio.Event) -> None:
        async with living(self.served):
            begun.set()
            await over.wait()


@dataclass
class Mesh:
    """A running mesh. `died` names the background tasks that ended."""

    robot: WorldRobot
    bus: WorldBus
    line: Line
    processes: Mapping[str, Process]
    calls: Counter[str]
    died: list[str]

    @property
    def bridge(self) -> Served:
        return self.processes["robot_bridge"].served

    @property
    def inference(self) -> Served:
        return self.processes["inference"].served

    @property
    def memory(self) -> Served:
        return self.processes["memory"].served

    @property
    def missions(self) -> MissionService:
        """Of the coordinator that lives now."""
        return self.processes["coordinator"].served.state["missions"]

    def client(self, of: Served) -> ServiceClient:
        """Of a tool beside the mesh, which reaches it over a line of its own."""
        return ServiceClient(of.name, URL, timeout_s=30.0, transport=Wire("bench", of))


@contextlib.asynccontextmanager
async def open_mesh(
    world: World,
    recorded: OccupancyGrid,
    models: Loaded,
    settings: MeshSettings,
    *,
    line: Line | None = None,
    troubles: RobotTroubles | None = None,
) -> AsyncGenerator[Mesh]:
    """`models` are loaded once a process; everything else begins anew. `line` and `troubles`: what goes wrong."""
    died: list[str] = []
    line = line or Line()

    def dies(name: str) -> None:
        died.append(name)

    bus, clock, calls, disk = WorldBus(line), SimulatedClock(), Counter[str](), settings.disk
    robot = WorldRobot(world, recorded, on_death=partial(dies, "the robot"), troubles=troubles)
    remembering = settings.memory.model_copy(update={"database_url": f"sqlite:///{disk}/memory.db"})
    deciding = settings.coordinator.model_copy(update={"database_url": f"sqlite:///{disk}/coordinator.db"})
    processes: dict[str, Process] = {}

    def wire(caller: str, to: str) -> Wire:
        return Wire(caller, processes[to].served, line)

    def bridge() -> FastAPI:
        return create_bridge(
            settings.bridge.model_copy(update={"state_dir": disk}),
            bus=bus, robot=robot, clock=clock, on_death=partial(dies, "robot_bridge"),
        )  # fmt: skip

    def inference() -> FastAPI:
        return create_inference(
            settings.inference,
            bus=bus, camera=BridgeCamera(URL, transport=wire("inference", "robot_bridge")), models=lambda: models,
            clock=clock, on_death=partial(dies, "inference"),
        )  # fmt: skip

    def memory() -> FastAPI:
        return create_memory(
            remembering, bus=bus, clock=clock, on_death=partial(dies, "memory"),
            senses=RobotBridge(
                URL, clock, timeout_s=remembering.senses_timeout_s, transport=wire("memory", "robot_bridge")
            ),
        )  # fmt: skip

    def coordinator() -> FastAPI:
        return create_coordinator(
            deciding, bus=bus, clock=clock, on_death=partial(dies, "coordinator"),
            robot=RobotBridgeClient(
                deciding, transport=wire("coordinator", "robot_bridge"),
                open_socket=partial(open_socket, processes["robot_bridge"].served),
            ),
            inference=InferenceClient(deciding, transport=wire("coordinator", "inference")),
            memory=MemoryClient(deciding, transport=wire("coordinator", "memory")),
        )  # fmt: skip

    makers = {"robot_bridge": bridge, "inference": inference, "memory": memory, "coordinator": coordinator}
    async with contextlib.AsyncExitStack() as stack:
        stack.push_async_callback(robot.end)
        for name, make in makers.items():
            processes[name] = Process(name, make, calls, line)
            await processes[name].begin()
            stack.push_async_callback(processes[name].end)
        yield Mesh(robot, bus, line, processes, calls, died)
