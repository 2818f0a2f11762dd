"""Everything the routes need, put together once: senses, wheels, sessions, navigation, camera, and their loops."""

import asyncio
import contextlib
from collections import deque
from collections.abc import AsyncGenerator, Sequence
from dataclasses import dataclass

import structlog

from contracts.problem import Dependency
from contracts.robot import EmergencyStop, Goal, MotionReply, RobotState, SensorStatus
from contracts.topics import ROBOT_EMERGENCY_STOP, ROBOT_NAVIGATION, ROBOT_OBSTACLES, ROBOT_STATE
from mesh.bus import Bus
from mesh.clock import Clock
from mesh.tasks import Tasks
from robot_bridge.arbiter import Limits
from robot_bridge.camera import Camera
from robot_bridge.emergency_stop import LatchFile
from robot_bridge.motion import Gains, Motion
from robot_bridge.navigator import Navigator
from robot_bridge.obstacles import obstacles
from robot_bridge.ports import Robot
from robot_bridge.safety import SafetyLimits
from robot_bridge.sessions import Sessions
from robot_bridge.settings import Settings
from robot_bridge.wheels import Running, Wheels

log = structlog.get_logger()

NAVIGATION_EVENTS_MAX = 200
TICK_AGE_S_MAX = 0.5


@dataclass(slots=True)
class Bridge:
    """The running service. Made by `open_bridge`."""

    settings: Settings
    robot: Robot
    bus: Bus
    clock: Clock
    tasks: Tasks
    sessions: Sessions
    wheels: Wheels
    navigator: Navigator
    camera: Camera
    gains: Gains
    latch: LatchFile
    stop_changed: asyncio.Event
    celebrated_s: float | None = None

    def emergency_stop(self, *, reason: str, by: str) -> tuple[EmergencyStop, float]:
        """Zeros first; then the latch on disk, Nav2's goals and the base's own stop, none of them waited for."""
        state, first_zero_ms = self.wheels.stop(reason=reason, by=by)
        self.robot.engage_base_stop(True)
        self.robot.cancel_all_goals()
        self.navigator.stop("emergency stop")
        self.store_latch(state)
        log.warning("emergency stop", reason=reason, by=by, epoch=state.epoch, first_zero_ms=round(first_zero_ms, 3))
        return state, first_zero_ms

    def explain_emergency_stop(self, epoch: int, *, reason: str, by: str) -> EmergencyStop:
        """Who and why, told after the fact: the stop itself has not waited for it."""
        state = self.wheels.explain_stop(epoch, reason=reason, by=by)
        self.store_latch(state)
        return state

    def reset_emergency_stop(self, *, reason: str, by: str) -> EmergencyStop:
        """Permits motion. A crash before the file is replaced leaves the next process latched: the safe side."""
        state = self.wheels.reset(reason=reason, by=by)
        self.robot.engage_base_stop(False)
        self.store_latch(state)
        log.warning("emergency stop reset", reason=reason, by=by, epoch=state.epoch)
        return state

    def end_session(self, session_id: str) -> None:
        """All that was bound to it ends at once."""
        self.sessions.end(session_id)
        self.wheels.end_session(session_id)
        self.navigator.end_session(session_id)

    async def move(self, motion: Motion, *, name: str, epoch: int, session_id: str | None) -> MotionReply:
        """Runs a closed-loop motion to its end. Cancelled with the awaiting task."""
        loop = asyncio.get_running_loop()
        reply: asyncio.Future[MotionReply] = loop.create_future()

        def settle(value: MotionReply) -> None:
            if not reply.done():
                reply.set_result(value)

        def done(value: MotionReply) -> None:  # called by the robot's thread
            loop.call_soon_threadsafe(settle, value)

        self.wheels.begin(Running(motion, name, epoch, session_id, done))
        try:
            return await reply
        except asyncio.CancelledError:
            self.wheels.end_motion("the client went away")
            raise

    def state(self) -> RobotState:
        """What `GET /state` and the topic tell."""
        now_s, senses = self.clock.now_s(), self.robot.senses
        odometry, commanded = senses.odometry.value, self.wheels.commanded.value
        hazards = senses.hazards.newest
        held = hazards is not None and now_s - hazards.received_s <= self.settings.hazard_hold_s
        pose_age_s = senses.poses.age_s(now_s)
        values: dict[str, object] = {
            "pose": senses.poses.newest() if pose_age_s is not None else None,
            "odometry": odometry.pose if odometry else None,
            "battery": senses.battery.value,
            "docked": senses.docked.value,
        }
        if odometry is not None:
            values["twist"] = odometry.twist
        if commanded is not None:
            values |= {"commanded": commanded.twist, "commanded_by": commanded.source}
        return RobotState.model_validate(
            values
            | {
                "stamp_s": now_s,
                "navigation": self.navigator.state,
                "goal_id": self.navigator.goal_id,
                "emergency_stop": self.wheels.stop_state,
                "hazards": tuple(sorted(hazards.value)) if hazards is not None and held else (),
                "sensors": self.sensors(now_s),
            }
        )

    def sensors(self, now_s: float) -> dict[str, SensorStatus]:
        senses, settings = self.robot.senses, self.settings
        ages: dict[str, tuple[float | None, float]] = {
            "scan": (senses.scan.age_s(now_s), settings.scan_age_s_max),
            "odom": (senses.odometry.age_s(now_s), settings.odometry_age_s_max),
            "rgb": (senses.rgb.age_s(now_s), settings.image_age_s_max),
            "depth": (senses.depth.age_s(now_s), settings.image_age_s_max),
            "pose": (senses.poses.age_s(now_s), settings.pose_age_s_max),
            "map": (senses.map.age_s(now_s), float("inf")),
            "battery": (senses.battery.age_s(now_s), settings.battery_age_s_max),
        }
        return {
            name: SensorStatus(valid=age_s is not None and age_s <= age_s_max, age_s=age_s)
            for name, (age_s, age_s_max) in ages.items()
        }

    def dependencies(self) -> Sequence[Dependency]:
        """Is data flowing? One line each."""
        now_s = self.clock.now_s()
        tick_age_s = self.wheels.commanded.age_s(now_s)
        spinning = tick_age_s is not None and tick_age_s <= TICK_AGE_S_MAX
        found = [Dependency(name="rclpy", ok=spinning, detail=_age(tick_age_s))]
        found += [
            Dependency(name=name, ok=status.valid, detail=_age(status.age_s))
            for name, status in self.sensors(now_s).items()
            if name != "battery"
        ]
        missing = self.robot.senses.why_no_nav2(now_s)
        found.append(Dependency(name="nav2", ok=not missing, detail=missing or "active"))
        redis = self.bus.connected
        found.append(Dependency(name="redis", ok=redis, detail="connected" if redis else "away"))
        return found

    def store_latch(self, state: EmergencyStop) -> None:
        """At once for the process, soon for the disk; a full disk must not stop the stop."""
        try:
            self.latch.store(state)
        except OSError as error:  # a traceback would cost the stop request a second
            log.error("the emergency stop could not be stored", error=str(error))  # noqa: TRY400
        else:
            self.tasks.start("latch-sync", asyncio.to_thread(self._sync), forever=False)
        self.stop_changed.set()

    def _sync(self) -> None:
        with contextlib.suppress(OSError):
            self.latch.sync()

    async def publish_state(self) -> None:
        while True:
            await self.bus.publish(ROBOT_STATE, self.state())
            await self.clock.sleep(0.1)

    async def publish_obstacles(self) -> None:
        last_s = 0.0
        while True:
            after_s = last_s
            reading = await self.robot.senses.scan.wait_for(lambda scan: scan.received_s > after_s, 5.0)  # noqa: B023
            if reading is not None:
                last_s = reading.received_s
                message = obstacles(reading.value, safety_limits(self.settings), self.clock.now_s())
                await self.bus.publish(ROBOT_OBSTACLES, message)

    async def publish_stop(self) -> None:
        """On every change, and every second: the key must be there when Redis comes back empty."""
        while True:
            self.stop_changed.clear()
            await self.bus.publish(ROBOT_EMERGENCY_STOP, self.wheels.stop_state)
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self.stop_changed.wait(), 1.0)


