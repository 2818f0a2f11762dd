"""What a mission knows: one immutable value from which every decision is made."""

from dataclasses import dataclass, field

from contracts.colours import Colour
from contracts.geometry import Pose2D
from contracts.intent import WantedAction
from contracts.measuring import Measurement
from contracts.mission import Candidate as CandidateRecord
from contracts.mission import (
    LastSeen,
    MapTrouble,
    MissionKind,
    MissionState,
    Outcome,
    Report,
    SeenElsewhere,
    SeenInstead,
)
from contracts.motion import MotionEnd
from contracts.robot import BoxQuery
from contracts.vision import Target, Vote
from coordinator.core.activities import Activity, Idle, Paused, Stage
from coordinator.core.area import SearchArea
from coordinator.core.evidence import Judgement
from coordinator.core.motions import PlainMotion
from coordinator.core.rules import Rules
from coordinator.core.tracking import Track


@dataclass(frozen=True, slots=True)
class RobotSnapshot:
    """The newest the bridge said; `offset_s` is its clock minus ours."""

    pose: Pose2D | None = None
    odometry: Pose2D | None = None
    docked: bool | None = None
    speed_m_s: float = 0.0
    stopped: bool = False
    epoch: int = 0
    epoch_s: float | None = None
    received_s: float = 0.0
    offset_s: float = 0.0
    localized_s: float = 0.0
    map_id: str | None = None
    """Which home it is in, as last said."""
    lifted_s: float | None = None
    """Since when a wheel hangs in the air; none while none does."""

    @property
    def yaw(self) -> float:
        """In map, or in odom while the robot is not localised."""
        best = self.pose or self.odometry
        return best.yaw if best is not None else 0.0


@dataclass(frozen=True, slots=True)
class SearchPose:
    """Somewhere to go and look, and why."""

    pose: Pose2D
    reason: str = ""
    thing_xy: tuple[float, float] | None = None
    """Where the thing itself is, in map, if memory knows."""


