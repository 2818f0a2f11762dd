"""Missions that wait for their turn: each thing of a command is one, in the order said."""

from collections import deque
from dataclasses import dataclass

from contracts import mission as wire
from contracts.intent import WantedAction
from contracts.mission import MissionKind, MissionState
from coordinator.core.mission import Order
from coordinator.core.motions import PlainMotion
from coordinator.queue.parse_validation import CheckedTask
from mesh.errors import TooManyError
from mesh.tracing import trace_id_of


@dataclass(frozen=True, slots=True)
class QueuedMission:
    """A search (`task`), plain motions (`motion`), or neither: the way to the dock."""

    id: str
    command: str
    task: CheckedTask | None
    order: Order
    traceparent: str = ""
    """Of the command it came from."""
    motion: PlainMotion | None = None

    @property
    def kind(self) -> MissionKind:
        if self.task is not None:
            return MissionKind.FIND
        return MissionKind.DOCK if self.motion is None else MissionKind.MOVE

    @property
    def action(self) -> WantedAction:
        if self.task is not None:
            return self.task.action
        return WantedAction.DOCK if self.motion is None else self.motion.action

    @property
    def what(self) -> str:
        """For a person."""
        if self.task is not None:
            return self.task.target.description
        return "the dock" if self.motion is None else self.motion.what

    def record(self, position: int) -> wire.Mission:
        asked_s = max(0.0, self.order.asked_s or 0.0)
        return wire.Mission(
            id=self.id,
            kind=self.kind,
            command=self.command,
            target=self.task.target if self.task is not None else None,
            parser=self.task.parser if self.task is not None else "",
            action=self.action,
            rooms=self.task.rooms if self.task is not None else (),
            state=MissionState.IDLE,
            queue_position=position,
            request_id=self.order.request_id,
            part=self.order.part,
            parts=self.order.parts,
            reason="waiting in the queue",
            asked_s=asked_s,
            started_s=asked_s,
            trace_id=trace_id_of(self.traceparent),
        )


Work = CheckedTask | PlainMotion | None
"""A search, plain motions, or the way to the dock."""


def goes_by_its_body(work: Work) -> bool:
    """Whether it cannot begin before the robot has described itself. The way off the dock does not ask for it: there
    the camera sleeps, and tells of itself afterwards.
    """
    return work is not None and not (isinstance(work, PlainMotion) and not work.legs and not work.explores)


def queued(work: Work, mission_id: str, command: str, order: Order, traceparent: str) -> QueuedMission:
    motion = work if isinstance(work, PlainMotion) else None
    task = work if isinstance(work, CheckedTask) else None
    return QueuedMission(mission_id, command, task, order, traceparent, motion)


class MissionQueue:
    def __init__(self, most: int) -> None:
        self._most = most
        self._waiting: deque[QueuedMission] = deque()

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, some: tuple[QueuedMission, ...]) -> None:
        """All of them or none. Raises `TooManyError`."""
        if len(self._waiting) + len(some) > self._most:
            raise TooManyError(f"{len(self._waiting)} missions wait already; at most {self._most} may")
        self._waiting.extend(some)

    def pop(self) -> QueuedMission | None:
        return self._waiting.popleft() if self._waiting else None

    def remove(self, mission_id: str) -> QueuedMission | None:
        found = next((one for one in self._waiting if one.id == mission_id), None)
        if found is not None:
            self._waiting.remove(found)
        return found

    def clear(self) -> tuple[QueuedMission, ...]:
        some = tuple(self._waiting)
        self._waiting.clear()
        return some

    def records(self) -> tuple[wire.Mission, ...]:
        return tuple(one.record(k) for k, one in enumerate(self._waiting))

    def waiting(self) -> tuple[QueuedMission, ...]:
        """The next one first."""
        return tuple(self._waiting)
