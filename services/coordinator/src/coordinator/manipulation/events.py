"""What happens to a fetch. `call` names the command that is answered; answers to others are too late."""

from dataclasses import dataclass

from contracts.arm import ArmEnd
from contracts.geometry import Pose2D
from contracts.manipulation import FetchCause, Holding


@dataclass(frozen=True, slots=True)
class FetchBegun:
    """Somebody wants a thing that was found. `goal`: where the robot is to bring it, to be handed over or put down."""

    goal: Pose2D
    hand_over: bool = True


@dataclass(frozen=True, slots=True)
class FetchCanceled:
    pass


@dataclass(frozen=True, slots=True)
class StopSeen:
    """The emergency stop as it was told last; `epoch` rises with every stop."""

    stopped: bool
    epoch: int | None = None


@dataclass(frozen=True, slots=True)
class ArmMoved:
    """A motion of the arm or its jaw is over."""

    call: int
    end: ArmEnd


@dataclass(frozen=True, slots=True)
class BaseMoved:
    call: int
    reached: bool


@dataclass(frozen=True, slots=True)
class StancePlanned:
    """None: there is no place left."""

    call: int
    stance: Pose2D | None


@dataclass(frozen=True, slots=True)
class ThingLooked:
    call: int
    seen: bool


@dataclass(frozen=True, slots=True)
class GraspsPlanned:
    """How many there are, the best first; of none, why."""

    call: int
    count: int
    cause: FetchCause | None = None


@dataclass(frozen=True, slots=True)
class SpotPlanned:
    call: int
    found: bool


@dataclass(frozen=True, slots=True)
class HoldChecked:
    call: int
    holding: Holding


@dataclass(frozen=True, slots=True)
class HoldLost:
    """The jaw has closed on nothing while it should hold; nobody asked."""


@dataclass(frozen=True, slots=True)
class HandWaited:
    call: int
    taken: bool


@dataclass(frozen=True, slots=True)
class ManipulationCallFailed:
    """No answer: nobody there, out of time, an error. `detail` is for people."""

    call: int
    detail: str = ""


@dataclass(frozen=True, slots=True)
class MomentPassed:
    """Time goes by."""


Answer = (
    ArmMoved
    | BaseMoved
    | StancePlanned
    | ThingLooked
    | GraspsPlanned
    | SpotPlanned
    | HoldChecked
    | HandWaited
    | ManipulationCallFailed
)
Event = FetchBegun | FetchCanceled | StopSeen | HoldLost | MomentPassed | Answer
