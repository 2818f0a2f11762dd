"""What is known: listens to the bus, and asks the services for the rest while somebody looks."""

import asyncio
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import Any

import structlog

from contracts.belief import NoBelief
from contracts.description import RobotDescription
from contracts.memory import LabelCount, RememberedObject, View
from contracts.mission import Mission, MissionEvent, MissionStatus, MissionTarget
from contracts.problem import Dependency, DependencyState
from contracts.robot import EmergencyStop, Goal, PathRequest, RobotState
from contracts.rooms import RoomsReply
from contracts.topics import (
    MISSION_EVENTS,
    MISSION_STATE,
    MISSION_TARGET,
    ROBOT_DESCRIPTION,
    ROBOT_EMERGENCY_STOP,
    ROBOT_NAVIGATION,
    ROBOT_STATE,
    VISION_DETECTIONS,
)
from contracts.vision import Detections
from geometry.grids import MapError
from mesh.bus import Bus, redis_dependency
from mesh.clock import Clock
from mesh.errors import MeshError, UnavailableError
from mesh.http import ServiceClient
from mesh.tasks import Tasks
from ui import map_view, overlay, rooms_layer
from ui.event_pictures import EventPictures
from ui.frames import Frames
from ui.i18n import _
from ui.latest_facts import LatestFacts, Remembered, ShownRooms
from ui.map_layers import MapLayers
from ui.notifications import Notifications
from ui.ports import Memory, Missions, Robot, Speech
from ui.settings import Settings
from ui.stop_probe import StopProbe
from ui.thumbnails import Thumbnails

log = structlog.get_logger()

PICTURE_WAIT_S = 1.0
WATCHED_S = 10.0
"""An open page asks every second; longer ago, and nobody looks."""
HISTORY_MAX = 50