@dataclass(frozen=True, slots=True)
class Sighting:
    """One box that may be the target; `bearing_rad` in map, `error_px` right of the middle of a 320 px wide frame."""

    box: BoxQuery
    stamp_s: float
    confidence: float
    colour: Colour | None
    bearing_rad: float
    error_px: float
    measurement: Measurement
    """As it came with the picture; where nobody answered, a newer picture may tell."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """The thing being centred on, measured, validated and driven up to."""

    sighting: Sighting
    seen_s: float = 0.0
    colour_named: bool = False
    """Whether any sighting of it named its colour: it agrees with the one asked for then, or it would be none."""
    origin: Pose2D | None = None
    since_s: float = 0.0
    other_colour: int = 0
    """Pictures that named another colour in its place, less those that named the one asked for."""
    centered: int = 0
    rounds: int = 0
    stuck: int = 0
    """Steps towards it, while it has no place, that something in the way cut off at once."""
    samples: tuple[Measurement, ...] = ()
    distance_m: float | None = None
    sigma_m: float = 0.0
    map_xy: tuple[float, float] | None = None
    odom_xy: tuple[float, float] | None = None
    track: Track | None = None
    """Where all its measurements together say it is in map."""
    votes: tuple[Vote, ...] = ()
    confirmed: bool = False
    closer_looks: int = 0
    unseen_again: int = 0
    """Times it was judged on a picture in which the detector saw nothing, and looked at again for that."""
    unjudged: int = 0
    picture: int | None = None
    judged_s: float | None = None
    log_odds: tuple[float, ...] = ()
    """What all looks at its place came to, after each."""
    other_sides: int = 0
    """Drives to look at it from another side."""
    elsewhere: bool = False
    """The next drive is one."""
    revisited: bool = False
    """It was refused before, and is looked at once more."""


@dataclass(frozen=True, slots=True)
class Rejection:
    """A thing that was looked at and is not the target; without a place only its bearing is known.

    `distance_m` is how far off it was when it was judged, none where that was not measured.
    """

    map_xy: tuple[float, float] | None
    origin: Pose2D | None
    bearing_rad: float
    narrow: bool
    text: str
    votes: tuple[Vote, ...] = ()
    record: CandidateRecord | None = None
    distance_m: float | None = None
    sighting: Sighting | None = None
    revisited: bool = False


@dataclass(frozen=True, slots=True)
class Loss:
    """A sighting that could not be seen again; `confirmed` when it had been validated before."""

    origin: Pose2D | None
    bearing_rad: float
    confirmed: bool = False
    text: str = ""
    record: CandidateRecord | None = None


@dataclass(frozen=True, slots=True)
class NearGoal:
    """A place near the thing: where that was believed to be, and how far from it the goal was chosen. None: it was
    only seen, and the goal lies in its direction.
    """

    thing_xy: tuple[float, float] | None
    radius_m: float
    since_s: float


@dataclass(frozen=True, slots=True)
class Approach:
    stage: Stage = Stage.RING
    drives: int = 0
    alternatives: int = 0
    tried_rad: tuple[float, ...] = ()
    ended: MotionEnd | None = None
    """How the last drive ended; none while there was none."""
    furniture: str = ""
    disputed: tuple[tuple[float, float], ...] = ()
    until_s: float = float("inf")
    goal: NearGoal | None = None
    """On the direct way: where it drives to, while it is not there."""
    goals: int = 0
    votes_call: int = 0
    """The votes asked for on the way, 0 while none are."""
    votes_due_s: float = 0.0
    clear_noes: int = 0

    @property
    def blocked(self) -> bool:
        return self.ended is not None and self.ended.says_something_is_ahead

    @property
    def got_there(self) -> bool:
        """The last drive ended where it was to end, or before what stands in the way."""
        return self.ended is not None and (self.ended.completed or self.ended.says_something_is_ahead)


@dataclass(frozen=True, slots=True)
class Search:
    """Where to look still, and where it has been done."""

    views: tuple[SearchPose, ...] = ()
    points: tuple[Pose2D, ...] = ()
    glanced_from: Pose2D | None = None
    """The last look on the way, by belief."""
    plans: int = 0
    visited: tuple[Pose2D, ...] = ()
    unreachable: tuple[Pose2D, ...] = ()
    consecutive_unreachable: int = 0
    tentative_sightings: tuple[Sighting, ...] = ()
    """What the last picture on the way showed of it."""
    headings: tuple[float, ...] = ()
    sweeps: int = 0
    scan_from: Pose2D | None = None
    explored_fraction: float | None = None
    blind_looks: int = 0
    place_failures: int = 0
    refusals: int = 0
    undocks: int = 0
    rejections: tuple[Rejection, ...] = ()
    losses: tuple[Loss, ...] = ()
    judgements: tuple[Judgement, ...] = ()
    """Every picture that was judged, of whatever thing."""
    revisits: int = 0
    other_objects: tuple[SeenInstead, ...] = ()
    map_trouble: MapTrouble | None = None


@dataclass(frozen=True, slots=True)
class Order:
    """Which part of which request a mission is, and when it was asked for."""

    request_id: str = ""
    part: int = 1
    parts: int = 1
    asked_s: float | None = None


FIRST = Order()


@dataclass(frozen=True, slots=True)
class Mission:
    """`id` is empty until the first mission; after an ending the outcome stays until the next one starts."""

    rules: Rules
    robot: RobotSnapshot = RobotSnapshot()
    state: MissionState = MissionState.IDLE
    activity: Activity = field(default_factory=Idle)
    calls: int = 0
    failures: int = 0
    cut_off: int = 0
    """Rotations and drives in a row that ended for a reason of the robot's own."""
    id: str = ""
    kind: MissionKind = MissionKind.FIND
    order: Order = FIRST
    command: str = ""
    target: Target | None = None
    parser: str = ""
    action: WantedAction = WantedAction.FIND
    epoch: int = 0
    started_s: float = 0.0
    deadline_s: float = float("inf")
    ended_s: float | None = None
    outcome: Outcome | None = None
    reason: str = ""
    progress: str = ""
    metres_m: float = 0.0
    metres_from: Pose2D | None = None
    map_id: str | None = None
    """Which home its places are in."""
    search: Search = Search()
    area: SearchArea | None = None
    """It looks in these rooms alone; none: in the whole home."""
    elsewhere: tuple[SeenElsewhere, ...] = ()
    """What memory knows of the target outside them, and what was seen of it since, newest first."""
    last_seen: LastSeen | None = None
    dock_tries: int = 0
    pictures: int = 0
    stop_unexplained: bool = False
    """It was aborted by an emergency stop that has not said why yet."""
    report: Report | None = None
    motion: PlainMotion | None = None
    """Of a mission of kind MOVE: what is still to be done."""
    candidate: Candidate | None = None
    approach: Approach | None = None

    @property
    def colour(self) -> Colour | None:
        """The colour asked for."""
        return self.target.colour if self.target is not None else None

    @property
    def area_called(self) -> str:
        """The rooms it keeps to, for a person; '' for the whole home."""
        return self.area.called if self.area is not None else ""

    @property
    def running(self) -> bool:
        return self.id != "" and self.outcome is None

    @property
    def paused(self) -> bool:
        return isinstance(self.activity, Paused)

    @property
    def listening(self) -> bool:
        """Paused for a time, while somebody speaks to the robot."""
        return isinstance(self.activity, Paused) and self.activity.resumes
