"""What a fetch asks of the shell. Each with a `call` is answered by one event of that number."""

from dataclasses import dataclass

from contracts.geometry import Pose2D
from contracts.manipulation import FetchCause, FetchEnd, ManipulationState
from coordinator.manipulation.transitions import Task


@dataclass(frozen=True, slots=True)
class FoldArm:
    """The jaw stays as it is."""

    call: int


@dataclass(frozen=True, slots=True)
class MoveJaw:
    """Open, or closed as far as it goes."""

    call: int
    open: bool


@dataclass(frozen=True, slots=True)
class MoveArm:
    """To the place that the task names, of the grasp with this number among those planned last."""

    call: int
    task: Task
    grasp: int


@dataclass(frozen=True, slots=True)
class DriveBase:
    call: int
    pose: Pose2D
    carrying: bool


@dataclass(frozen=True, slots=True)
class PlanStance:
    """Where the robot may stand so that the arm reaches the thing, without those tried."""

    call: int
    tried: tuple[Pose2D, ...]


@dataclass(frozen=True, slots=True)
class LookAtThing:
    call: int


@dataclass(frozen=True, slots=True)
class PlanGrasps:
    """Of the thing as it was seen last."""

    call: int


@dataclass(frozen=True, slots=True)
class PlanSpot:
    """Where the thing can be put down."""

    call: int


@dataclass(frozen=True, slots=True)
class CheckHold:
    call: int


@dataclass(frozen=True, slots=True)
class AwaitHand:
    """Until somebody takes the thing: a button, or a pull at it."""

    call: int


@dataclass(frozen=True, slots=True)
class HaltManipulation:
    """End what moves, wheels and arm; the joints hold, and so does the jaw."""


@dataclass(frozen=True, slots=True)
class TellFetchState:
    """For the timeline."""

    state: ManipulationState
    why: str


@dataclass(frozen=True, slots=True)
class FinishFetch:
    end: FetchEnd
    cause: FetchCause | None = None
    folded: bool = True


MOTION = FoldArm | MoveJaw | MoveArm | DriveBase
ASKING = PlanStance | LookAtThing | PlanGrasps | PlanSpot | CheckHold | AwaitHand
Command = MOTION | ASKING | HaltManipulation | TellFetchState | FinishFetch
