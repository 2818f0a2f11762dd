"""robot_bridge's lowest port over the simulated World instead of rclpy: everything above it is the real service."""

import asyncio
from collections.abc import Callable
from typing import Final

from bench.world.sensing import Sensing
from bench.world.troubles import NO_PATH, RobotTroubles
from contracts.geometry import Pose2D, Twist2D
from contracts.robot import GoalStatus
from geometry.poses import compose
from robot_bridge.ports import Celebration, GoalEnd, Path, Sink
from robot_bridge.safety.base_stop import BaseStop
from robot_bridge.sensing.sensor_readings import SensorReadings
from sim.nav.chain import ChainHabits
from sim.nav.codes import NavigationError
from sim.nav.costmap import Costmap
from sim.nav.localiser import Localiser
from sim.nav.mapper import Mapper
from sim.nav.navigator import Navigator, Progress
from sim.ros.behaviour import BaseBehaviours, Behaviour, Ending
from sim.ros.drives import Drive, DriveEnding, Drives, Habits
from sim.settings import SimSettings
from sim.world import OccupancyGrid, World
from sim.world.robot import LIDAR

SLICE_S: Final = 0.025
"""So often the robot's own thread comes round."""
TICK_SLICES: Final = 2
"""The wheels' 20 Hz."""
FEEDBACK_S: Final = 0.2
MAP_EVERY_S: Final = 2.0
"""slam_toolbox's map_update_interval is 5 s as delivered, 2 s in many a robot's configuration."""
STATUSES = {
    DriveEnding.SUCCEEDED: GoalStatus.SUCCEEDED,
    DriveEnding.CANCELED: GoalStatus.CANCELED,
    DriveEnding.ABORTED: GoalStatus.ABORTED,
}


class WorldGoal(Drive):
    """A goal of the Nav2 stand-in that asyncio may await (`ports.AcceptedGoal`)."""

    def __init__(self, goal: Pose2D, on_progress: Callable[[float], None]) -> None:
        super().__init__(goal, lambda: self._canceled)
        self._canceled = False
        self._end: asyncio.Future[GoalEnd] = asyncio.get_running_loop().create_future()
        self._on_progress = on_progress
        self._told_s = 0.0

    def end(self, how: DriveEnding, progress: Progress) -> None:  # type: ignore[override] # Drive's is called by the stand-in
        super().end(how, progress)
        if not self._end.done():
            self._end.set_result(GoalEnd(STATUSES[how], int(progress.code)))

    def feed_back(self, now_s: float) -> None:
        if now_s - self._told_s >= FEEDBACK_S - 1e-6 and self.ending is None:
            self._told_s = now_s
            self._on_progress(float(self.progress.remaining_m))

    def cancel(self) -> None:
        self._canceled = True

    async def ended_as(self) -> GoalEnd:
        return await asyncio.shield(self._end)


class AcceptedWorldGoal:
    """`ports.AcceptedGoal`. `instead`: after so long Nav2 lets go of it and says that it ended so."""

    def __init__(self, drive: WorldGoal, instead: tuple[float, GoalEnd] | None = None) -> None:
        self._drive = drive
        self._instead = instead

    async def end(self) -> GoalEnd:
        if self._instead is None:
            return await self._drive.ended_as()
        after_s, end = self._instead
        try:
            async with asyncio.timeout(after_s):
                return await self._drive.ended_as()
        except TimeoutError:
            self._drive.cancel()
            await self._drive.ended_as()
            return end

    def cancel(self) -> None:
        self._drive.cancel()

    async def was_preempted(self) -> bool:
        return False


class Rates:
    """What is due at which rate of simulated time, in the order of asking."""

    def __init__(self) -> None:
        self._next_s: dict[str, float] = {}

    def due(self, name: str, hz: float, now_s: float) -> bool:
        next_s = self._next_s.get(name, 0.0)
        if now_s < next_s - 1e-9:
            return False
        self._next_s[name] = max(next_s + 1.0 / hz, now_s)
        return True


