"""What the coordinator needs of the other services and of its log; the real twins are in `adapters`."""

from collections.abc import AsyncIterable, AsyncIterator, Sequence
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from typing import Protocol

from contracts.geometry import Twist2D
from contracts.language import ReasonReply, ReasonRequest
from contracts.memory import LabelCount, LookBatch, RecallReply, RecallRequest, RememberedObject, View
from contracts.mission import Mission, MissionEvent
from contracts.motion import BaseReply, DriveReply, RotateReply
from contracts.problem import Dependency
from contracts.robot import EmergencyStop, Goal, GoalRequest, Map, VelocityReply
from contracts.rooms import RoomGrid, RoomsReply
from contracts.vision import ParsedTask, ParseTaskRequest, ValidateRequest, Validation
from store.copies import DatabaseCopy, JudgedDatabase


class Robot(Protocol):
    """robot_bridge. Everything raises `UnavailableError` or `UpstreamError`; motion also while no session is held.

    Cancelling `rotate`, `drive` or `undock` ends that motion.
    """

    @property
    def session_held(self) -> bool: ...

    async def hold_session(self) -> None:
        """Keeps a session open for ever: what was asked for in it ends when this process does."""
        ...

    async def drop_session(self) -> None:
        """Ends everything asked for in the session, answered or not; another one is opened soon."""
        ...

    async def map(self) -> Map: ...
    async def navigate(self, request: GoalRequest) -> Goal:
        """In this process's session. A goal outside the map is ABORTED as unreachable."""
        ...

    async def goal(self, goal_id: str) -> Goal: ...
    async def cancel_goal(self, goal_id: str) -> Goal: ...
    async def rotate(self, angle_rad: float, *, speed_rad_s: float, timeout_s: float, epoch: int) -> RotateReply: ...
    async def drive(self, distance_m: float, *, speed_m_s: float, timeout_s: float, epoch: int) -> DriveReply: ...
    async def velocity(self, twist: Twist2D, *, duration_s: float, epoch: int) -> VelocityReply: ...
    async def end_motion(self) -> None: ...
    async def halt(self) -> EmergencyStop:
        """Ends all motion, whoever asked for it, and latches nothing; what was asked for before is refused."""
        ...

    async def emergency_stop(self, reason: str) -> EmergencyStop: ...
    async def undock(self, *, timeout_s: float) -> BaseReply: ...
    async def dock(self, *, timeout_s: float) -> BaseReply: ...
    async def celebrate(self) -> None: ...
    async def dependency(self) -> Dependency: ...


class Camera(Protocol):
    async def frame(self) -> bytes:
        """The newest picture, JPEG. Raises `UnavailableError` or `UpstreamError`."""
        ...


class Inference(Protocol):
    """inference."""

    async def parse_task(self, request: ParseTaskRequest) -> ParsedTask: ...
    async def validate(self, request: ValidateRequest, *, timeout_s: float) -> Validation: ...
    async def evidence(self, validation_id: str) -> bytes:
        """The crop that was judged, JPEG; `UpstreamError` 404 for one that is not kept any more."""
        ...

    async def reason(self, request: ReasonRequest) -> ReasonReply:
        """`UnavailableError` where no language model is there."""
        ...

    async def dependency(self) -> Dependency: ...


class Memory(Protocol):
    """memory."""

    async def labels(self) -> Sequence[LabelCount]: ...
    async def recall(self, request: RecallRequest) -> RecallReply: ...
    async def looks(self, batch: LookBatch) -> None:
        """`UpstreamError` 404 from a memory that takes no looks."""
        ...

    async def views(self, label: str, limit: int) -> Sequence[View]: ...
    async def objects(self, label: str | None, limit: int, room_id: int | None = None) -> Sequence[RememberedObject]:
        """Most believed first, of the whole home or of one room; an older memory knows no rooms and gives all.
        `UpstreamError` 404 from a memory that knows views only."""
        ...

    async def rooms(self) -> RoomsReply:
        """`UpstreamError` 404 from a memory that names no rooms."""
        ...

    async def room_grid(self) -> RoomGrid:
        """Where those rooms lie; `UpstreamError` 404 where there is no map now, or from such a memory."""
        ...

    async def dependency(self) -> Dependency: ...


@dataclass(frozen=True, slots=True)
class KnownRequest:
    """What an idempotency key was used for: a digest of what was asked, and the missions it made."""

    digest: str
    mission_ids: tuple[str, ...]


class MissionLog(Protocol):
    """Missions, their timelines, recordings and pictures. Writing never waits; reading sees what was written before.

    Reading and `saved` raise `UnavailableError` while the database is away.
    """

    @property
    def opened(self) -> bool:
        """False until it could be opened for the first time: till then little is kept, and events begin at 0."""
        ...

    @property
    def next_event_id(self) -> int: ...

    def upsert(self, mission: Mission) -> None:
        """Adds it, or replaces it by its id."""
        ...

    def append(self, event: MissionEvent) -> None: ...
    def record(self, mission_id: str, line: str) -> None:
        """One more line of its recording (`core.recording`)."""
        ...

    def keep_picture(self, mission_id: str, number: int, jpeg: bytes) -> None: ...
    def keep_request(self, key: str, request: KnownRequest) -> None: ...

    async def flushed(self) -> None:
        """Returns when everything written so far would survive this process."""
        ...

    async def get(self, mission_id: str) -> Mission | None: ...
    async def newest(self, limit: int, *, before: str | None = None) -> tuple[Mission, ...]:
        """Newest first; only those older than mission `before`. Raises `NotFoundError` for one that is not known."""
        ...

    async def events(self, mission_id: str, *, after: int, limit: int) -> tuple[MissionEvent, ...]: ...
    def follow(self, *, after: int | None) -> AsyncIterator[MissionEvent]:
        """What is kept with a higher id (none: only what is new), then each event as it comes."""
        ...

    async def recording(self, mission_id: str) -> tuple[str, ...]: ...
    async def picture(self, mission_id: str, number: int) -> bytes | None: ...
    async def request(self, key: str) -> KnownRequest | None: ...
    async def snapshot(self) -> DatabaseCopy:
        """Everything at one moment, as an SQLite file; writing goes on. `ConflictError` while another copy is made."""
        ...

    def candidate(self, body: AsyncIterable[bytes], *, bytes_max: int) -> AbstractAsyncContextManager[JudgedDatabase]:
        """A snapshot that came back, judged, for `replace` inside the block. `TooLargeError`, `UnprocessableError`."""
        ...

    async def replace(self, candidate: JudgedDatabase, now_s: float) -> str:
        """All or nothing, while no mission runs; the name of the file that keeps what was there before. Missions that
        ran when the snapshot was made end as interrupted. Ids of events go on rising, over a restart too."""
        ...

    async def dependency(self) -> Dependency: ...
