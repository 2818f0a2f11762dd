"""What the robot does next: the mission whose turn it is, or the way to the dock; one at a time."""

import asyncio
import math
import uuid
from collections.abc import AsyncGenerator, Sequence
from contextlib import asynccontextmanager

import structlog

from contracts.backup import BackupRefusal
from contracts.memory import RecalledView, RecallRequest, RememberedObject
from contracts.mission import EndCause, EventFacts, EventKind, LastSeen, MissionState, Outcome, Report, SearchedRoom
from coordinator.belief.clues import clues
from coordinator.commands.kept_to_rooms import KeptRooms, NoSuchRoomsError, clues_inside, kept_to, shows_inside
from coordinator.core import events as ev
from coordinator.core.area import SearchArea
from coordinator.core.mission import Order, SearchPose
from coordinator.core.motions import PlainMotion
from coordinator.core.rules import CoverageRule
from coordinator.execution.battery_policy import DockingTimer, PowerRules, reason_to_dock, why_too_low
from coordinator.execution.mission_runner import MissionRunner
from coordinator.ports import Memory
from coordinator.queue.mission_queue import MissionQueue, QueuedMission
from coordinator.queue.parse_validation import CheckedTask
from coordinator.settings import Settings
from geometry.room_grids import RoomGridError
from mesh.clock import Clock
from mesh.errors import ConflictError, MeshError
from mesh.tracing import following
from vocabulary.rooms import called

log = structlog.get_logger()


THINGS_MAX = 200
RECALLED_MAX = 200
"""Of the whole home, where only those in some rooms are wanted."""
IN_ANOTHER_MAP = "also remembered on another map, whose places do not apply here"


