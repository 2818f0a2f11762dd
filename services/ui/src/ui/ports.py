"""What the page needs of the other services; the real twins are in `adapters`.

Every call raises `UnavailableError` when the service is away and `UpstreamError` when it says no.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from contracts.mission import Mission, MissionEvent, MissionStatus
from contracts.problem import Dependency
from contracts.robot import EmergencyStopReply, EmergencyStopRequest, Map, MotionReply, RobotState


@dataclass(frozen=True, slots=True)
class Frame:
    """An annotated camera picture."""

    stamp_s: float
    jpeg: bytes


class Robot(Protocol):
    """robot_bridge. `emergency_stop` shares nothing with the other calls, not even a connection pool."""

    async def emergency_stop(self, request: EmergencyStopRequest) -> EmergencyStopReply: ...
    async def reset(self, request: EmergencyStopRequest) -> EmergencyStopReply: ...
    async def state(self) -> RobotState: ...
    async def map(self) -> Map: ...
    async def dock(self) -> MotionReply: ...
    async def undock(self) -> MotionReply: ...
    async def dependency(self) -> Dependency: ...


class Eyes(Protocol):
    """inference."""

    async def annotated(self, *, after_s: float | None, wait_s: float) -> Frame | None:
        """The newest frame, once it is another than the one taken at `after_s`; none when none came in time."""
        ...

    async def dependency(self) -> Dependency: ...


class Missions(Protocol):
    """coordinator."""

    async def start(self, command: str) -> Mission: ...
    async def pause(self, mission_id: str) -> Mission: ...
    async def resume(self, mission_id: str) -> Mission: ...
    async def cancel(self, mission_id: str) -> Mission: ...
    async def status(self) -> MissionStatus: ...
    async def events(self, mission_id: str) -> Sequence[MissionEvent]:
        """Its timeline, oldest first."""
        ...

    async def dependency(self) -> Dependency: ...


class Memory(Protocol):
    """memory."""

    async def dependency(self) -> Dependency: ...
