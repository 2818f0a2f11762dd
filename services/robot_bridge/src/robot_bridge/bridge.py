"""Everything the routes need, put together once: senses, wheels, sessions, navigation, camera, and their loops."""

import asyncio
import contextlib
from collections import deque
from collections.abc import AsyncGenerator, Sequence
from dataclasses import dataclass

import structlog

from contracts.arm import ArmEnd
from contracts.causes import GoalCause
from contracts.description import RobotDescription
from contracts.motion import BaseEnd
from contracts.obstacles import Obstacles
from contracts.problem import Dependency
from contracts.robot import BaseStopState, Goal, RobotState
from contracts.topics import ROBOT_DESCRIPTION, ROBOT_NAVIGATION, ROBOT_STATE
from mesh.bus import Bus, redis_dependency
from mesh.clock import Clock
from mesh.errors import UnavailableError
from mesh.metrics import Rounds
from mesh.tasks import Tasks
from mesh.tracing import Tracer, following, traceparent
from robot_bridge.arm.arm_service import ArmService
from robot_bridge.arm.port import RobotArm
from robot_bridge.emergency_stop_service import EmergencyStopService
from robot_bridge.motion.first_twist import tell_first_twist
from robot_bridge.motion.motions import Motion, Tuning
from robot_bridge.motion.run_motion import R, run_motion
from robot_bridge.motion.sessions import Sessions
from robot_bridge.motion.velocity_mux import VelocityMux
from robot_bridge.navigation.docking import Docking
from robot_bridge.navigation.goal_executor import GoalExecutor
from robot_bridge.navigation.map_book import MapBook
from robot_bridge.navigation.recovery import Recovery
from robot_bridge.ports import LiveView, Robot
from robot_bridge.recording.feed import Feed
from robot_bridge.recording.recordings import Recordings
from robot_bridge.safety.emergency_stop import LatchFile, StopHistory
from robot_bridge.safety.obstacles import obstacles
from robot_bridge.sensing import health
from robot_bridge.sensing.camera import Camera
from robot_bridge.sensing.camera_file import CameraFile
from robot_bridge.sensing.object_localizer import ObjectLocalizer
from robot_bridge.sensing.sensor_readings import Scan
from robot_bridge.sensing.snapshot import Snapshot, take_snapshot
from robot_bridge.settings import Settings

log = structlog.get_logger()


TRACER = Tracer(__name__)

NAVIGATION_EVENTS_MAX = 200
TICK_AGE_S_MAX = 0.5
MOTION_S_MAX = 60.0
"""No turn and no drive takes longer."""


