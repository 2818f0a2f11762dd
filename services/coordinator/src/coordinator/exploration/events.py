"""What happens to an exploration. `call` names the command that is answered; answers to others are too late."""

from dataclasses import dataclass
from enum import StrEnum

from contracts.exploration import ExplorationDecision, ExploredRoom
from contracts.geometry import Pose2D
from contracts.motion import MotionEnd
from coordinator.exploration.frontiers import Chart
from coordinator.exploration.surroundings import Surroundings


@dataclass(frozen=True, slots=True)
class Begun:
    """Somebody asks for an exploration; home is where the robot is, unless it knows better."""

    home: Pose2D


@dataclass(frozen=True, slots=True)
class RobotSeen:
    """The newest of the robot: its pose in the map, its scan, whether the emergency stop is on, and its epoch."""

    pose: Pose2D | None
    surroundings: Surroundings | None
    stopped: bool = False
    epoch: int | None = None
    """Rises with every stop. None: the robot tells nothing."""
    map_id: str | None = None
    """Which map its pose is in. None: it has no name yet, or the robot tells nothing."""


@dataclass(frozen=True, slots=True)
class ChartSeen:
    chart: Chart
    rooms: tuple[ExploredRoom, ...] = ()


@dataclass(frozen=True, slots=True)
class ViewSeen:
    """The hash of the newest picture; see `views`. None: there is no picture any more."""

    view: int | None


@dataclass(frozen=True, slots=True)
class ModelAnswered:
    """`decision` is none where the answer was not one of the tools within their bounds; `detail` says why."""

    call: int
    decision: ExplorationDecision | None
    tokens: int = 0
    detail: str = ""


@dataclass(frozen=True, slots=True)
class ModelFailed:
    """No answer: nobody there, out of time, an error."""

    call: int
    detail: str = ""


@dataclass(frozen=True, slots=True)
class LinkChanged:
    """The network to the model is up or down."""

    up: bool


@dataclass(frozen=True, slots=True)
class MotionOver:
    """A turn or a drive is over. Of a call that was refused or not answered the end is none."""

    call: int
    end: MotionEnd | None


class GoalOutcome(StrEnum):
    """What became of a goal of Nav2's."""

    REACHED = "reached"
    NOT_REACHED = "not_reached"
    """It was driven to, and not reached: it says something of the place."""
    FAILED = "failed"
    """It was not taken, or somebody else ended it: it says nothing of the place."""


@dataclass(frozen=True, slots=True)
class GoalOver:
    call: int
    outcome: GoalOutcome


@dataclass(frozen=True, slots=True)
class ListenStarted:
    """Somebody speaks to the robot; it listens no longer than `for_s`."""

    for_s: float


@dataclass(frozen=True, slots=True)
class ListenEnded:
    pass


@dataclass(frozen=True, slots=True)
class ExplorationCanceled:
    pass


@dataclass(frozen=True, slots=True)
class TimePassed:
    """Time passes; told a few times a second."""


Event = (
    Begun
    | RobotSeen
    | ChartSeen
    | ViewSeen
    | ModelAnswered
    | ModelFailed
    | LinkChanged
    | MotionOver
    | GoalOver
    | ListenStarted
    | ListenEnded
    | ExplorationCanceled
    | TimePassed
)