class NavigationEvents:
    """Changes of goals on their way to the bus: in order, the oldest dropped where the bus is away for long."""

    def __init__(self) -> None:
        self._waiting: deque[Goal] = deque(maxlen=NAVIGATION_EVENTS_MAX)
        self._some = asyncio.Event()

    def put(self, goal: Goal) -> None:
        self._waiting.append(goal)
        self._some.set()

    async def publish(self, bus: Bus) -> None:
        while True:
            await self._some.wait()
            self._some.clear()
            while self._waiting:
                await bus.publish(ROBOT_NAVIGATION, self._waiting.popleft())


def safety_limits(settings: Settings) -> SafetyLimits:
    return SafetyLimits(
        footprint_radius_m=settings.footprint_radius_m,
        side_margin_m=settings.side_margin_m,
        stop_distance_m=settings.stop_distance_m,
        slow_distance_m=settings.slow_distance_m,
        slow_factor_min=settings.slow_factor_min,
        scan_age_s_max=settings.scan_age_s_max,
        scan_age_to_turn_s_max=settings.scan_age_to_turn_s_max,
        odometry_age_s_max=settings.odometry_age_s_max,
    )


def arbiter_limits(settings: Settings) -> Limits:
    return Limits(
        speed_m_s_max=settings.speed_m_s_max,
        turn_rad_s_max=settings.turn_rad_s_max,
        acceleration_m_s2_max=settings.acceleration_m_s2_max,
        turn_acceleration_rad_s2_max=settings.turn_acceleration_rad_s2_max,
        request_age_s_max=settings.request_age_s_max,
        request_ahead_s_max=settings.request_ahead_s_max,
    )


