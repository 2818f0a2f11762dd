"""What can happen to a mission. Results of calls carry the number of the call that asked for them."""

from dataclasses import dataclass

from contracts.causes import GoalCause, Refusal
from contracts.exploration import ExplorationEnd, ExplorationMode
from contracts.geometry import Pose2D
from contracts.intent import WantedAction
from contracts.mission import LastSeen, MapTrouble, SeenElsewhere
from contracts.motion import BaseEnd, MotionEnd
from contracts.robot import GoalStatus
from contracts.vision import Detections, Target, Validation
from coordinator.belief.clues import Clue
from coordinator.core.area import SearchArea
from coordinator.core.mission import FIRST, Order, SearchPose
from coordinator.core.motions import PlainMotion


@dataclass(frozen=True, slots=True)
class MissionStarted:
    mission_id: str
    command: str
    target: Target
    parser: str
    views: tuple[SearchPose, ...]
    notes: str = ""
    order: Order = FIRST
    last_seen: LastSeen | None = None
    clues: tuple[Clue, ...] = ()
    """Where it may be; told where the search goes by belief."""
    action: WantedAction = WantedAction.FIND
    area: SearchArea | None = None
    """The rooms it keeps to; none: the whole home."""
    elsewhere: tuple[SeenElsewhere, ...] = ()


@dataclass(frozen=True, slots=True)
class DockingStarted:
    """The way to the dock, and onto it (requirement A15)."""

    mission_id: str
    why: str
    order: Order = FIRST


@dataclass(frozen=True, slots=True)
class MotionStarted:
    """Plain motions, asked for as an action."""

    mission_id: str
    command: str
    motion: PlainMotion
    order: Order = FIRST


@dataclass(frozen=True, slots=True)
class RobotUpdated:
    stamp_s: float
    pose: Pose2D | None
    odometry: Pose2D | None
    docked: bool | None
    speed_m_s: float
    stopped: bool
    epoch: int
    stop_reason: str = ""
    map_id: str | None = None
    lifted: bool = False
    """A wheel hangs in the air."""


@dataclass(frozen=True, slots=True)
class Tick:
    """Time passed; ten a second."""


@dataclass(frozen=True, slots=True)
class StopLatched:
    epoch: int
    reason: str


@dataclass(frozen=True, slots=True)
class StopReset:
    epoch: int


@dataclass(frozen=True, slots=True)
class CancelRequested:
    pass


@dataclass(frozen=True, slots=True)
class PauseRequested:
    """`for_s`: somebody speaks to the robot; it goes on by itself after so long, 0 = now. None: until a person says."""

    for_s: float | None = None


@dataclass(frozen=True, slots=True)
class ResumeRequested:
    pass


@dataclass(frozen=True, slots=True)
class DetectionsSeen:
    detections: Detections


@dataclass(frozen=True, slots=True)
class LeaseAnswered:
    """What the bridge said to the newest `SetVelocity`: how it ends should the robot not move by it."""

    held: MotionEnd


@dataclass(frozen=True, slots=True)
class Undocked:
    call: int


@dataclass(frozen=True, slots=True)
class Docked:
    call: int


@dataclass(frozen=True, slots=True)
class GoalEnded:
    """`cause` is what ended it where it did not arrive, `error_code` Nav2's, `error` the same for a person."""

    call: int
    status: GoalStatus
    error_code: int = 0
    error: str = ""
    cause: GoalCause | None = None

    @property
    def stopped(self) -> bool:
        """The emergency stop ended it."""
        return self.cause is GoalCause.STOPPED


@dataclass(frozen=True, slots=True)
class MotionEnded:
    """A rotation or a drive: one of the two lengths is 0. `text` tells the end to a person."""

    call: int
    end: MotionEnd
    turned_rad: float = 0.0
    driven_m: float = 0.0
    text: str = ""


@dataclass(frozen=True, slots=True)
class Validated:
    call: int
    validation: Validation


@dataclass(frozen=True, slots=True)
class CoveragePlanned:
    call: int
    points: tuple[Pose2D, ...]
    free_area_m2: float
    trouble: MapTrouble | None = None
    """Why there are no points. None, and no points: all that can be seen was looked at."""
    headings: tuple[float, ...] = ()
    """By belief: the looks worth taking at the first point, and the choice in words."""
    why: str = ""


@dataclass(frozen=True, slots=True)
class CoverageLooked:
    """`share` of the free space looked at so far, 0 to 1."""

    share: float


@dataclass(frozen=True, slots=True)
class LeadChanged:
    """Who leads it from now on, and why, for a person."""

    call: int
    mode: ExplorationMode
    why: str


@dataclass(frozen=True, slots=True)
class DiscoverySeen:
    """Whoever leads reported something worth knowing."""

    call: int
    label: str
    note: str = ""


@dataclass(frozen=True, slots=True)
class ExplorationEnded:
    """`actions`: motions it made, whoever led; `discoveries`: their labels; `calls`: of the model; `all_known`: no map
    of it had a border of the unknown."""

    call: int
    end: ExplorationEnd
    actions: int = 0
    calls: int = 0
    discoveries: tuple[str, ...] = ()
    all_known: bool = False


@dataclass(frozen=True, slots=True)
class CallFailed:
    """`code` tells which refusal or end it was, where that is known; `detail` is for a person."""

    call: int
    service: str
    detail: str
    code: Refusal | BaseEnd | None = None

    @property
    def stopped(self) -> bool:
        """The emergency stop refused it, or ended it."""
        return self.code in {Refusal.STOPPED, BaseEnd.STOPPED}


Answer = (
    Undocked | Docked | GoalEnded | MotionEnded | Validated | CoveragePlanned | LeadChanged | DiscoverySeen
    | ExplorationEnded | CallFailed
)  # fmt: skip
"""To a call the core asked for, by its number."""

Started = MissionStarted | DockingStarted | MotionStarted

Event = (
    MissionStarted | DockingStarted | MotionStarted | RobotUpdated | Tick | StopLatched | StopReset | CancelRequested
    | PauseRequested | ResumeRequested | DetectionsSeen | CoverageLooked | LeaseAnswered | Answer
)  # fmt: skip
