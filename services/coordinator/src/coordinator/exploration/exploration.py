"""An exploration as it stands: one immutable value, and what it is doing inside its mode."""

import math
from dataclasses import dataclass, field
from enum import StrEnum

from contracts.exploration import (
    AskingReason,
    DecisionVerdict,
    ExplorationEnd,
    ExplorationMemory,
    ExplorationMode,
)
from contracts.geometry import Pose2D
from coordinator.exploration.decision_check import Advance, BlockedTry
from coordinator.exploration.frontiers import Chart, Frontier
from coordinator.exploration.rules import ExplorationRules
from coordinator.exploration.surroundings import PlaceKind, Surroundings

NEVER_S = -math.inf


@dataclass(frozen=True, slots=True)
class Standing:
    """Nothing is under way."""


@dataclass(frozen=True, slots=True)
class Turning:
    """On the spot; `then` is what follows, checked anew."""

    call: int
    until_s: float
    tool: str
    then: Advance | None = None


@dataclass(frozen=True, slots=True)
class Settling:
    """Turned: waits for a scan that was taken since."""

    since_s: float
    until_s: float
    tool: str
    then: Advance


@dataclass(frozen=True, slots=True)
class Advancing:
    call: int
    until_s: float
    tool: str
    heading_rad: float


@dataclass(frozen=True, slots=True)
class Going:
    """A goal of Nav2's."""

    call: int
    until_s: float
    tool: str
    pose: Pose2D


Activity = Standing | Turning | Settling | Advancing | Going


@dataclass(frozen=True, slots=True)
class OpenQuestion:
    """One that is not answered yet. `turns`: tools that moved nothing, in this question so far."""

    call: int
    asked_s: float
    turns: int = 0


@dataclass(frozen=True, slots=True)
class Asked:
    """What the model was shown last: from then on the robot's way, the time and the change of the view count."""

    at_s: float
    pose: Pose2D | None
    view: int | None
    place: PlaceKind
    reason: AskingReason


class Fallback(StrEnum):
    """Why the model does not lead though it should."""

    SILENT = "silent"
    """It owes an answer."""
    REFUSED = "refused"
    """Too many of its decisions were refused in a row, or there was nothing new to ask it about however the robot
    turned: one stretch goes without it."""
    SPENT = "spent"
    """Its calls, tokens or seconds are used up."""


@dataclass(frozen=True, slots=True)
class Spent:
    calls: int = 0
    tokens: int = 0
    seconds: float = 0.0
    by_reason: tuple[tuple[AskingReason, int], ...] = ()


@dataclass(frozen=True, slots=True)
class Exploration:
    """All that `step` knows."""

    rules: ExplorationRules = field(default_factory=ExplorationRules)
    mode: ExplorationMode = ExplorationMode.IDLE
    why: str = ""
    listening_before: ExplorationMode | None = None
    """The mode that goes on when nobody says more."""
    listen_since_s: float = NEVER_S
    listen_until_s: float = NEVER_S
    activity: Activity = field(default_factory=Standing)
    home: Pose2D | None = None
    home_tries: int = 0
    """Goals home that were driven to, and not reached."""
    motions: int = 0
    """Turns, drives and goals that were made, however they ended."""
    failures: int = 0
    """Motions in a row that were not taken, or that somebody else ended."""
    hold_until_s: float = NEVER_S
    """Nothing that moves is begun before, after such a failure."""
    started_s: float = 0.0
    """Put off by what it listened: its time is counted from here."""
    begun_s: float = 0.0
    end: ExplorationEnd | None = None
    """Why it goes home, or has ended."""
    # the model
    question: OpenQuestion | None = None
    dropped: tuple[int, ...] = ()
    """Calls that nobody waits for any more; what they cost is counted when they are answered after all."""
    asked: Asked | None = None
    silent_since_s: float | None = None
    link_up: bool = True
    ask_again_s: float = NEVER_S
    refusals: int = 0
    looked_elsewhere: int = 0
    """Turns in a row for a view that does not change."""
    fallback: Fallback | None = None
    spent: Spent = field(default_factory=Spent)
    told: tuple[Frontier, ...] = ()
    # the robot
    pose: Pose2D | None = None
    surroundings: Surroundings | None = None
    stopped: bool = False
    epoch: int | None = None
    """Of the emergency stop, as it was told last: what moves is asked for in it."""
    map_id: str | None = None
    """The last that was named."""
    view: int | None = None
    chart: Chart | None = None
    unknown_seen: bool = False
    """Some map of this exploration had a frontier."""
    charts_without: int = 0
    """So many maps in a row had no frontier left."""
    visits: tuple[tuple[Pose2D, int], ...] = ()
    tries: tuple[BlockedTry, ...] = ()
    memory: ExplorationMemory = field(default_factory=ExplorationMemory)
    next_call: int = 1
    verdicts: tuple[tuple[DecisionVerdict, int], ...] = ()
    """How often each came of what the model decided."""

    @property
    def running(self) -> bool:
        return self.mode is not ExplorationMode.IDLE

    @property
    def moving(self) -> bool:
        return not isinstance(self.activity, Standing | Settling)