@dataclass(slots=True)
class Bridge:
    """The running service. Made by `open_bridge`."""

    settings: Settings
    robot: Robot
    bus: Bus
    clock: Clock
    tasks: Tasks
    sessions: Sessions
    wheels: VelocityMux
    goals: GoalExecutor
    camera: Camera
    emergency_stop: EmergencyStopService
    tuning: Tuning
    docking: Docking
    arm: ArmService
    maps: MapBook
    recordings: Recordings
    measuring: ObjectLocalizer
    camera_file: CameraFile
    celebrated_s: float | None = None

    def end_session(self, session_id: str) -> None:
        """All that was bound to it ends at once."""
        self.sessions.end(session_id)
        self.wheels.end_session(session_id)
        self.session_ended(session_id)

    def session_ended(self, session_id: str) -> None:
        """What Nav2 and the base do for it ends; the wheels have let go already."""
        self.goals.end_session(session_id)
        self.docking.end_session(session_id)
        self.arm.end_session(session_id)

    async def move(self, motion: Motion[R], *, name: str, epoch: int, session_id: str | None) -> R:
        """Runs a closed-loop motion to its end. Cancelled with the awaiting task."""
        with TRACER.command(name) as span:
            begun_s = self.clock.now_s()
            tell_first_twist(self.tasks, self.wheels, span, source=name, since_s=begun_s, within_s=MOTION_S_MAX)
            return await run_motion(self.wheels, motion, name=name, epoch=epoch, session_id=session_id)

    def state(self) -> RobotState:
        """What `GET /state` and the topic tell."""
        now = self.snapshot()
        commanded = self.wheels.commanded.value
        odometry, dock = now.odometry, now.dock
        values: dict[str, object] = {}
        if odometry is not None:
            values |= {"odometry": odometry.pose, "twist": odometry.twist}
        if commanded is not None:
            values |= {"commanded": commanded.twist, "commanded_by": commanded.source}
        if dock is not None:
            values |= {"docked": dock.is_docked, "dock_visible": dock.dock_visible}
        return RobotState.model_validate(
            values
            | {
                "stamp_s": now.taken_s,
                "pose": now.pose,
                "battery": now.battery,
                "dock": self.docking.dock_pose,
                "map_id": current.id if (current := self.maps.current) is not None else None,
                "navigation": self.goals.state,
                "goal_id": self.goals.goal_id,
                "emergency_stop": self.wheels.stop_state,
                "base_stop": self.robot.senses.base_stop.value or BaseStopState.UNKNOWN,
                "hazards": tuple(sorted(now.hazards)),
                "sensors": now.sensors,
                "stale": now.stale,
            }
        )

    def description(self) -> RobotDescription:
        """The settings' body, with the camera as it tells itself, or told itself last.

        Raises `UnavailableError` where it never has.
        """
        settings = self.settings
        try:
            camera = self.measuring.camera()
        except UnavailableError:
            if (camera := self.camera_file.camera) is None:
                raise
        return RobotDescription(
            footprint_radius_m=settings.footprint_radius_m,
            speed_m_s_max=settings.speed_m_s_max,
            turn_rad_s_max=settings.turn_rad_s_max,
            camera=camera,
            depth_noise=settings.depth_noise,
        )

    def snapshot(self) -> Snapshot:
        """Every sensor, now."""
        return take_snapshot(self.robot.senses, self.settings, self.clock.now_s())

    def obstacles(self) -> Obstacles:
        """What stands round the robot. Raises `UnavailableError` while the laser is silent."""
        return obstacles(self.scan(), self.settings)

    def scan(self) -> Scan:
        """The newest; raises `UnavailableError` while the laser is silent."""
        if (scan := self.snapshot().scan) is None:
            raise UnavailableError("scan", self.robot.senses.reception.why_none("scan", "the laser is silent"))
        return scan

    def dependencies(self) -> Sequence[Dependency]:
        """Is data flowing? One line each."""
        tick_age_s = self.wheels.commanded.age_s(self.clock.now_s())
        spinning = tick_age_s is not None and tick_age_s <= TICK_AGE_S_MAX
        unstored = self.emergency_stop.unstored
        return [
            Dependency.of("rclpy", ok=spinning, detail=health.age(tick_age_s)),
            *health.dependencies(self.robot.senses, self.settings.ros.cmd_vel_known, self.snapshot()),
            *self.arm.dependencies(),
            Dependency.of("latch", ok=not unstored, detail=unstored or "on disk"),
            redis_dependency(self.bus),
        ]

    async def publish_state(self) -> None:
        rounds = Rounds("robot_state")
        while True:
            rounds.turn()
            await self.bus.publish(ROBOT_STATE, self.state())
            await self.clock.sleep(0.1)

    async def publish_description(self) -> None:
        """Only once it is whole: what another service knows is never less than before."""
        while True:
            with contextlib.suppress(UnavailableError):
                description = self.description()
                self.camera_file.keep(description.camera)
                await self.bus.publish(ROBOT_DESCRIPTION, description)
            await self.clock.sleep(1.0)