class Dispatcher:
    def __init__(
        self, *, settings: Settings, runner: MissionRunner, queue: MissionQueue, memory: Memory, clock: Clock
    ) -> None:
        self._settings = settings
        self._runner = runner
        self._queue = queue
        self._memory = memory
        self._clock = clock
        self._power = PowerRules(settings.battery_low_percent, settings.battery_period_s, settings.dock_again_s)
        self._watch = DockingTimer()
        self._turn = asyncio.Lock()
        self._held_until_s = -math.inf
        self.times_let_go = 0
        self._beginning: QueuedMission | None = None
        """Taken from the queue, while memory is asked for hints."""
        self.orders_to_end = 0
        """How often a person said that everything is to end: what was asked for before, and has not begun, does not."""

    async def run(self) -> None:
        while True:
            await self.advance()
            await self._clock.sleep(self._settings.tick_period_s)

    async def advance(self) -> None:
        """Begins what is due; returns at once while something runs or begins."""
        if self._turn.locked():
            return
        async with self._turn:
            state = self._runner.mission.state
            if state is MissionState.EMERGENCY_STOP:
                self._end_waiting(EndCause.STOPPED, "an emergency stop: nothing begins by itself afterwards")
            elif state is MissionState.IDLE and not self.held:
                await self._next()

    @asynccontextmanager
    async def at_rest(self) -> AsyncGenerator[None]:
        """Nothing begins inside. Raises `ConflictError` while a mission runs or waits."""
        async with self._turn:
            mission = self._runner.mission
            if mission.running or not mission.state.settled or len(self._queue):  # after a find it may celebrate still
                raise ConflictError(
                    "a mission runs or waits: cancel it, or wait for its end", code=BackupRefusal.MISSION_ON.value
                )
            yield

    @property
    def held(self) -> bool:
        """Nothing begins, and nothing may be put into the queue."""
        return self._clock.now_s() < self._held_until_s

    async def hold(self, seconds: float, times_let_go: int) -> None:
        """From now on nothing begins for so long. Raises `ConflictError` while a mission runs or waits, and where
        `let_go` has come since it had been called `times_let_go` times: whoever asked for it has given up."""
        async with self.at_rest():
            if self.times_let_go != times_let_go:
                raise ConflictError("it was let go before it began")
            self._held_until_s = self._clock.now_s() + seconds

    def let_go(self) -> None:
        self.times_let_go += 1
        self._held_until_s = -math.inf

    def why_no_power(self) -> str:
        return why_too_low(self._runner.robot_state, self._power)

    def cancel(self, mission_id: str) -> bool:
        """True when it waited in the queue or was about to begin, and does no more."""
        if self._beginning is not None and self._beginning.id == mission_id:
            self._beginning = None
            return True
        waiting = self._queue.remove(mission_id)
        if waiting is not None:
            self._close(waiting, Outcome.CANCELED, EndCause.PERSON, "cancelled by the operator before it began")
        return waiting is not None

    def end_all(self, why: str) -> tuple[str, ...]:
        """Ends what runs, begins or waits; the ids of it. Returns at once."""
        self.orders_to_end += 1
        ended = [self._cancel_waiting(waiting, why) for waiting in self._queue.clear()]
        return (*self._end_begun(), *ended)

    def end_those_for(self, label: str | None, why: str) -> tuple[str, ...]:
        """The same for what looks for `label`; for everything where none is named."""
        if label is None:
            return self.end_all(why)
        sought = [one for one in self._queue.records() if one.target is not None and one.target.label == label]
        removed = [waiting for one in sought if (waiting := self._queue.remove(one.id)) is not None]
        ended = [self._cancel_waiting(waiting, why) for waiting in removed]
        beginning, target = self._beginning, self._runner.mission.target
        begins = beginning is not None and beginning.task is not None and beginning.task.target.label == label
        runs = self._runner.mission.running and target is not None and target.label == label
        return (*(self._end_begun() if begins or runs else ()), *ended)

    def _end_begun(self) -> tuple[str, ...]:
        ended: list[str] = []
        if self._beginning is not None:
            ended.append(self._beginning.id)
            self._beginning = None
        if self._runner.mission.running:
            ended.append(self._runner.mission.id)
            self._runner.feed(ev.CancelRequested())
        return tuple(ended)

    def _cancel_waiting(self, waiting: QueuedMission, why: str) -> str:
        self._close(waiting, Outcome.CANCELED, EndCause.PERSON, why)
        return waiting.id

    async def _next(self) -> None:
        low = self.why_no_power()
        if low:
            self._end_waiting(EndCause.BATTERY, f"it was not begun: {low}")
        self._watch, why = reason_to_dock(self._watch, self._runner.robot_state, self._clock.now_s(), self._power)
        if why:
            with following(""):  # nobody's command
                self._dock(uuid.uuid4().hex, why, Order(asked_s=self._clock.now_s()))
            return
        waiting = self._queue.pop()
        if waiting is None:
            return
        with following(waiting.traceparent):
            if waiting.task is not None:
                await self._begin(waiting, waiting.task)
            elif waiting.motion is not None:
                self._move(waiting, waiting.motion)
            else:
                self._dock(waiting.id, "requested by the operator", waiting.order)

    def _move(self, waiting: QueuedMission, motion: PlainMotion) -> None:
        now_in = self._runner.mission.robot.map_id
        if motion.map_id is not None and now_in is not None and motion.map_id != now_in:
            self._close(waiting, Outcome.ABORTED, EndCause.MAP, "its places are of another map than the robot's now")
            return
        self._runner.begin(ev.MotionStarted(waiting.id, waiting.command, motion, waiting.order))

    def _dock(self, mission_id: str, why: str, order: Order) -> None:
        self._runner.begin(ev.DockingStarted(mission_id, why, order))

    async def _begin(self, waiting: QueuedMission, task: CheckedTask) -> None:
        self._beginning = waiting
        kept, no_rooms = await self._kept_to(task)
        recalled, note = await self._recall(task, kept.area if kept is not None else None)
        things = await self._things()
        if not self._still_begins(waiting):
            self._close(waiting, Outcome.CANCELED, EndCause.PERSON, "ended by the operator before it began")
            return
        if self._runner.mission.state is not MissionState.IDLE:  # stopped meanwhile
            self._close(waiting, Outcome.ABORTED, EndCause.STOPPED, "an emergency stop before it began")
            return
        if no_rooms is not None:
            self._close(waiting, Outcome.ABORTED, *no_rooms)
            return
        area = kept.area if kept is not None else None
        gone = _called(kept.gone) if kept is not None else ""
        no_more = f"the map shows {gone} no more" if gone else ""
        told = clues(task.target, recalled, things) if self._by_belief else ()
        self._runner.begin(
            ev.MissionStarted(
                mission_id=waiting.id,
                command=waiting.command,
                target=task.target,
                parser=task.parser,
                action=task.action,
                views=tuple(_place(one) for one in recalled),
                notes="; ".join(part for part in (task.notes, no_more, note) if part),
                order=waiting.order,
                last_seen=_last_seen(recalled, task),
                clues=clues_inside(told, area) if area is not None else told,
                area=area,
                elsewhere=kept.elsewhere if kept is not None else (),
            )
        )

    def _still_begins(self, waiting: QueuedMission) -> bool:
        begins, self._beginning = self._beginning is waiting, None
        return begins

    async def _kept_to(self, task: CheckedTask) -> tuple[KeptRooms | None, tuple[EndCause, str] | None]:
        """Where the rooms lie that it keeps to; or why nobody can tell: then it looks nowhere."""
        if not task.rooms:
            return None, None
        where, map_id = _called(task.rooms), self._runner.mission.robot.map_id
        try:
            async with asyncio.timeout(self._settings.recall_timeout_s):
                return await kept_to(task.rooms, task.target, self._memory, map_id=map_id), None
        except NoSuchRoomsError:
            return None, (EndCause.MAP, f"the map shows {where} no more")
        except (MeshError, RoomGridError, TimeoutError) as error:
            log.warning("nobody tells where the rooms lie", error=str(error))
            return None, (EndCause.SERVICE, f"memory does not tell where {where} lies")

    async def _recall(self, task: CheckedTask, area: SearchArea | None) -> tuple[Sequence[RecalledView], str]:
        if self._settings.memory_views_max == 0:
            return (), ""
        request = RecallRequest(
            target=task.target,
            memory_object=task.memory_object,
            pose=self._runner.mission.robot.pose,
            limit=self._settings.memory_views_max if area is None else RECALLED_MAX,
        )
        try:
            async with asyncio.timeout(self._settings.recall_timeout_s):
                reply = await self._memory.recall(request)
                views = tuple(one for one in reply.views if one.view.colour not in task.target.not_colours)
                if area is not None:
                    views = tuple(one for one in views if shows_inside(one, area))[: self._settings.memory_views_max]
                return views, IN_ANOTHER_MAP if reply.in_other_maps else ""
        except (MeshError, TimeoutError) as error:
            log.warning("nothing was recalled", error=str(error))
            return (), "memory gave no places"

    @property
    def _by_belief(self) -> bool:
        return self._settings.coverage_rule is CoverageRule.BELIEF

    async def _things(self) -> Sequence[RememberedObject]:
        """All that memory knows, for what stands near what; a belief alone asks for it."""
        if not self._by_belief or self._settings.memory_views_max == 0:
            return ()
        try:
            async with asyncio.timeout(self._settings.recall_timeout_s):
                return await self._memory.objects(None, THINGS_MAX)
        except (MeshError, TimeoutError) as error:
            log.warning("no surroundings from memory", error=str(error))
            return ()

    def _end_waiting(self, by: EndCause, why: str) -> None:
        for waiting in self._queue.clear():
            self._close(waiting, Outcome.ABORTED, by, why)

    def _close(self, waiting: QueuedMission, outcome: Outcome, by: EndCause, why: str) -> None:
        text = f"{outcome.value}: {why}"
        record = waiting.record(0).model_copy(
            update={
                "queue_position": None,
                "outcome": outcome,
                "reason": text,
                "ended_s": max(0.0, self._clock.now_s()),
                "report": Report(text=text, ended_by=by, cause=why[:500]),
            }
        )
        self._runner.tell(record, EventKind.END, text, EventFacts(outcome=outcome))


def _place(recalled: RecalledView) -> SearchPose:
    view = recalled.view
    reason = recalled.reason or f"{view.label} seen at confidence {view.confidence:.2f}"
    thing = recalled.thing if recalled.source == "label" else None  # nobody drives up to what it may be near
    thing_xy = (thing.position.x, thing.position.y) if thing is not None else None
    return SearchPose(recalled.pose or view.pose, reason, thing_xy)


def _called(rooms: Sequence[SearchedRoom]) -> str:
    """For a person: 'the kitchen and the bedroom'."""
    return " and ".join(called(one.name) for one in rooms)


def _last_seen(recalled: Sequence[RecalledView], task: CheckedTask) -> LastSeen | None:
    """The newest recalled view of the thing itself, of its colour or of an unknown one."""
    own = [one.view for one in recalled if task.target.may_be(one.view.label, one.view.colour)]
    newest = max(own, key=lambda view: view.stamp_s, default=None)
    if newest is None:
        return None
    return LastSeen(label=newest.label, colour=newest.colour, pose=newest.pose, stamp_s=newest.stamp_s)
