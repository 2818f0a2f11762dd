"""What the robot is doing inside a mission state: one activity at a time, each bounded by `until_s`.

`call` is the number of the call whose answer is awaited, 0 where none is.
"""

from dataclasses import dataclass
from enum import StrEnum

from contracts.motion import MotionEnd
from contracts.robot import CandidatePose

FOREVER_S = float("inf")


@dataclass(frozen=True, slots=True)
class Idle:
    call: int = 0
    until_s: float = FOREVER_S


@dataclass(frozen=True, slots=True)
class Starting:
    """The state was just entered (or is taken up again): its own `begin` decides what to do."""

    call: int = 0
    until_s: float = FOREVER_S


@dataclass(frozen=True, slots=True)
class Paused:
    """Until a person resumes it, or, where it `resumes` by itself, until `until_s`; `since_s` is what the mission's
    deadline is put off by.
    """

    since_s: float
    until_s: float
    call: int = 0
    why: str = ""
    resumes: bool = False


@dataclass(frozen=True, slots=True)
class Waiting:
    """For a service, after a failed call; then the state is taken up again."""

    until_s: float
    service: str = ""
    call: int = 0


@dataclass(frozen=True, slots=True)
class WaitingForPlace(Waiting):
    """The robot does not know where it is: until it does, or `lost_pose_s` ends the mission."""


@dataclass(frozen=True, slots=True)
class Undocking:
    call: int
    until_s: float


@dataclass(frozen=True, slots=True)
class Waking:
    """Off the dock, for the first picture: a power saver turns camera and lidar off on the dock."""

    until_s: float
    call: int = 0


@dataclass(frozen=True, slots=True)
class Docking:
    """The base looks for its dock and drives onto it by itself."""

    call: int
    until_s: float


@dataclass(frozen=True, slots=True)
class PlanningCoverage:
    call: int
    until_s: float


@dataclass(frozen=True, slots=True)
class Navigating:
    call: int
    until_s: float
    candidates: tuple[CandidatePose, ...]


@dataclass(frozen=True, slots=True)
class Rotating:
    """Looking meanwhile at frames taken after `looking_s` on the robot's clock, where that is set."""

    call: int
    until_s: float
    looking_s: float | None = None


@dataclass(frozen=True, slots=True)
class AwaitingFrame:
    """For a frame taken after `after_s` on the robot's clock."""

    after_s: float
    until_s: float
    call: int = 0
    unmeasured: str | None = None
    """Why nobody measured the target's box in the newest picture that showed it; None while no picture did so."""


@dataclass(frozen=True, slots=True)
class Validating:
    call: int
    until_s: float


@dataclass(frozen=True, slots=True)
class Driving:
    """Straight ahead, closed loop in the bridge."""

    call: int
    until_s: float


@dataclass(frozen=True, slots=True)
class UnderExploration:
    """The exploration leads (`coordinator.exploration`); it has its own deadlines, and the mission's."""

    call: int
    until_s: float = FOREVER_S


@dataclass(frozen=True, slots=True)
class Steering:
    """Straight ahead by short leases (the plain rule), with a depth check every so often."""

    until_s: float
    moving_s: float
    next_depth_s: float = 0.0
    call: int = 0
    held: MotionEnd = MotionEnd.HELD_BACK
    """How it ends should it not move: by what the bridge answered last."""


Activity = (
    Idle | Starting | Paused | Waiting | Undocking | Waking | Docking | PlanningCoverage | Navigating
    | Rotating | AwaitingFrame | Validating | Driving | UnderExploration | Steering
)  # fmt: skip


class Stage(StrEnum):
    """Where in the localised approach the robot is."""

    RING = "RING"
    """Driving to a place round the object."""
    FACE = "FACE"
    """Turning towards it."""
    LOOK = "LOOK"
    """Looking once more, to correct where it is."""
    AIM = "AIM"
    """Turning by what that look said."""
    DRIVE = "DRIVE"
    """Driving the rest straight."""
    CONFIRM = "CONFIRM"
    """Measuring what distance is left."""
    SETTLE = "SETTLE"
    """Turning to face it at the end."""
