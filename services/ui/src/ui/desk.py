"""What the operator can do and know: listens to the bus, asks the services while somebody looks, passes commands on."""

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from typing import Final, TypeVar

import structlog

from contracts.mission import MissionEvent, MissionStatus
from contracts.problem import Dependency
from contracts.robot import EmergencyStop, EmergencyStopReply, EmergencyStopRequest, MotionReply, RobotState
from contracts.topics import MISSION_EVENTS, MISSION_STATE, ROBOT_EMERGENCY_STOP, ROBOT_STATE
from mesh.bus import Bus
from mesh.clock import Clock
from mesh.errors import MeshError, UnavailableError, UpstreamError
from mesh.tasks import Tasks
from ui import map_view
from ui.ports import Eyes, Memory, Missions, Robot
from ui.settings import Settings
from ui.situation import Situation

log = structlog.get_logger()
T = TypeVar("T")

COMMAND_MAX: Final = 500


@dataclass(frozen=True, slots=True)
class Told:
    """What came of an action, in words for a person."""

    ok: bool
    text: str


class Desk:
    """One for all viewers. Facts come by themselves; `refresh` asks for the rest and is called by open pages only."""

    def __init__(
        self,
        *,
        settings: Settings,
        bus: Bus,
        robot: Robot,
        eyes: Eyes,
        missions: Missions,
        memory: Memory,
        clock: Clock,
    ) -> None:
        self.settings = settings
        self.clock = clock
        self.eyes = eyes
        self.situation = Situation(
            events_kept=settings.events_kept,
            trail_points_max=settings.trail_points_max,
            trail_step_m=settings.trail_step_m,
        )
        self.picture: map_view.MapPicture | None = None
        self._bus = bus
        self._robot = robot
        self._missions = missions
        self._memory = memory
        self._refreshing = asyncio.Lock()
        self._refreshed_at_s = float("-inf")
        self._map_at_s = float("-inf")
        self._timeline_of: str | None = None

    # what comes by itself

    def start(self, tasks: Tasks) -> None:
        tasks.start("listen-robot", self._bus.listen(ROBOT_STATE, self._on_robot))
        tasks.start("listen-stop", self._bus.listen(ROBOT_EMERGENCY_STOP, self._on_stop))
        tasks.start("listen-mission", self._bus.listen(MISSION_STATE, self._on_mission))
        tasks.start("listen-events", self._bus.listen(MISSION_EVENTS, self._on_event))

    async def _on_robot(self, state: RobotState) -> None:
        self.situation.take_robot(state, self.clock.now_s())

    async def _on_stop(self, stop: EmergencyStop) -> None:
        self.situation.take_stop(stop, self.clock.now_s())

    async def _on_mission(self, status: MissionStatus) -> None:
        self.situation.take_mission(status, self.clock.now_s())

    async def _on_event(self, event: MissionEvent) -> None:
        self.situation.take_events((event,))

    # what is asked for

    async def dependencies(self) -> Sequence[Dependency]:
        redis = Dependency(name="redis", ok=self._bus.connected, detail="" if self._bus.connected else "not reachable")
        answers = await asyncio.gather(
            self._missions.dependency(), self.eyes.dependency(), self._memory.dependency(), self._robot.dependency()
        )
        return (redis, *answers)

    async def refresh(self) -> None:
        """At most every `health_period_s`, however many pages ask: who is there, and facts the bus keeps silent on."""
        if self._refreshing.locked() or self.clock.now_s() - self._refreshed_at_s < self.settings.health_period_s:
            return
        async with self._refreshing:
            services = await self.dependencies()
            self.situation.bus_connected = self._bus.connected
            self.situation.services = tuple(services)
            away = {service.name for service in services if "not reachable" in service.detail}
            silent_since_s = self.clock.now_s() - self.settings.silence_s_max
            if "robot_bridge" not in away:
                await self._try(self._refresh_map)
                if self.situation.robot_at_s < silent_since_s:
                    await self._try(self._ask_robot)
            if "coordinator" not in away:
                if self.situation.mission_at_s < silent_since_s:
                    await self._try(self._ask_mission)
                await self._try(self._ask_timeline)
            self._refreshed_at_s = self.clock.now_s()

    async def _try(self, ask: Callable[[], Awaitable[None]]) -> None:
        """A service that went away since is named by the next look at the dependencies."""
        try:
            await ask()
        except (MeshError, map_view.MapError) as error:
            log.info("could not be asked", error=str(error))

    async def _refresh_map(self) -> None:
        now_s = self.clock.now_s()
        if now_s - self._map_at_s < self.settings.map_period_s:
            return
        grid = await self._robot.map()
        if self.picture is None or self.picture.version != map_view.version(grid):
            self.picture = await asyncio.to_thread(map_view.picture, grid)
        self._map_at_s = now_s

    async def _ask_robot(self) -> None:
        self.situation.take_robot(await self._robot.state(), self.clock.now_s())

    async def _ask_mission(self) -> None:
        self.situation.take_mission(await self._missions.status(), self.clock.now_s())

    async def _ask_timeline(self) -> None:
        """Once a mission, for what was told before this process listened; while the bus is away, every time."""
        mission_id = self.situation.mission_id
        if mission_id is None or (mission_id == self._timeline_of and self._bus.connected):
            return
        self.situation.take_events(await self._missions.events(mission_id))
        self._timeline_of = mission_id if self._bus.connected else None

    async def map_picture(self) -> map_view.MapPicture:
        """Raises `UnavailableError` naming what is missing when there has never been a map."""
        if self.picture is None:
            await self._refresh_map()
        if self.picture is None:
            raise UnavailableError("robot_bridge", "no map yet")
        return self.picture

    # what the operator does

    async def emergency_stop(self, *, reason: str, by: str) -> EmergencyStopReply:
        """Straight to robot_bridge; needs neither Redis nor any other service."""
        reply = await self._robot.emergency_stop(EmergencyStopRequest(reason=reason, by=by))
        self.situation.take_stop_reply(reply, self.clock.now_s())
        log.warning("emergency stop", reason=reason, by=by, first_zero_ms=reply.first_zero_ms)
        return reply

    async def reset(self, *, by: str) -> Told:
        async def do() -> str:
            reply = await self._robot.reset(EmergencyStopRequest(reason="RESUME confirmed on the page", by=by))
            self.situation.take_stop_reply(reply, self.clock.now_s())
            return "Motion is permitted again. Nothing moves until it is asked to."

        return await self._told(do())

    async def command(self, text: str) -> Told:
        words = text.strip()
        if not words:
            return Told(False, "Say what to find, for example: find the red bottle")
        if len(words) > COMMAND_MAX:
            return Told(False, f"That is {len(words)} characters; {COMMAND_MAX} is the limit.")

        async def do() -> str:
            mission = await self._missions.start(words)
            what = mission.target.description if mission.target is not None else mission.command
            return f"Looking for: {what}"

        return await self._told(do())

    async def pause(self) -> Told:
        return await self._with_mission(self._missions.pause, "Paused.")

    async def resume(self) -> Told:
        return await self._with_mission(self._missions.resume, "Going on.")

    async def cancel(self) -> Told:
        return await self._with_mission(self._missions.cancel, "Cancelled.")

    async def dock(self) -> Told:
        return await self._told(self._moved(self._robot.dock(), "On the dock.", "It did not dock"))

    async def undock(self) -> Told:
        return await self._told(self._moved(self._robot.undock(), "Off the dock.", "It did not undock"))

    async def _with_mission(self, act: Callable[[str], Awaitable[object]], done: str) -> Told:
        mission_id = self.situation.mission_id
        if mission_id is None:
            return Told(False, "There is no mission.")

        async def do() -> str:
            await act(mission_id)
            return done

        return await self._told(do())

    @staticmethod
    async def _moved(motion: Awaitable[MotionReply], done: str, failed: str) -> str:
        reply = await motion
        if not reply.completed:
            raise UpstreamError("robot_bridge", 200, f"{failed}: {reply.reason or 'no reason given'}")
        return done

    @staticmethod
    async def _told(doing: Awaitable[str]) -> Told:
        try:
            return Told(True, await doing)
        except UpstreamError as error:
            return Told(False, error.detail.removeprefix(f"{error.service}: "))
        except MeshError as error:
            return Told(False, error.detail)
