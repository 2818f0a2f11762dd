"""The simulated robot as a ROS 2 participant: opens ROS, joins World and interfaces, and closes it all again."""

import threading
from collections.abc import Callable
from typing import Final

import rclpy
import structlog
from rclpy.executors import Executor, ExternalShutdownException, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import try_shutdown

from contracts.geometry import Pose2D
from mesh.dds import use_mesh_profile
from sim.ros.lifecycle import LOCALISER, make_lifecycle
from sim.ros.mapping import Mapping
from sim.ros.nav2_stand_in import Nav2StandIn
from sim.ros.realtime import Duty, RealTime
from sim.ros.robot import RobotInterface
from sim.settings import SimSettings
from sim.world import OccupancyGrid, Scan, World
from sim.world.arm.models import ARMS

log = structlog.get_logger()

_THREADS: Final = 6
"""One each for two navigation goals (the newer ends the older), dock, undock, lights, and everything short."""
_ARM_THREADS: Final = 3
"""Two trajectories (the newer ends the older), and the gripper."""


class SimulatedRobot:
    """`open` returns at once; the World is built and run in a thread of its own, ROS callbacks in others."""

    def __init__(self, settings: SimSettings, make_world: Callable[[], World]) -> None:
        self._settings = settings
        self.realtime = RealTime(make_world, self._set_up)
        self.interface: RobotInterface | None = None
        self._stand_in: Nav2StandIn | None = None
        self._nodes: list[Node] = []
        self._executors: list[Executor] = []
        self._spinning: list[threading.Thread] = []
        self._on_death: Callable[[], None] = lambda: None
        self.error: Exception | None = None

    def open(self, *, on_death: Callable[[], None]) -> None:
        """`on_death` is called from another thread when the World or the ROS side ends by an error."""
        self._on_death = on_death
        use_mesh_profile()
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        threads = _THREADS + (_ARM_THREADS if self._settings.arm in ARMS else 0)
        busy, quiet = MultiThreadedExecutor(threads), SingleThreadedExecutor()
        self._executors = [busy, quiet]

        def lifecycle_node(name: str, *, parameter_services: bool = False) -> Node:
            """Asked rarely: in a thread of their own they do not slow those down that are always busy."""
            return self._node(name, quiet, parameter_services=parameter_services)

        robot = self._node("turtlebot4_sim", busy)
        self.interface = RobotInterface(robot, self._settings, self.realtime)
        make_lifecycle(lifecycle_node, LOCALISER, active=True, ready=self.realtime.running.is_set)
        if self._settings.nav2_stand_in:
            nav2 = self._node("nav2_stand_in", busy)
            self._stand_in = Nav2StandIn(nav2, self._settings, self.realtime, self._pose, lifecycle_node)
        self._spinning = [threading.Thread(target=self._spin, args=(each,), name="ros") for each in self._executors]
        for thread in self._spinning:
            thread.start()
        self.realtime.start(on_death=on_death)

    def close(self) -> None:
        """Ends goals, the World and ROS, in this order. May be called after a failed `open`."""
        for part in (self.interface, self._stand_in):
            if part is not None:
                part.closing.set()
        self.realtime.stop()
        for executor in self._executors:
            executor.shutdown(timeout_sec=2.0)
        for node in self._nodes:
            node.destroy_node()
        try_shutdown()
        for thread in self._spinning:
            thread.join(timeout=3.0)

    @property
    def died(self) -> bool:
        return self.reason is not None

    @property
    def reason(self) -> Exception | None:
        """The error that ended it, in the World or on the ROS side."""
        return self.error or self.realtime.error

    def last_audio(self) -> tuple[tuple[int, float], ...]:
        """(Hz, s) of each note of the newest tune on `cmd_audio`."""
        return self.interface.last_audio if self.interface is not None else ()

    def _node(self, name: str, executor: Executor, *, parameter_services: bool = False) -> Node:
        node = Node(
            name,
            namespace=self._settings.namespace,
            start_parameter_services=parameter_services,
            enable_rosout=False,
        )
        self._nodes.append(node)
        executor.add_node(node)
        return node

    def _pose(self) -> Pose2D:
        assert self.interface is not None
        return self.interface.pose

    def _set_up(self, world: World) -> list[Duty]:
        """In the World's thread, once."""
        assert self.interface is not None
        interface, stand_in = self.interface, self._stand_in
        mapping = Mapping(self._take_map) if self._settings.mapping else None
        grid = world.grid if mapping is None else mapping.begin(world, world.localization().pose)
        if stand_in is not None:
            stand_in.open(grid)

        def on_scan(scan: Scan, laser: Pose2D) -> None:
            if mapping is not None:
                mapping.on_scan(scan, laser)
            if stand_in is not None:
                stand_in.on_scan(scan, laser)

        def on_control(world: World, stamp_ns: int) -> None:
            if stand_in is not None:
                stand_in.on_control(world, stamp_ns)

        duties = interface.duties(world, grid, on_scan=on_scan, on_control=on_control)
        return duties if mapping is None else [*duties, mapping.duty()]

    def _take_map(self, grid: OccupancyGrid, stamp_ns: int) -> None:
        assert self.interface is not None
        self.interface.publish_map(grid, stamp_ns)
        if self._stand_in is not None:
            self._stand_in.take_map(grid)

    def _spin(self, executor: Executor) -> None:
        try:
            executor.spin()
        except ExternalShutdownException:
            return
        except Exception as error:
            log.exception("the ROS side died")
            self.error = error
            self._on_death()
