"""What an exploration needs of the robot's senses, of whoever leads it, and of its journal."""

from collections.abc import AsyncIterable
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from typing import Protocol

from contracts.exploration import ExplorationDecision, ExplorationMemory
from contracts.laser import LaserScan
from contracts.obstacles import Obstacles
from contracts.robot import RobotState
from coordinator.exploration.commands import AskModel
from coordinator.ports import Robot
from store.copies import DatabaseCopy, JudgedDatabase


class ExploringRobot(Robot, Protocol):
    """robot_bridge, with what it senses."""

    async def state(self) -> RobotState: ...
    async def scan(self) -> LaserScan:
        """`UnavailableError` while the laser is silent."""
        ...

    async def obstacles(self) -> Obstacles: ...


@dataclass(frozen=True, slots=True)
class PilotAnswer:
    """`decision` is none where what came was none of the tools within their bounds; `detail` says why."""

    decision: ExplorationDecision | None
    tokens: int = 0
    detail: str = ""


class Pilot(Protocol):
    """A language model that chooses among the typed tools, or a program that does."""

    async def decide(self, question: AskModel) -> PilotAnswer:
        """Raises `MeshError` where nobody answers."""
        ...


class Eye(Protocol):
    async def view(self) -> int | None:
        """The hash of the newest picture (`exploration.views`); none where there is none."""
        ...


class Journal(Protocol):
    """Where what is known of each home is kept; `home` is robot_bridge's name of its map. Writing never waits."""

    async def read(self, home: str) -> ExplorationMemory:
        """Raises `UnavailableError`."""
        ...

    def write(self, home: str, memory: ExplorationMemory) -> None: ...


class CopiedJournal(Journal, Protocol):
    """A journal that is backed up and restored; each raises `UnavailableError` where its database is away."""

    async def snapshot(self) -> DatabaseCopy:
        """All homes at one moment, as an SQLite file. `ConflictError` while another copy is made."""
        ...

    def candidate(self, body: AsyncIterable[bytes], *, bytes_max: int) -> AbstractAsyncContextManager[JudgedDatabase]:
        """A snapshot that came back, judged, for `replace` inside the block. `TooLargeError`, `UnprocessableError`."""
        ...

    async def replace(self, candidate: JudgedDatabase) -> str:
        """All or nothing, while nothing is explored; the name of the file that keeps what was there before."""
        ...