@contextlib.asynccontextmanager
async def open_bridge(settings: Settings, robot: Robot, bus: Bus, clock: Clock, tasks: Tasks) -> AsyncGenerator[Bridge]:
    """Latched as it was left, connected to the robot, loops running; zeros are the last thing it sends."""
    latch = LatchFile(settings.state_dir)
    stop = latch.load(now_s=clock.now_s())
    sessions = Sessions(timeout_s=settings.session_timeout_s)
    senses = robot.senses
    senses.bind(asyncio.get_running_loop())
    wheels = Wheels(
        senses=senses,
        sessions=sessions,
        clock=clock,
        stop=stop,
        limits=arbiter_limits(settings),
        safety=safety_limits(settings),
        hazard_hold_s=settings.hazard_hold_s,
    )
    events = NavigationEvents()
    navigator = Navigator(robot=robot, wheels=wheels, clock=clock, tasks=tasks, settings=settings, publish=events.put)
    gains = Gains(settings.heading_kp, settings.heading_ki, settings.heading_kd, settings.drive_kp)
    bridge = Bridge(
        settings=settings,
        robot=robot,
        bus=bus,
        clock=clock,
        tasks=tasks,
        sessions=sessions,
        wheels=wheels,
        navigator=navigator,
        camera=Camera(senses.rgb, jpeg_quality=settings.jpeg_quality),
        gains=gains,
        latch=latch,
        stop_changed=asyncio.Event(),
    )
    wheels.connect(loop=asyncio.get_running_loop(), send=robot.send_velocity, on_session_ended=navigator.end_session)
    await robot.start(tick=wheels.tick, navigation_velocity=wheels.navigation_velocity)
    try:
        if stop.latched:
            robot.engage_base_stop(True)
            bridge.store_latch(stop)  # an unreadable file becomes a readable one
        tasks.start("publish-state", bridge.publish_state())
        tasks.start("publish-obstacles", bridge.publish_obstacles())
        tasks.start("publish-stop", bridge.publish_stop())
        tasks.start("publish-navigation", events.publish(bus))
        yield bridge
    finally:
        navigator.stop("robot_bridge is shutting down")
        wheels.silence()
        await robot.close()


def _age(age_s: float | None) -> str:
    return "never received" if age_s is None else f"{age_s:.2f} s old"
