"""Starting, cancelling, pausing and asking about missions: what the routes call."""

import asyncio
import hashlib
import uuid
from collections.abc import AsyncGenerator, AsyncIterable, Sequence
from contextlib import asynccontextmanager
from dataclasses import replace
from functools import partial

import structlog

from contracts.backup import BackupRefusal, RestoreHold, RestoreReply
from contracts.belief import NoBelief, SearchBelief
from contracts.mission import CommandRefusal, CoveragePlan, EventKind, Heard, Mission, MissionState
from contracts.problem import Dependency
from contracts.reading import Mood
from contracts.vision import Target
from coordinator.commands.command_reader import CommandReader
from coordinator.commands.dispatcher import Dispatcher
from coordinator.commands.orders import Orders
from coordinator.commands.restoring import restored
from coordinator.core import events as ev
from coordinator.core.mission import Order
from coordinator.core.motions import PlainMotion
from coordinator.execution.mission_runner import MissionRunner
from coordinator.metrics import QUEUE, ROBOT_STATE_AGE, STATE
from coordinator.ports import Inference, KnownRequest, Memory, MissionLog, Robot
from coordinator.queue.mission_queue import MissionQueue, QueuedMission, Work, goes_by_its_body, queued
from coordinator.settings import Settings
from geometry.grids import MapError
from mesh.bus import Bus, redis_dependency
from mesh.clock import Clock
from mesh.errors import ConflictError, NotFoundError, UnavailableError, UnprocessableError
from mesh.tracing import Tracer, traceparent
from vocabulary.actions import is_docking
from vocabulary.languages import is_foreign
from vocabulary.moods import Reading, read
from vocabulary.orders import order_in

log = structlog.get_logger()

TRACER = Tracer(__name__)
LAST_ASKED = 10
"""Missions of the history in which 'it' is looked for: the way to the dock has no target."""

NO_BELIEF = {
    NoBelief.NOT_BEGUN: "the mission has not begun",
    NoBelief.ENDED: "the mission has ended",
    NoBelief.ANOTHER_RULE: "it does not search by belief: COORDINATOR_COVERAGE_RULE=belief does",
    NoBelief.NOTHING_CHOSEN: "it has not come to its first choice of where to look yet",
}


