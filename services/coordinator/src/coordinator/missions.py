"""Starting, cancelling, pausing and asking about missions: what the routes call."""

import asyncio
import hashlib
import re
import uuid
from collections.abc import Sequence

import structlog

from contracts.mission import CoveragePlan, Mission, MissionState
from contracts.problem import Dependency
from contracts.vision import ParsedTarget, ParsedTask, ParseTaskRequest
from coordinator.core import events as ev
from coordinator.core.mission import Order
from coordinator.dispatcher import Dispatcher
from coordinator.explored import Explored
from coordinator.parse_validation import CheckedTask, check_parse
from coordinator.pending import Pending, Queue
from coordinator.ports import Eyes, KnownRequest, Memory, MissionLog, Robot
from coordinator.runner import Runner
from coordinator.settings import Settings
from geometry.grids import MapError
from mesh.bus import Bus, redis_dependency
from mesh.clock import Clock
from mesh.errors import ConflictError, MeshError, NotFoundError, UnavailableError, UnprocessableError

log = structlog.get_logger()

DOCK_COMMAND = re.compile(
    r"(please )?(go|drive|return|get)?( back)?( to)?( your| the)? ?(dock|charger|home|charge)( now)?[.!]?"
)


class Missions:
    """Everything here ends in an event for the runner, in the queue, or in a named error."""

    def __init__(self, *, settings: Settings, bus: Bus, robot: Robot, eyes: Eyes, memory: Memory, log_: MissionLog,
                 clock: Clock, runner: Runner, queue: Queue, dispatcher: Dispatcher) -> None:  # fmt: skip
        self.log = log_
        self.runner = runner
        self._settings = settings
        self._bus = bus
        self._robot = robot
        self._eyes = eyes
        self._memory = memory
        self._clock = clock
        self._queue = queue
        self._dispatcher = dispatcher
        self._starting = asyncio.Lock()

    async def start(self, command: str, key: str | None = None) -> Mission:
        """Reads the command, checks what was read, and puts a mission for each thing it names into the queue; the first
        begins at once where nothing runs. With `key`, the same request again answers with the same mission.

        Raises `ConflictError` while stopped or low on power, `UnprocessableError` when the command names nothing known
        or the key was used for another command, `TooManyError` when the queue is full, `UnavailableError` without a
        robot or a parser.
        """
        if not command.strip():
            raise UnprocessableError("the command is empty")
        async with self._starting:
            digest = hashlib.sha256(command.encode()).hexdigest()
            known = await self.log.request(key) if key is not None else None
            if known is not None:
                if known.digest != digest:
                    raise UnprocessableError("this Idempotency-Key was used for another command")
                return await self.get(known.mission_ids[0])
            made = await self._enqueue(command)
            if key is not None:
                self.log.keep_request(key, KnownRequest(digest, tuple(one.id for one in made)))
        await self._dispatcher.advance()
        await self._save()
        return await self.get(made[0].id)

    async def _enqueue(self, command: str) -> tuple[Pending, ...]:
        self._refuse_now()
        if DOCK_COMMAND.fullmatch(command.strip().lower()):
            read: list[tuple[CheckedTask | None, str, str]] = [(None, "", "")]
        else:
            read = [*await self._read(command)]
        request_id, asked_s = uuid.uuid4().hex, self._clock.now_s()
        made = tuple(
            Pending(uuid.uuid4().hex, command, task, parser, notes, Order(request_id, part, len(read), asked_s))
            for part, (task, parser, notes) in enumerate(read, start=1)
        )
        self._refuse_now()
        self._queue.add(made)
        self._tell_queued({one.id for one in made})
        return made

    def _tell_queued(self, ids: set[str]) -> None:
        busy = self.runner.mission.state is not MissionState.IDLE
        for record in (one for one in self._queue.records() if one.id in ids):
            what = record.target.description if record.target is not None else "the dock"
            part = f" (part {record.part} of {record.parts})" if record.parts > 1 else ""
            if busy or record.queue_position != 0:
                self.runner.tell(record, "queued", f"'{record.command}': {what}{part} waits for its turn")
            else:
                self.log.put(record)

    def _refuse_now(self) -> None:
        if self.runner.mission.state is MissionState.EMERGENCY_STOP:
            raise ConflictError("the emergency stop is latched: reset it first")
        if self.runner.robot_state_age_s > self._settings.robot_state_age_s_max:
            raise UnavailableError("robot_bridge", "the robot's state is not coming in")
        low = self._dispatcher.why_no_power()
        if low:
            raise ConflictError(f"{low}: it has to charge first")

    async def _read(self, command: str) -> Sequence[tuple[CheckedTask, str, str]]:
        """(checked task, parser, notes) for each thing the command names, in the order said."""
        labels, note = await self._labels()
        parsed = await self._eyes.parse_task(ParseTaskRequest(command=command, labels_in_memory=labels))
        found: list[tuple[CheckedTask, str, str]] = []
        unknown: list[str] = []
        for said, part in _parts(command, parsed):
            task = check_parse(said, part, labels)
            if task is None:
                unknown.append(said)
            else:
                found.append((task, part.parser, "; ".join(one for one in (task.notes, note) if one)))
        if not found:
            raise UnprocessableError(f"'{command[:100]}' names nothing I know: {parsed.notes or 'no such class'}")
        if unknown:
            task, parser, notes = found[0]
            found[0] = (task, parser, "; ".join([*filter(None, [notes]), f"left out, not known: {', '.join(unknown)}"]))
        return found

    async def _labels(self) -> tuple[tuple[str, ...], str]:
        try:
            async with asyncio.timeout(self._settings.recall_timeout_s):
                found = await self._memory.labels()
        except (MeshError, TimeoutError) as error:
            log.warning("memory is away", error=str(error))
            return (), "memory is away"
        return tuple(count.label for count in found)[:500], ""

    async def _save(self) -> None:
        try:
            await self.log.saved()
        except UnavailableError as error:
            log.warning("the mission is not on disk yet", error=error.detail)

    async def get(self, mission_id: str) -> Mission:
        """Raises `NotFoundError`."""
        waiting = next((one for one in self._queue.records() if one.id == mission_id), None)
        mission = waiting or await self.log.get(mission_id)
        if mission is None:
            raise NotFoundError(f"no mission {mission_id[:64]}")
        return mission

    async def picture(self, mission_id: str, number: int) -> bytes:
        await self.get(mission_id)
        jpeg = await self.log.picture(mission_id, number)
        if jpeg is None:
            raise NotFoundError(f"no picture {number} of this mission: the camera was away, or it is no longer kept")
        return jpeg

    async def recording(self, mission_id: str) -> str:
        await self.get(mission_id)
        lines = await self.log.recording(mission_id)
        if not lines:
            raise NotFoundError("this mission has no recording: it never began, or it is no longer kept")
        return "\n".join(lines) + "\n"

    async def cancel(self, mission_id: str) -> Mission:
        if not self._dispatcher.cancel(mission_id):
            return await self._tell(mission_id, ev.CancelAsked())
        return await self.get(mission_id)

    async def pause(self, mission_id: str) -> Mission:
        if (await self.get(mission_id)).paused:
            raise ConflictError("it is paused already")
        return await self._tell(mission_id, ev.PauseAsked())

    async def resume(self, mission_id: str) -> Mission:
        if not (await self.get(mission_id)).paused:
            raise ConflictError("it is not paused")
        return await self._tell(mission_id, ev.ResumeAsked())

    async def _tell(self, mission_id: str, event: ev.CancelAsked | ev.PauseAsked | ev.ResumeAsked) -> Mission:
        mission = await self.get(mission_id)
        if mission.queue_position is not None:
            raise ConflictError("it has not begun: it waits in the queue, and can only be cancelled")
        if mission.outcome is not None or self.runner.mission.id != mission_id:
            ending = mission.outcome.value if mission.outcome is not None else "over"
            raise ConflictError(f"the mission has ended: {ending}")
        self.runner.feed(event)
        return await self.get(mission_id)

    async def coverage(self) -> CoveragePlan:
        """The plan for the current map from where the robot stands."""
        try:
            plan = await Explored(self._robot, self._settings).plan(self.runner.mission.robot.pose, ())
        except MapError as error:
            raise UnavailableError("robot_bridge", f"the map is malformed: {error}") from error
        return CoveragePlan(
            points=plan.points,
            regions=plan.regions,
            free_area_m2=plan.free_area_m2,
            map_trouble=plan.trouble,
        )

    async def dependencies(self) -> Sequence[Dependency]:
        """Redis, each service, the database, the session, and the robot's state."""
        others = await asyncio.gather(
            self._robot.dependency(), self._eyes.dependency(), self._memory.dependency(), self.log.dependency()
        )
        age_s = self.runner.robot_state_age_s
        fresh = age_s <= self._settings.robot_state_age_s_max
        return (
            redis_dependency(self._bus),
            *others,
            Dependency.of("session", ok=self._robot.session_held, detail="with robot_bridge"),
            Dependency.of("robot.state", ok=fresh, detail="fresh" if fresh else "not coming in"),
        )


def _parts(command: str, parsed: ParsedTask) -> list[tuple[str, ParsedTask]]:
    """What was said of each thing, and what a parser claims it means."""
    if not parsed.targets:
        return [(command, parsed)]
    return [(one.said, _alone(one, parsed.notes if k == 0 else "")) for k, one in enumerate(parsed.targets)]


def _alone(one: ParsedTarget, notes: str) -> ParsedTask:
    return ParsedTask(
        yolo_class=one.yolo_class,
        memory_object=one.memory_object,
        description=one.description,
        parser=one.parser,
        notes=notes,
    )