class Desk:
    """One for all viewers. Facts come by themselves; `refresh` asks for the rest and is called by open pages only."""

    def __init__(
        self,
        *,
        settings: Settings,
        bus: Bus,
        robot: Robot,
        inference: ServiceClient,
        missions: Missions,
        memory: Memory,
        clock: Clock,
        speech: Speech | None = None,
    ) -> None:
        self.settings = settings
        self.clock = clock
        self.robot = robot
        self.missions = missions
        self.memory = memory
        self.speech = speech
        """None where there is none: the page neither hears nor speaks."""
        self.facts = LatestFacts(
            events_kept=settings.events_kept,
            trail_points_max=settings.trail_points_max,
            trail_step_m=settings.trail_step_m,
        )
        self.notifications = Notifications()
        self.event_pictures = EventPictures(settings.album_pictures_max)
        self.thumbnails = Thumbnails(settings.album_pictures_max)
        self.stop_probe = StopProbe(robot, clock)
        self.frames = Frames(robot, clock, period_s=1.0 / settings.camera_fps_max, about=self._about)
        self.driver: object | None = None
        """Whoever drives by hand now; one at a time."""
        self.map_layers = MapLayers(settings.silence_s_max)
        self.picture: map_view.MapPicture | None = None
        self.memory_heard = False
        self._bus = bus
        self._inference = inference
        self._tasks: Tasks | None = None
        self._refreshing = asyncio.Lock()
        self._scanning = False
        self._believing = False
        self._cropping = False
        self._at_s: dict[str, float] = {}
        self._timeline_of: str | None = None

    # what comes by itself

    def start(self, tasks: Tasks) -> None:
        self._tasks = tasks
        listen = self._bus.listen
        tasks.start("listen-robot", listen(ROBOT_STATE, self._on_robot))
        tasks.start("listen-description", listen(ROBOT_DESCRIPTION, self._on_description))
        tasks.start("listen-stop", listen(ROBOT_EMERGENCY_STOP, self._on_stop))
        tasks.start("listen-navigation", listen(ROBOT_NAVIGATION, self._on_goal))
        tasks.start("listen-mission", listen(MISSION_STATE, self._on_mission))
        tasks.start("listen-target", listen(MISSION_TARGET, self._on_target))
        tasks.start("listen-events", listen(MISSION_EVENTS, self._on_event))
        tasks.start("listen-detections", listen(VISION_DETECTIONS, self._on_detections))

    async def _on_robot(self, state: RobotState) -> None:
        self.facts.take_robot(state, self.clock.now_s())

    async def _on_description(self, body: RobotDescription) -> None:
        self.facts.body = body

    async def _on_stop(self, stop: EmergencyStop) -> None:
        self.facts.take_stop(stop, self.clock.now_s())
        self.notifications.take_stop(stop)

    async def _on_goal(self, goal: Goal) -> None:
        self.facts.take_goal(goal)

    async def _on_mission(self, status: MissionStatus) -> None:
        self.facts.take_mission(status, self.clock.now_s())
        self.notifications.take_mission(status)

    async def _on_target(self, wanted: MissionTarget) -> None:
        self.facts.target = wanted.target

    async def _on_detections(self, seen: Detections) -> None:
        self.facts.detections = seen
        if self._tasks is not None and seen.detections and not self._cropping and self._watched():
            self._cropping = True
            self._tasks.start("thumbnails", self._keep_things(seen), forever=False)

    def _watched(self) -> bool:
        return self.clock.now_s() - self._at_s.get("health", float("-inf")) <= WATCHED_S + self.settings.health_period_s

    async def _keep_things(self, seen: Detections) -> None:
        try:
            shown = await self.frames.other_than(None, wait_s=PICTURE_WAIT_S)
        finally:
            self._cropping = False
        if shown is not None:
            self.thumbnails.put(seen, shown.frame)

    async def _on_event(self, event: MissionEvent) -> None:
        self.facts.take_events((event,))
        if self._tasks is not None and event.mission_id:
            self._tasks.start("picture", self._keep_picture(event), forever=False)

    async def _keep_picture(self, event: MissionEvent) -> None:
        shown = await self.frames.other_than(None, wait_s=PICTURE_WAIT_S)
        if shown is not None:
            self.event_pictures.put(event.mission_id, event.id, shown)

    def _about(self, frame: overlay.CameraFrame) -> Mapping[str, Any]:
        """What the browser draws over a frame."""
        target = self.facts.target
        return {
            "stamp_s": round(frame.stamp_s, 6),
            "width": frame.width_px,
            "height": frame.height_px,
            "boxes": overlay.boxes(frame, self.facts.detections, target),
            "line": _("Looking for: {what}", what=target.description)
            if target is not None
            else _("Waiting for next command..."),
        }

    # what is asked for

    async def dependencies(self) -> Sequence[Dependency]:
        """Those of `/ready`. The page does its work without speech, so that its lack is a warning."""
        speech = [one.model_copy(update={"state": DependencyState.WARNING}) for one in await self._ears() if not one.ok]
        return (*await self._needed(), *speech)

    async def _ears(self) -> Sequence[Dependency]:
        return () if self.speech is None else (await self.speech.dependency(),)

    async def _needed(self) -> Sequence[Dependency]:
        answers = await asyncio.gather(
            self.missions.dependency(), self._inference.dependency(), self.memory.dependency(), self.robot.dependency()
        )
        return (redis_dependency(self._bus), *answers)

    async def refresh(self) -> None:
        """At most every `health_period_s`, however many pages ask: who is there, and facts the bus keeps silent on."""
        if self._refreshing.locked() or not self._due("health", self.settings.health_period_s):
            return
        async with self._refreshing:
            services = (*await self._needed(), *await self._ears())
            self.facts.bus_connected = self._bus.connected
            self.facts.services = tuple(services)
            away = {service.name for service in services if service.state is DependencyState.UNREACHABLE}
            silent_since_s = self.clock.now_s() - self.settings.silence_s_max
            if "robot_bridge" not in away:
                await self._try(self._refresh_map)
                if self.facts.robot_at_s < silent_since_s:
                    await self._try(self._ask_robot)
                await self._try(self._refresh_plan)
            if "coordinator" not in away:
                if self.facts.mission_at_s < silent_since_s:
                    await self._try(self._ask_mission)
                await self._try(self._ask_timeline)
            if "memory" not in away:
                await self._try(self.refresh_memory)
                await self._try(self.refresh_rooms)

    def _due(self, what: str, period_s: float) -> bool:
        """True, and noted, when the last time is `period_s` ago."""
        now_s = self.clock.now_s()
        if now_s - self._at_s.get(what, float("-inf")) < period_s:
            return False
        self._at_s[what] = now_s
        return True

    async def _try(self, ask: Callable[[], Awaitable[None]]) -> None:
        """A service that went away since is named by the next look at the dependencies."""
        try:
            await ask()
        except (MeshError, MapError) as error:
            log.info("could not be asked", error=str(error))

    async def _refresh_map(self) -> None:
        if not self._due("map", self.settings.map_period_s):
            return
        grid = await self.robot.map()
        if self.picture is None or self.picture.version != map_view.version(grid):
            self.picture = await asyncio.to_thread(map_view.picture, grid)

    async def _refresh_plan(self) -> None:
        goal = self.facts.goal
        if goal is None or not self._due("plan", self.settings.plan_period_s):
            return
        found = await self.robot.path(PathRequest(goal=goal.pose))
        if self.facts.goal is not None and found.reachable:
            self.facts.take_plan(found.poses)

    async def refresh_memory(self, *, now: bool = False) -> None:
        if not self._due("memory", 0.0 if now else self.settings.memory_period_s):
            return
        labels: Sequence[LabelCount]
        objects: Sequence[RememberedObject]
        views: Sequence[View]
        labels, objects, views = await asyncio.gather(self.memory.labels(), self.memory.objects(), self.memory.views())
        self.memory_heard = True
        self.thumbnails.match(objects)
        found = Remembered(tuple(labels), tuple(objects), tuple(views))
        if found != self.facts.remembered:
            self.facts.remembered = found

    async def refresh_rooms(self, *, now: bool = False) -> None:
        """Where they lie is asked for when they are others than those shown."""
        if not self._due("rooms", 0.0 if now else self.settings.memory_period_s):
            return
        known, told = self.facts.rooms, await self.memory.rooms()
        grid = known.grid if known.grid is not None and _lie_alike(known, told) else None
        if grid is None and told.rooms:
            grid = await self.memory.room_grid()
        if (told.map_id, told.rooms, grid) != (known.map_id, known.rooms, known.grid):
            picture = known.picture
            if grid is not known.grid:
                picture = await asyncio.to_thread(rooms_layer.picture, grid) if grid is not None else None
            self.facts.rooms = ShownRooms(told.map_id, told.rooms, grid, picture)

    def refresh_scan(self) -> None:
        """Asks for the laser, for as long as a map is open; nobody waits for it."""
        if self._tasks is not None and not self._scanning and self._due("scan", self.settings.scan_period_s):
            self._scanning = True
            self._tasks.start("scan", self._ask_scan(), forever=False)

    async def _ask_scan(self) -> None:
        """A silent laser leaves nothing to draw."""
        try:
            self.facts.scan = await self.robot.scan()
        except MeshError:
            self.facts.scan = None
        finally:
            self._scanning = False

    def refresh_belief(self) -> None:
        """Asks for what the search holds probable, for as long as a page shows it; nobody waits for it."""
        if self._tasks is not None and not self._believing and self._due("belief", self.settings.belief_period_s):
            self._believing = True
            self._tasks.start("belief", self._ask_belief(), forever=False)

    async def _ask_belief(self) -> None:
        mission = self.facts.mission.mission if self.facts.mission is not None else None
        try:
            if mission is None or mission.outcome is not None:
                self.facts.belief = NoBelief.NOT_BEGUN if mission is None else NoBelief.ENDED
            else:
                self.facts.belief = await self.missions.belief(mission.id)
        except MeshError:
            self.facts.belief = None
        finally:
            self._believing = False

    async def _ask_robot(self) -> None:
        self.facts.take_robot(await self.robot.state(), self.clock.now_s())

    async def _ask_mission(self) -> None:
        await self._on_mission(await self.missions.status())

    async def _ask_timeline(self) -> None:
        """Once a mission, for what was told before this process listened; while the bus is away, every time."""
        mission_id = self.facts.mission_id
        if mission_id is None or (mission_id == self._timeline_of and self._bus.connected):
            return
        self.facts.take_events(await self.missions.events(mission_id))
        self._timeline_of = mission_id if self._bus.connected else None

    async def history(self) -> Sequence[Mission]:
        return await self.missions.newest(HISTORY_MAX)

    async def map_picture(self) -> map_view.MapPicture:
        """Raises `UnavailableError` naming what is missing when there has never been a map."""
        if self.picture is None:
            self._at_s.pop("map", None)
            await self._refresh_map()
        if self.picture is None:
            raise UnavailableError("robot_bridge", "no map yet")
        return self.picture


def _lie_alike(known: ShownRooms, told: RoomsReply) -> bool:
    """The same rooms of the same map, whatever they are called."""
    before, now = ([(one.id, one.x, one.y, one.area_m2) for one in some] for some in (known.rooms, told.rooms))
    return known.map_id == told.map_id and before == now
