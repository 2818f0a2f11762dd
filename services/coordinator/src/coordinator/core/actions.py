"""What a mission can ask the shell for. Every call is answered by one event with the same number."""

from dataclasses import dataclass

from contracts.geometry import Pose2D, Twist2D
from contracts.mission import NO_FACTS, EventFacts, EventKind, MissionState
from contracts.robot import BoxQuery, CandidatePose
from contracts.vision import Detections, Target


@dataclass(frozen=True, slots=True)
class Undock:
    call: int
    timeout_s: float


@dataclass(frozen=True, slots=True)
class Dock:
    call: int
    timeout_s: float


@dataclass(frozen=True, slots=True)
class Navigate:
    """To the best of the candidates, or up to `ring_radius_m` from the first; none = as the bridge is set."""

    call: int
    candidates: tuple[CandidatePose, ...]
    timeout_s: float
    ring_radius_m: float | None = None


@dataclass(frozen=True, slots=True)
class Rotate:
    call: int
    angle_rad: float
    speed_rad_s: float
    timeout_s: float


@dataclass(frozen=True, slots=True)
class Drive:
    call: int
    distance_m: float
    speed_m_s: float
    timeout_s: float


@dataclass(frozen=True, slots=True)
class SetVelocity:
    """A short lease on the wheels; nobody waits for its answer."""

    twist: Twist2D
    duration_s: float


@dataclass(frozen=True, slots=True)
class StopMotion:
    """Ends the goal, rotation or drive under way and whatever lease there is."""


@dataclass(frozen=True, slots=True)
class Validate:
    call: int
    target: Target
    box: BoxQuery
    timeout_s: float
    moving: bool = False


@dataclass(frozen=True, slots=True)
class PlanCoverage:
    """The places still worth a scan, in order, without those near `avoid`."""

    call: int
    avoid: tuple[Pose2D, ...]
    timeout_s: float
    refused: tuple[tuple[float, float], ...] = ()
    """Places in map of what was judged and is another thing; told to a belief only."""
    expected: tuple[tuple[float, float], ...] = ()
    """The same of what was confirmed, and then lost from sight before it was reached."""


@dataclass(frozen=True, slots=True)
class RecordLook:
    """What the camera sees from this pose has been looked at; what it saw tells memory what is no longer there."""

    pose: Pose2D
    seen: Detections | None = None
    moving: bool = False
    """On the way: the belief learns of it; memory does not, which doubts things by looks at rest."""


@dataclass(frozen=True, slots=True)
class KeepPicture:
    """The very crop that was judged: evidence, kept under its number."""

    number: int
    validation_id: str


@dataclass(frozen=True, slots=True)
class BeginExploration:
    """Begins an exploration that comes home to `home`, or lets the one that is held go on. `duration_s` none: it goes
    home after as long as is set."""

    call: int
    home: Pose2D
    duration_s: float | None = None


@dataclass(frozen=True, slots=True)
class Celebrate:
    pass


@dataclass(frozen=True, slots=True)
class Say:
    """One line of the timeline, and the state it was said in."""

    state: MissionState
    kind: EventKind
    text: str
    data: EventFacts = NO_FACTS


Action = (
    Undock | Dock | Navigate | Rotate | Drive | SetVelocity | StopMotion | Validate | PlanCoverage
    | RecordLook | KeepPicture | BeginExploration | Celebrate | Say
)  # fmt: skip

MOTION: tuple[type[Action], ...] = (Undock, Dock, Navigate, Rotate, Drive, SetVelocity, BeginExploration)