class NavigationEvents:
    """Changes of goals on their way to the bus: in order, the oldest dropped where the bus is away for long."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[Goal, str]] = deque(maxlen=NAVIGATION_EVENTS_MAX)
        self._some = asyncio.Event()

    def put(self, goal: Goal) -> None:
        self._waiting.append((goal, traceparent()))
        self._some.set()

    async def publish(self, bus: Bus) -> None:
        while True:
            await self._some.wait()
            self._some.clear()
            while self._waiting:
                goal, said_in = self._waiting.popleft()
                with following(said_in):
                    await bus.publish(ROBOT_NAVIGATION, goal)


@contextlib.asynccontextmanager
async def open_bridge(
    settings: Settings,
    robot: Robot,
    bus: Bus,
    clock: Clock,
    tasks: Tasks,
    *,
    live_view: LiveView | None = None,
    arm: RobotArm | None = None,
) -> AsyncGenerator[Bridge]:
    """Latched as it was left, connected to the robot, loops running; shown on `live_view`, where there is one.

    At its end zeros go out first, its last word: what is still to be written is no reason to drive on.
    """
    latch = LatchFile(settings.state_dir)
    stop = latch.load(now_s=clock.now_s())
    sessions = Sessions(timeout_s=settings.session_timeout_s)
    senses = robot.senses
    wheels = VelocityMux(
        senses=senses,
        sessions=sessions,
        clock=clock,
        stop=stop,
        limits=settings,
    )
    events = NavigationEvents()
    tuning = Tuning(settings.gains)
    navigator = GoalExecutor(
        robot=robot,
        wheels=wheels,
        recovery=Recovery(senses=senses, wheels=wheels, clock=clock, tuning=tuning, limits=settings),
        clock=clock,
        tasks=tasks,
        limits=settings,
        publish=events.put,
    )
    maps = MapBook(settings.state_dir, senses.map, clock)
    docking = Docking(
        robot=robot,
        wheels=wheels,
        navigator=navigator,
        maps=maps,
        clock=clock,
        state_dir=settings.state_dir,
        limits=settings,
    )

    arm_service = ArmService(arm, wheels=wheels, clock=clock, limits=settings)

    def end_what_moves(goal: GoalCause, base: BaseEnd) -> None:
        arm_service.stop(ArmEnd.STOPPED if base is BaseEnd.STOPPED else ArmEnd.CANCELED)
        navigator.stop(goal)
        docking.stop(base)

    stopping = EmergencyStopService(
        wheels=wheels,
        robot=robot,
        on_stop=end_what_moves,
        latch=latch,
        history=StopHistory(settings.state_dir),
        clock=clock,
    )
    bridge = Bridge(
        settings=settings,
        robot=robot,
        bus=bus,
        clock=clock,
        tasks=tasks,
        sessions=sessions,
        wheels=wheels,
        goals=navigator,
        camera=Camera(senses.rgb, jpeg_quality=settings.jpeg_quality),
        emergency_stop=stopping,
        tuning=tuning,
        docking=docking,
        arm=arm_service,
        maps=maps,
        measuring=ObjectLocalizer(senses, clock, settings),
        recordings=Recordings(
            robot=robot,
            bus=bus,
            clock=clock,
            tasks=tasks,
            folder=settings.recordings_dir or settings.state_dir / "recordings",
            limits=settings,
        ),
        camera_file=CameraFile(settings.state_dir),
    )
    wheels.connect(loop=asyncio.get_running_loop(), send=robot.send_velocity, on_session_ended=bridge.session_ended)
    await robot.start(tick=wheels.tick, navigation_velocity=wheels.navigation_velocity)
    shown: Feed | None = None
    try:
        stopping.restore()
        tasks.start("publish-state", bridge.publish_state())
        tasks.start("publish-description", bridge.publish_description())
        tasks.start("watch-base-stop", stopping.watch_base())
        tasks.start("publish-stop", stopping.publish(bus))
        tasks.start("keep-stop", stopping.persist_forever())
        tasks.start("publish-navigation", events.publish(bus))
        tasks.start("name-map", maps.watch())
        tasks.start("watch-dock", bridge.docking.watch())
        bridge.arm.start(tasks)
        if live_view is not None:
            images_hz = settings.foxglove_images_hz
            shown = Feed(
                "show", robot=robot, bus=bus, clock=clock, tasks=tasks, sink=live_view.show, images_hz=images_hz
            )
        yield bridge
    finally:
        arm_service.stop(ArmEnd.SHUT_DOWN)
        navigator.stop(GoalCause.SHUT_DOWN)
        wheels.shut_down()
        await stopping.save()
        if shown is not None:
            shown.close()
        await bridge.recordings.close()  # the slowest: a supervisor may not wait for it
        await robot.close()
