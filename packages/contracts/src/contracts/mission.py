"""Missions: the ten states of requirement A12, the endings, and the timeline."""

from enum import StrEnum

from pydantic import Field

from contracts.base import Confidence, Message, StampS
from contracts.colours import Colour
from contracts.exploration import ExplorationStatus
from contracts.geometry import Pose2D
from contracts.intent import WantedAction
from contracts.motion import MotionEnd
from contracts.reading import Mood
from contracts.report import Candidate as Candidate
from contracts.report import EndCause as EndCause
from contracts.report import LastSeen as LastSeen
from contracts.report import MapTrouble as MapTrouble
from contracts.report import Report as Report
from contracts.report import SearchedRoom as SearchedRoom
from contracts.report import SeenElsewhere as SeenElsewhere
from contracts.report import SeenInstead as SeenInstead
from contracts.vision import Target, Vote


class MissionState(StrEnum):
    IDLE = "IDLE"  # nothing to do
    MEMORY_NAV = "MEMORY_NAV"  # driving to a place where such a thing was seen
    SCANNING = "SCANNING"  # turning on the spot and looking
    MOVING_TO_SCAN = "MOVING_TO_SCAN"  # driving to the next place of the search
    CENTERING = "CENTERING"  # turning until the target is in the middle of the picture
    DEPTH_CHECK = "DEPTH_CHECK"  # standing still: measuring the distance and validating
    APPROACHING = "APPROACHING"  # driving up to a validated target
    MOVING = "MOVING"  # doing the plain motions that were asked for: drives, turns, looks
    EXPLORING = "EXPLORING"
    """Going where nobody has mapped yet: led by a model, by the frontiers, or by the laser."""
    DRIVING_1M = "DRIVING_1M"
    """Taking one step of a metre towards a far target."""
    DONE = "DONE"
    """The mission has ended; resets by itself."""
    EMERGENCY_STOP = "EMERGENCY_STOP"
    """Stopped until RESUME."""

    @property
    def resting(self) -> bool:
        """Nothing may ask for motion."""
        return self is MissionState.DONE or self.settled

    @property
    def settled(self) -> bool:
        """Nothing happens by itself any more."""
        return self in {MissionState.IDLE, MissionState.EMERGENCY_STOP}

    @property
    def fast_detection(self) -> bool:
        """The detector looks as often as it can: the robot searches, or nears its target."""
        driven = {MissionState.MEMORY_NAV, MissionState.MOVING_TO_SCAN, MissionState.EXPLORING}
        return not self.resting and self not in driven


class MissionKind(StrEnum):
    FIND = "find"
    """Look for something and drive up to it."""
    DOCK = "dock"
    """Drive to the dock and charge (requirement A15)."""
    MOVE = "move"
    """Plain motions: a drive, a turn, a look round, a tour of rooms (`contracts.actions`). Nothing is looked for."""


class Outcome(StrEnum):
    FOUND = "found"
    """Seen, validated, driven up to; the report says where and on what evidence."""
    NOT_FOUND = "not_found"
    """Looked for and not there; the report says how much was looked at and what is known."""
    UNSURE = "unsure"
    """Something may have been it; the report names each candidate and why it was not taken."""
    DOCKED = "docked"
    """A docking that ended on the dock."""
    DONE = "done"  # plain motions that ended as they were asked for
    CANCELED = "canceled"
    """By a person."""
    ABORTED = "aborted"
    """It could not go on; the report names the cause."""
    INTERRUPTED = "interrupted"
    """The coordinator ended while it was queued or running. It is never taken up again by itself."""


class StartMission(Message):
    """`POST /missions`. One command may name several things: each becomes a mission, in the order said.

    With the header `Idempotency-Key` (1 to 100 characters) a repeated request answers with the first one's mission.
    """

    command: str = Field(min_length=1, max_length=500, description="e.g. 'find the red bottle, then the book'")


class Heard(Message):
    """What `POST /missions` answers (200) where the words start no mission: an order obeyed, a wish taken back."""

    mood: Mood
    text: str = Field(max_length=500, description="what was done about it, for a person")
    ended: tuple[str, ...] = Field(default=(), max_length=64, description="ids of the missions it ended")
    still: bool = Field(default=False, description="robot_bridge says that nothing moves the robot any more")


class CommandRefusal(StrEnum):
    """Why a command starts nothing (`code` of the 422 or 409); beside these, the `Mood` it was said in."""

    NAMES_NOTHING = "names_nothing"
    """No class of the detector is named."""
    WHICH_THING = "which_thing"
    """'anything red': the thing itself is not named."""
    NO_ARM = "no_arm"  # 'pour the medicine': a robot without an arm cannot begin it
    NO_ROOMS = "no_rooms"  # 'go to the kitchen': memory knows no such room
    WHICH_ROOM = "which_room"  # 'go to the bedroom': there are two
    UNKNOWN_ROOM = "unknown_room"
    """'find the cup in the attic': the map has no room of that name, or the home's rooms are not known."""
    STOPPED_MEANWHILE = "stopped_meanwhile"
    """A person said stop while it was being read."""