class WorldRobot:
    """Implements `robot_bridge.ports.Robot`. Owns its World while it is open; one thread does everything."""

    def __init__(
        self,
        world: World,
        recorded: OccupancyGrid,
        *,
        on_death: Callable[[], None],
        settings: SimSettings | None = None,
        troubles: RobotTroubles | None = None,
        mapper: Mapper | None = None,
    ) -> None:
        """`recorded` is the map it has, which may be older than the home is now; with a `mapper` it is only what it
        begins with, and the map grows as it is seen.
        """
        self.troubles = troubles or RobotTroubles()
        self.world = world
        self.celebrations = 0
        self._recorded = recorded
        self._mapper = mapper
        self._on_death = on_death
        self._settings = settings or SimSettings.model_construct()
        self._senses = SensorReadings()
        self._sensing = Sensing(self._senses)
        self._localiser = Localiser(known=self._settings.amcl_initial_pose)
        self._navigator = Navigator(Costmap.from_map(recorded), tolerance_m=self._settings.nav2_planner_tolerance_m)
        self._behaviours = BaseBehaviours()
        self._base_stop = BaseStop()
        self._base_is_busy = False
        self._rates = Rates()
        self._goals: list[WorldGoal] = []
        self._pose = Pose2D(x=0.0, y=0.0, yaw=0.0)
        self._living: asyncio.Task[None] | None = None

    @property
    def senses(self) -> SensorReadings:
        return self._senses

    @property
    def believed_pose(self) -> Pose2D:
        return self._pose

    async def start(self, *, tick: Callable[[], None], navigation_velocity: Callable[[float, float], None]) -> None:
        self._loop = asyncio.get_running_loop()
        self._tick, self._navigation_velocity = tick, navigation_velocity
        if self._living is None:
            self._origin_s = self._loop.time() - self.world.time_s
            self._drives = Drives(
                self._navigator,
                lambda twist, _: self._navigation_velocity(twist.linear_x, twist.angular_z),
                Habits(ChainHabits(self._settings.nav2_delay_s)),
            )
        self._sensing.begin(self.world, self._recorded, self._now_s())
        if self._living is None:
            self._duties(self._now_s())
            self._living = asyncio.create_task(self._live(), name="world")
            self._living.add_done_callback(self._died)

    async def close(self) -> None:
        """The process that held it is gone: nobody ticks, and the next one begins with empty senses. The robot and
        Nav2 live on."""
        self._tick, self._navigation_velocity = _nobody_ticks, _nobody_drives
        self._senses = SensorReadings()
        self._sensing = Sensing(self._senses)

    async def end(self) -> None:
        """The robot itself ends."""
        if self._living is not None:
            self._living.cancel()
            await asyncio.gather(self._living, return_exceptions=True)

    def _died(self, task: "asyncio.Task[None]") -> None:
        if not task.cancelled():
            self._on_death()

    # --- the robot's own time

    def _now_s(self) -> float:
        return round(self._origin_s + self.world.time_s, 6)

    async def _live(self) -> None:
        slices = 0
        while True:
            if slices % TICK_SLICES == 0:
                self._tick()
            slices += 1
            wake_s = round(self._origin_s + self.world.time_s + SLICE_S, 6)
            due = self._loop.create_future()
            self._loop.call_at(wake_s, _wake, due)
            await due
            self.world.advance(SLICE_S)
            self._duties(self._now_s())

    def _duties(self, now_s: float) -> None:
        world, settings, time_s = self.world, self._settings, self.world.time_s
        if self._rates.due("localiser", settings.amcl_hz, time_s):
            odometry = world.odometry().pose
            if self._localiser.is_due(odometry):
                self._localiser.update(world.localization(), odometry)
        if self._rates.due("control", settings.odom_hz, time_s):
            self._control(now_s)
        if self._rates.due("scan", settings.scan_hz, time_s):
            correction = self._localiser.map_to_odom if self._localiser.known else None
            scan = self._sensing.scan(world, correction, now_s)
            laser = compose(self._pose, LIDAR)
            self._navigator.observe(scan, laser)
            if self._mapper is not None:
                self._mapper.observe(scan, laser)
        if self._mapper is not None and self._rates.due("map", 1.0 / MAP_EVERY_S, time_s):
            self._map_grown(self._mapper, now_s)
        if self._rates.due("base", 10.0, time_s):
            self._sensing.base(world, now_s)
        if self._rates.due("battery", 1.0, time_s):
            self._sensing.battery(world, now_s)
            self._sensing.alive(now_s)
            self._poll_base_stop(now_s)
        if self._rates.due("rgb", settings.rgb_hz, time_s):
            self._sensing.colour(world, now_s)
        if self._rates.due("depth", settings.depth_hz, time_s):
            self._sensing.depth(self.troubles.depth_of(world, now_s), now_s)

    def _map_grown(self, mapper: Mapper, now_s: float) -> None:
        grown = mapper.grid()
        if grown is not None:
            self._recorded = grown
            self._sensing.map(grown, now_s)
            self._navigator.take_map(Costmap.from_map(grown))

    def _control(self, now_s: float) -> None:
        self._pose = compose(self._localiser.map_to_odom, self._sensing.odometry(self.world, now_s))
        self._base_is_busy = self._behaviours.step(self.world)
        self._drives.tick(self._pose, self.world.time_s, 0)
        for goal in self._goals:
            goal.feed_back(now_s)
        self._goals = [goal for goal in self._goals if goal.ending is None]

    # --- the port

    def send_velocity(self, twist: Twist2D) -> None:
        if not self._base_is_busy:
            self.world.command(twist.linear_x, twist.angular_z)

    def engage_base_stop(self, engaged: bool, *, restored: bool = False) -> None:
        self._base_stop.there(True)
        if engaged:
            self._base_stop.stopped(restored=restored)
        else:
            self._base_stop.reset()
        self._poll_base_stop(self._now_s())

    def _poll_base_stop(self, now_s: float) -> None:
        self._base_stop.there(True)
        if (engaged := self._base_stop.due(now_s)) is not None:
            self.world.set_e_stop(engaged)
        self._base_stop.heard(not self.world.e_stop_on, now_s)
        self._senses.base_stop.put(self._base_stop.state(now_s), now_s)

    def cancel_all_goals(self) -> None:
        for goal in self._goals:
            goal.cancel()

    async def navigate(self, pose: Pose2D, on_progress: Callable[[float], None]) -> AcceptedWorldGoal | None:
        begun_s = self._loop.time()
        if self.troubles.rejects(begun_s):
            return None
        drive = WorldGoal(pose, on_progress)
        self._goals.append(drive)
        self._drives.submit(drive)
        return AcceptedWorldGoal(drive, self.troubles.ends_instead(begun_s))

    async def compute_path(self, goal: Pose2D, start: Pose2D | None) -> Path:
        if self.troubles.hides_path(self._loop.time()):
            return Path((), NO_PATH)
        try:
            found = self._navigator.plan(start or self._pose, goal)
        except NavigationError as error:
            return Path((), int(error.code))
        return Path(tuple(found.poses()))

    async def clear_costmaps(self) -> None:
        self._navigator.clear_global()
        self._navigator.clear_local()

    async def dock(self) -> bool:
        return await self._behave(Behaviour.docking, docked=True)

    async def undock(self) -> bool:
        return await self._behave(Behaviour.undocking, docked=False)

    async def _behave(self, make: Callable[[Callable[[], bool]], Behaviour], *, docked: bool) -> bool:
        left = False
        behaviour = make(lambda: left)
        self._behaviours.take(behaviour)
        try:
            while behaviour.ending is None:  # noqa: ASYNC110 - the stand-in knows no event loop
                await asyncio.sleep(0.1)
        except asyncio.CancelledError:
            left = True
            raise
        return behaviour.ending is Ending.DONE and behaviour.is_docked is docked

    def set_initial_pose(self, pose: Pose2D) -> None:
        self._localiser.take_initial_pose(pose, self.world.odometry().pose)

    def celebrate(self, celebration: Celebration) -> None:
        self.celebrations += 1

    def record(self, sink: Sink, *, images_hz: float) -> Callable[[], None]:
        """Nothing of ROS is there to record."""
        return lambda: None


def _nobody_ticks() -> None:
    pass


def _nobody_drives(linear_x: float, angular_z: float) -> None:
    pass


def _wake(due: "asyncio.Future[None]") -> None:
    if not due.done():
        due.set_result(None)
