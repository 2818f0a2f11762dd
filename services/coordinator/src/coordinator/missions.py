"""Starting, cancelling, pausing and asking about missions: what the routes call."""

import asyncio
import uuid
from collections.abc import Sequence

import structlog

from contracts.memory import RecallRequest
from contracts.mission import CoveragePlan, Mission, MissionState
from contracts.problem import Dependency
from contracts.vision import ParseTaskRequest
from coordinator.core import events as ev
from coordinator.core.mission import Place
from coordinator.explored import Explored
from coordinator.grid import MalformedMapError
from coordinator.parse_validation import CheckedTask, check_parse
from coordinator.ports import Eyes, Memory, MissionLog, Robot
from coordinator.runner import Runner
from coordinator.settings import Settings
from coordinator.view import mission_record
from mesh.bus import Bus
from mesh.clock import Clock
from mesh.errors import ConflictError, MeshError, NotFoundError, UnavailableError, UnprocessableError

log = structlog.get_logger()


class Missions:
    """One mission at a time; everything here ends in an event for the runner, or in a named error."""

    def __init__(self, *, settings: Settings, bus: Bus, robot: Robot, eyes: Eyes, memory: Memory, log_: MissionLog,
                 clock: Clock, runner: Runner) -> None:  # fmt: skip
        self.log = log_
        self.runner = runner
        self._settings = settings
        self._bus = bus
        self._robot = robot
        self._eyes = eyes
        self._memory = memory
        self._clock = clock
        self._starting = asyncio.Lock()

    async def start(self, command: str) -> Mission:
        """Reads the command, checks what was read, recalls where to look, and begins.

        Raises `ConflictError` while busy or stopped, `UnprocessableError` when the command names nothing known,
        `UnavailableError` without a robot or a parser.
        """
        if not command.strip():
            raise UnprocessableError("the command is empty")
        if self._starting.locked():
            raise ConflictError("another mission is being started")
        async with self._starting:
            self._refuse_now()
            task, notes = await self._read(command)
            views, recalled = await self._recall(task)
            self._refuse_now()
            self.runner.begin(
                ev.MissionStarted(
                    mission_id=uuid.uuid4().hex,
                    command=command,
                    target=task.target,
                    parser=notes[0],
                    colour=task.colour,
                    views=views,
                    notes="; ".join(note for note in (*notes[1:], task.notes, recalled) if note),
                )
            )
            record = mission_record(self.runner.mission)
            assert record is not None, "a mission was just begun"
            return record

    def _refuse_now(self) -> None:
        mission = self.runner.mission
        if mission.state is MissionState.EMERGENCY_STOP:
            raise ConflictError("the emergency stop is latched: reset it first")
        if mission.state is not MissionState.IDLE:
            raise ConflictError(f"busy: '{mission.command}' is {mission.state.value}")
        if self.runner.robot_state_age_s > self._settings.robot_state_age_s_max:
            raise UnavailableError("robot_bridge", "the robot's state is not coming in")

    async def _read(self, command: str) -> tuple[CheckedTask, tuple[str, ...]]:
        """The checked task, and (parser, notes...)."""
        labels, note = await self._labels()
        parsed = await self._eyes.parse_task(ParseTaskRequest(command=command, labels_in_memory=labels))
        task = check_parse(command, parsed, labels)
        if task is None:
            raise UnprocessableError(f"'{command[:100]}' names nothing I know: {parsed.notes or 'no such class'}")
        return task, (parsed.parser, note)

    async def _labels(self) -> tuple[tuple[str, ...], str]:
        try:
            async with asyncio.timeout(self._settings.recall_timeout_s):
                found = await self._memory.labels()
        except (MeshError, TimeoutError) as error:
            log.warning("memory is away", error=str(error))
            return (), "memory is away"
        return tuple(count.label for count in found)[:500], ""

    async def _recall(self, task: CheckedTask) -> tuple[tuple[Place, ...], str]:
        if self._settings.memory_views_max == 0:
            return (), ""
        request = RecallRequest(
            label=task.target.label,
            memory_object=task.memory_object,
            description=task.target.description,
            pose=self.runner.mission.robot.pose,
            limit=self._settings.memory_views_max,
        )
        try:
            async with asyncio.timeout(self._settings.recall_timeout_s):
                reply = await self._memory.recall(request)
        except (MeshError, TimeoutError) as error:
            log.warning("nothing was recalled", error=str(error))
            return (), "nothing could be recalled"
        return tuple(
            Place(r.view.pose, r.reason or f"{r.view.label} seen at confidence {r.view.confidence:.2f}")
            for r in reply.views
        ), ""

    def get(self, mission_id: str) -> Mission:
        mission = self.log.get(mission_id)
        if mission is None:
            raise NotFoundError(f"no mission {mission_id[:64]}")
        return mission

    def cancel(self, mission_id: str) -> Mission:
        return self._tell(mission_id, ev.CancelAsked())

    def pause(self, mission_id: str) -> Mission:
        if self.get(mission_id).paused:
            raise ConflictError("it is paused already")
        return self._tell(mission_id, ev.PauseAsked())

    def resume(self, mission_id: str) -> Mission:
        if not self.get(mission_id).paused:
            raise ConflictError("it is not paused")
        return self._tell(mission_id, ev.ResumeAsked())

    def _tell(self, mission_id: str, event: ev.CancelAsked | ev.PauseAsked | ev.ResumeAsked) -> Mission:
        mission = self.get(mission_id)
        if mission.outcome is not None or self.runner.mission.id != mission_id:
            ending = mission.outcome.value if mission.outcome is not None else "over"
            raise ConflictError(f"the mission has ended: {ending}")
        self.runner.feed(event)
        return self.get(mission_id)

    async def coverage(self) -> CoveragePlan:
        """The plan for the current map from where the robot stands."""
        try:
            plan = await Explored(self._robot, self._settings).plan(self.runner.mission.robot.pose, ())
        except MalformedMapError as error:
            raise UnavailableError("robot_bridge", f"the map is malformed: {error}") from error
        return CoveragePlan(points=plan.points, regions=plan.regions, free_area_m2=plan.free_area_m2)

    async def dependencies(self) -> Sequence[Dependency]:
        """Redis, each service, the session, and the robot's state."""
        others = await asyncio.gather(self._robot.dependency(), self._eyes.dependency(), self._memory.dependency())
        age_s = self.runner.robot_state_age_s
        fresh = age_s <= self._settings.robot_state_age_s_max
        return (
            Dependency(name="redis", ok=self._bus.connected),
            *others,
            Dependency(name="session", ok=self._robot.session_held, detail="with robot_bridge"),
            Dependency(name="robot.state", ok=fresh, detail="fresh" if fresh else "not coming in"),
        )