class Mission(Message):
    """Queued (`queue_position` is set), running or paused (no outcome), or over (`outcome`)."""

    id: str
    kind: MissionKind = MissionKind.FIND
    command: str
    target: Target | None = None
    parser: str = ""
    action: WantedAction = Field(default=WantedAction.FIND, description="what was asked for; the robot has no arm")
    rooms: tuple[SearchedRoom, ...] = Field(
        default=(), max_length=200, description="it looks in these alone; empty: in the whole home"
    )
    state: MissionState
    paused: bool = False
    queue_position: int | None = Field(default=None, ge=0, description="0 = next; none when it runs or is over")
    request_id: str = Field(default="", description="missions of one command share it")
    part: int = Field(default=1, ge=1, description="which thing of the command, from 1")
    parts: int = Field(default=1, ge=1, description="how many things the command named")
    outcome: Outcome | None = Field(default=None, description="none while it is queued or runs")
    reason: str = ""
    asked_s: float | None = Field(default=None, description="when the command came in")
    started_s: StampS = Field(description="when it began; while queued, when it was asked for")
    ended_s: float | None = None
    votes: tuple[Vote, ...] = ()
    measured_distance_m: float | None = Field(
        default=None, description="camera to the target's near surface at the end"
    )
    target_pose: Pose2D | None = Field(default=None, description="the target's place in map (yaw unused)")
    metres_driven_m: float = 0.0
    report: Report | None = Field(default=None, description="once it is over")
    map_id: str | None = Field(
        default=None, max_length=40, description="which home its places are in, see robot.state; none = not known"
    )
    trace_id: str = Field(
        default="",
        pattern=r"^([0-9a-f]{32})?$",
        examples=["0af7651916cd43dd8448eb211c80319c"],
        description="W3C trace id, from the command on; '' = not known",
    )


class MissionStatus(Message):
    """The `mission.state` topic: what the robot is at, in one message."""

    stamp_s: StampS
    state: MissionState = MissionState.IDLE
    mission: Mission | None = None
    progress: str = Field(default="", max_length=500)
    waiting_for: str = Field(default="", max_length=200, description="the service it waits for, and until when it will")
    queue: tuple[Mission, ...] = Field(default=(), max_length=50, description="still to come, next first")
    scan_points: tuple[Pose2D, ...] = Field(
        default=(), max_length=2000, description="still to be looked at, next first"
    )
    scan_points_done: tuple[Pose2D, ...] = Field(default=(), max_length=2000)
    exploration: ExplorationStatus | None = Field(
        default=None, description="of the exploration under way, or of the last one; none while there was none"
    )


class MissionTarget(Message):
    """The `mission.target` topic: what perception should look for, or nothing."""

    target: Target | None = None
    mission_id: str | None = None
    fast: bool = Field(default=False, description="look more often than at rest: the robot is centering or approaching")


class EventKind(StrEnum):
    """What a line of the timeline is about."""

    QUEUED = "queued"
    """It waits in the queue."""
    START = "start"
    """It begins."""
    STATE = "state"
    """The state changes; `data` has the one before."""
    NAVIGATION = "navigation"
    """A goal: where to, and how it ended."""
    MOTION = "motion"
    """A turn or a drive ended early; `data` has the end."""
    SIGHTING = "sighting"
    """Something like it was seen."""
    DEPTH = "depth"
    """It was measured."""
    VOTES = "votes"
    """It was judged; `data` has the votes and the picture's number."""
    FAILURE = "failure"
    """A call failed, or nothing came."""
    DOCK = "dock"
    """On the way to the dock."""
    UNDOCK = "undock"
    """Off the dock."""
    PAUSE = "pause"
    """It is paused: by a person, or because the robot was lifted."""
    RESUME = "resume"
    """A person lets it go on."""
    STOP = "stop"
    """Why the emergency stop was pressed, where that came later."""
    FOUND = "found"
    """It ended as a find."""
    END = "end"
    """It ended otherwise."""


class EventFacts(Message, extra="ignore"):
    """What a line of the timeline tells a program. A stored line of an older version may hold more: it is left out."""

    before: MissionState | None = Field(default=None, description="where the state changed")
    outcome: Outcome | None = Field(default=None, description="where the mission ended")
    looked_share: float | None = Field(default=None, description="of the free space, where it ended without a find")
    goal: Pose2D | None = Field(default=None, description="where it drives to")
    error_code: int | None = Field(default=None, description="Nav2's")
    end: MotionEnd | None = Field(default=None, description="how a turn or a drive ended")
    moved_m: float | None = None
    colour: Colour | None = Field(default=None, description="of the sighting")
    confidence: Confidence | None = Field(default=None, description="of the sighting")
    distance_m: float | None = Field(default=None, description="as measured")
    confirmed: bool | None = Field(default=None, description="what the votes say")
    votes: tuple[Vote, ...] = ()
    log_odds: float | None = Field(default=None, description="that it is the target, of all looks at it so far")
    picture: int | None = Field(default=None, ge=0, description="number of the crop that was judged")
    service: str = Field(default="", description="whose call failed")


NO_FACTS = EventFacts()


class MissionEvent(Message):
    """One line of the timeline."""

    id: int = Field(ge=0, description="rises by one, over the coordinator's restarts too")
    mission_id: str = Field(description="empty where it belongs to none")
    stamp_s: StampS
    state: MissionState
    kind: EventKind
    text: str = Field(max_length=1000, description="what was done and why, for a person")
    data: EventFacts = NO_FACTS


class CoveragePlan(Message):
    points: tuple[Pose2D, ...]
    regions: int = 0
    free_area_m2: float = 0.0
    map_trouble: MapTrouble | None = Field(
        default=None, description="why there are no points; none where there are some, or all was looked at"
    )
