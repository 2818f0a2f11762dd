"""The four services and the robot in one process, wired as `make demo` wires them."""

import contextlib
from collections import Counter
from collections.abc import AsyncGenerator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from bench.world.bus import WorldBus
from bench.world.clock import SimulatedClock
from bench.world.robot import WorldRobot
from bench.world.wire import Served, Wire, open_socket, served
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


@dataclass
class Mesh:
    """A running mesh. `died` names the background tasks that ended."""

    robot: WorldRobot
    bus: WorldBus
    bridge: Served
    inference: Served
    memory: Served
    missions: MissionService
    calls: Counter[str]
    died: list[str]

    def client(self, of: Served) -> ServiceClient:
        """Of a tool beside the mesh."""
        return ServiceClient(of.name, URL, timeout_s=30.0, transport=Wire("bench", of))


@contextlib.asynccontextmanager
async def open_mesh(
    world: World, recorded: OccupancyGrid, models: Loaded, settings: MeshSettings
) -> AsyncGenerator[Mesh]:
    """`models` are loaded once a process; everything else begins anew."""
    died: list[str] = []

    def dies(name: str) -> None:
        died.append(name)

    bus, clock, calls, disk = WorldBus(), SimulatedClock(), Counter[str](), settings.disk
    robot = WorldRobot(world, recorded, on_death=partial(dies, "the robot"))
    async with contextlib.AsyncExitStack() as stack:
        bridge = await stack.enter_async_context(
            served(
                "robot_bridge",
                create_bridge(
                    settings.bridge.model_copy(update={"state_dir": disk}),
                    bus=bus, robot=robot, clock=clock, on_death=partial(dies, "robot_bridge"),
                ),
                calls,
            )
        )  # fmt: skip
        inference = await stack.enter_async_context(
            served(
                "inference",
                create_inference(
                    settings.inference,
                    bus=bus, camera=BridgeCamera(URL, transport=Wire("inference", bridge)), models=lambda: models,
                    clock=clock, on_death=partial(dies, "inference"),
                ),
                calls,
            )
        )  # fmt: skip
        remembering = settings.memory.model_copy(update={"database_url": f"sqlite:///{disk}/memory.db"})
        memory = await stack.enter_async_context(
            served(
                "memory",
                create_memory(
                    remembering, bus=bus, clock=clock, on_death=partial(dies, "memory"),
                    senses=RobotBridge(
                        URL, clock, timeout_s=remembering.senses_timeout_s, transport=Wire("memory", bridge)
                    ),
                ),
                calls,
            )
        )  # fmt: skip
        deciding = settings.coordinator.model_copy(update={"database_url": f"sqlite:///{disk}/coordinator.db"})
        coordinator = await stack.enter_async_context(
            served(
                "coordinator",
                create_coordinator(
                    deciding, bus=bus, clock=clock, on_death=partial(dies, "coordinator"),
                    robot=RobotBridgeClient(
                        deciding, transport=Wire("coordinator", bridge), open_socket=partial(open_socket, bridge)
                    ),
                    inference=InferenceClient(deciding, transport=Wire("coordinator", inference)),
                    memory=MemoryClient(deciding, transport=Wire("coordinator", memory)),
                ),
                calls,
            )
        )  # fmt: skip
        yield Mesh(robot, bus, bridge, inference, memory, coordinator.state["missions"], calls, died)