class MissionService:
    """Everything here ends in an event for the runner, in the queue, or in a named error."""

    def __init__(
        self,
        *,
        settings: Settings,
        bus: Bus,
        robot: Robot,
        inference: Inference,
        memory: Memory,
        log_: MissionLog,
        clock: Clock,
        runner: MissionRunner,
        queue: MissionQueue,
        dispatcher: Dispatcher,
        reader: CommandReader,
    ) -> None:
        self.log = log_
        self.runner = runner
        self.reader = reader
        self._settings = settings
        self._bus = bus
        self._robot = robot
        self._inference = inference
        self._memory = memory
        self._clock = clock
        self._queue = queue
        self._dispatcher = dispatcher
        self._starting = asyncio.Lock()
        self.orders = Orders(runner=runner, dispatcher=dispatcher, robot=robot)

    async def start(self, command: str, key: str | None = None) -> Mission | Heard:
        """Obeys an order ('stop') at once, and takes back what is denied. Else reads the command, checks what was read,
        and puts a mission for each thing it names into the queue; the first begins at once where nothing runs. With
        `key`, the same request again answers with the same mission.

        Raises `ConflictError` while stopped, low on power or being restored, `UnprocessableError` when the command
        names nothing known or asks for nothing (its `code` says why) or the key was used for another command,
        `TooManyError` when the queue is full, `UnavailableError` without a robot, a parser or an opened history.
        """
        if not command.strip():
            raise UnprocessableError("the command is empty")
        order = order_in(command)
        asked = command if order is None else order.rest
        reading = read(asked)
        if order is not None:
            heard = await self.orders.obey(order.mood)
            if reading.mood is not Mood.FIND or not reading.sure:
                return heard
        to_dock = is_docking(asked)
        if is_foreign(asked) and not to_dock:
            return self.orders.take_back(Reading(Mood.UNKNOWN, ""))
        if reading.mood is not Mood.FIND and not to_dock:
            return self.orders.take_back(reading)
        with TRACER.command("command", {"command": command}):
            return await self._start(command, None if to_dock else reading, key)

    @property
    def orders_to_end(self) -> int:
        """How often a person has said stop; taken before anything is read or asked for."""
        return self._dispatcher.orders_to_end

    async def begin(self, command: str, work: Work, ended_before: int) -> Mission:
        """Puts into the queue what is understood already: an action's motions, its one search, or the way to the dock
        (none). `command` tells it, `ended_before` is `orders_to_end` as it was when it was asked for. Raises as `start`
        does, but for what concerns words.
        """
        with TRACER.command("action", {"command": command}):
            async with self._starting:
                (made,) = self._put(command, (work,), ended_before)
            return await self._begun(made.id)

    async def _start(self, command: str, reading: Reading | None, key: str | None) -> Mission:
        ended_before = self._dispatcher.orders_to_end
        async with self._starting:
            digest = hashlib.sha256(command.encode()).hexdigest()
            known = await self.log.request(key) if key is not None else None
            if known is not None:
                if known.digest != digest:
                    raise UnprocessableError("this Idempotency-Key was used for another command")
                return await self.get(known.mission_ids[0])
            made = await self._enqueue(command, reading, ended_before)
            if key is not None:
                self.log.keep_request(key, KnownRequest(digest, tuple(one.id for one in made)))
        return await self._begun(made[0].id)

    async def _begun(self, mission_id: str) -> Mission:
        await self._dispatcher.advance()
        await self._save()
        return await self.get(mission_id)

    async def _enqueue(self, command: str, reading: Reading | None, ended_before: int) -> tuple[QueuedMission, ...]:
        """`reading` is none for the way to the dock."""
        self.refuse_now(ended_before, by_its_body=reading is not None)
        works: Sequence[Work] = (None,) if reading is None else await self.reader.tasks(reading, self.last_target)
        return self._put(command, works, ended_before)

    def _put(self, command: str, works: Sequence[Work], ended_before: int) -> tuple[QueuedMission, ...]:
        """Into the queue. What held before the words were read is looked at again."""
        self.refuse_now(ended_before, by_its_body=any(map(goes_by_its_body, works)))
        works = [self._of_this_map(one) if isinstance(one, PlainMotion) else one for one in works]
        request_id, asked_s = uuid.uuid4().hex, self._clock.now_s()
        made = tuple(
            queued(one, uuid.uuid4().hex, command, Order(request_id, part, len(works), asked_s), traceparent())
            for part, one in enumerate(works, start=1)
        )
        self._queue.add(made)
        self._tell_queued({one.id for one in made})
        return made

    async def last_target(self) -> Target | None:
        """What was asked for last, waiting or not; of the history where this process knows of none."""
        waiting = [one.target for one in self._queue.records() if one.target is not None]
        known = waiting[-1] if waiting else self.runner.mission.target
        if known is not None:
            return known
        return next((one.target for one in await self.log.newest(LAST_ASKED) if one.target is not None), None)

    def _tell_queued(self, ids: set[str]) -> None:
        busy = self.runner.mission.state is not MissionState.IDLE
        for position, one in enumerate(self._queue.waiting()):
            if one.id not in ids:
                continue
            record, order = one.record(position), one.order
            part = f" (part {order.part} of {order.parts})" if order.parts > 1 else ""
            if busy or position != 0:
                self.runner.tell(record, EventKind.QUEUED, f"'{one.command}': {one.what}{part} waiting in the queue")
            else:
                self.log.upsert(record)

    def _of_this_map(self, motion: PlainMotion) -> PlainMotion:
        state = self.runner.robot_state
        return replace(motion, map_id=motion.map_id or (state.map_id if state is not None else None))

    def refuse_now(self, ended_before: int, *, by_its_body: bool) -> None:
        """Raises `UnavailableError` and `ConflictError` where nothing can begin. `by_its_body`: it goes by what the
        robot says of its body.
        """
        if not self.log.opened:
            raise UnavailableError("database", "the history of missions is not open yet")
        if self._dispatcher.orders_to_end != ended_before:
            raise ConflictError(
                "a person said stop while it was being read", code=CommandRefusal.STOPPED_MEANWHILE.value
            )
        if self._dispatcher.held:
            raise ConflictError(
                "a back-up is being restored: ask again when that is over", code=BackupRefusal.RESTORING.value
            )
        if self.runner.mission.state is MissionState.EMERGENCY_STOP:
            raise ConflictError("the emergency stop is latched: reset it first")
        if self.runner.robot_state_age_s > self._settings.robot_state_age_s_max:
            raise UnavailableError("robot_bridge", "the robot's state is not coming in")
        if by_its_body and self.runner.description is None:
            raise UnavailableError(
                "robot_bridge",
                "it has not described its robot yet; a camera that sleeps on the dock tells itself after undocking",
            )
        low = self._dispatcher.why_no_power()
        if low:
            raise ConflictError(f"{low}: it has to charge first")

    async def _save(self) -> None:
        try:
            await self.log.flushed()
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

    async def belief(self, mission_id: str) -> SearchBelief:
        """Raises `NotFoundError`, whose `code` is a `NoBelief` where the mission is known."""
        record, running = await self.get(mission_id), self.runner.mission
        if record.outcome is not None:
            raise _no_belief(NoBelief.ENDED)
        if record.queue_position is not None or running.id != mission_id:
            raise _no_belief(NoBelief.NOT_BEGUN)
        if self.runner.believed is None:
            raise _no_belief(NoBelief.ANOTHER_RULE)
        belief = await self.runner.believed.report(mission_id, running.map_id, self._clock.now_s())
        if belief is None:
            raise _no_belief(NoBelief.NOTHING_CHOSEN)
        return belief

    async def recording(self, mission_id: str) -> str:
        await self.get(mission_id)
        lines = await self.log.recording(mission_id)
        if not lines:
            raise NotFoundError("this mission has no recording: it never began, or it is no longer kept")
        return "\n".join(lines) + "\n"

    async def hold(self, hold: RestoreHold) -> RestoreHold:
        """Raises `ConflictError` while a mission runs or waits; one that is being read is waited for. Let go
        meanwhile, it comes to nothing."""
        if hold.seconds > 0.0:
            times_let_go = self._dispatcher.times_let_go
            async with self._starting:
                await self._dispatcher.hold(hold.seconds, times_let_go)
        else:
            self._dispatcher.let_go()
        return hold

    async def restore(self, body: AsyncIterable[bytes], *, dry_run: bool) -> RestoreReply:
        """The history becomes what a snapshot holds; `dry_run`: it is only checked. Raises `ConflictError` while a
        mission runs or waits; one that is asked for meanwhile begins afterwards."""
        candidate = self.log.candidate(body, bytes_max=self._settings.restore_bytes_max)
        replace_by = partial(self.log.replace, now_s=self._clock.now_s())
        return await restored(candidate, replace_by, at_rest=self.at_rest, dry_run=dry_run)

    @asynccontextmanager
    async def at_rest(self) -> AsyncGenerator[None]:
        """Nothing begins inside. Raises `ConflictError` while a mission runs or waits."""
        async with self._starting, self._dispatcher.at_rest():
            yield

    async def cancel(self, mission_id: str) -> Mission:
        if not self._dispatcher.cancel(mission_id):
            return await self._tell(mission_id, ev.CancelRequested())
        return await self.get(mission_id)

    async def pause(self, mission_id: str, *, for_s: float | None = None) -> Mission:
        """`for_s`: while somebody speaks to the robot; it goes on by itself after so long, 0 = now. Raises
        `ConflictError` where a person has paused it already, or it does not run.
        """
        if (await self.get(mission_id)).paused and not self.runner.mission.listening:
            raise ConflictError("it is paused already")
        return await self._tell(mission_id, ev.PauseRequested(for_s))

    async def resume(self, mission_id: str) -> Mission:
        if not (await self.get(mission_id)).paused:
            raise ConflictError("it is not paused")
        return await self._tell(mission_id, ev.ResumeRequested())

    async def _tell(
        self, mission_id: str, event: ev.CancelRequested | ev.PauseRequested | ev.ResumeRequested
    ) -> Mission:
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
            plan = await self.runner.unexplored().plan(self.runner.mission.robot.pose, ())
        except MapError as error:
            raise UnavailableError("robot_bridge", f"the map is malformed: {error}") from error
        return CoveragePlan(
            points=plan.points,
            regions=plan.regions,
            free_area_m2=plan.free_area_m2,
            map_trouble=plan.trouble,
        )

    def measure(self) -> None:
        """What Prometheus is told at a scrape."""
        QUEUE.set(len(self._queue))
        STATE.state(self.runner.mission.state.value)
        ROBOT_STATE_AGE.set(self.runner.robot_state_age_s)

    async def dependencies(self) -> Sequence[Dependency]:
        """Redis, each service, the database, the session, and the robot's state."""
        others = await asyncio.gather(
            self._robot.dependency(), self._inference.dependency(), self._memory.dependency(), self.log.dependency()
        )
        age_s = self.runner.robot_state_age_s
        fresh = age_s <= self._settings.robot_state_age_s_max
        return (
            redis_dependency(self._bus),
            *others,
            Dependency.of("session", ok=self._robot.session_held, detail="with robot_bridge"),
            Dependency.of("robot.description", ok=self.runner.description is not None, detail="its body"),
            Dependency.of("robot.state", ok=fresh, detail="fresh" if fresh else "not coming in"),
        )


def _no_belief(why: NoBelief) -> NotFoundError:
    return NotFoundError(f"no belief: {NO_BELIEF[why]}", code=why.value)
