"""What robot_bridge says about the robot and what it can be asked to do."""

from enum import IntEnum, StrEnum
from typing import Annotated

from pydantic import Field, model_validator

from contracts.base import NO_CONTROL_CHARACTERS, BboxXyxy, ImageSidePx, Message, StampS
from contracts.causes import GoalCause, LimitCause, Refusal, SafetyCause
from contracts.geometry import Point3D, Pose2D, Twist2D

MapId = Annotated[str, Field(min_length=1, max_length=40, pattern=NO_CONTROL_CHARACTERS)]


class SensorState(StrEnum):
    NEVER = "never"
    """Nothing has come."""
    FRESH = "fresh"
    """Understood, and new enough to act on."""
    STALE = "stale"
    """It was understood, and is too old to act on."""
    NOT_UNDERSTOOD = "not_understood"
    """Something comes, and makes no sense: `detail` says why."""


class SensorStatus(Message):
    state: SensorState
    age_s: float | None = Field(
        default=None, ge=0.0, description="seconds since the newest message that was understood; none if there was none"
    )
    detail: str = Field(
        default="", max_length=500, description="for a person: why it is not understood, or what to know of what is"
    )

    @property
    def valid(self) -> bool:
        """New enough to act on."""
        return self.state is SensorState.FRESH


class Battery(Message):
    percentage: float | None = Field(
        ge=0.0, le=100.0, description="%; none where the base does not tell it in a way that can be understood"
    )
    charging: bool = False


class EmergencyStop(Message):
    """The latched software stop; `epoch` rises with every stop, older requests are refused."""

    latched: bool
    epoch: int = Field(ge=0)
    reason: str = Field(default="", max_length=500, description="'' while a stop is on and has not said why yet")
    by: str = Field(default="", max_length=100, description="who asked for it")
    since_s: float | None = Field(default=None, description="seconds since the Unix epoch; none when not latched")


class EmergencyStopRequest(Message):
    reason: str = Field(default="requested", max_length=500)
    by: str = Field(default="unknown", max_length=100)


class EmergencyStopReply(Message):
    state: EmergencyStop
    first_zero_ms: float | None = Field(
        default=None, description="from the request to the first zero velocity published, ms"
    )


class EmergencyStopAction(StrEnum):
    STOPPED = "stopped"
    """Somebody asked for the stop."""
    RESET = "reset"
    """Somebody permitted motion again."""
    RESTORED = "restored"
    """The bridge has started and found the latch set."""


class EmergencyStopEvent(Message):
    """A line of the stop's history, kept on disk: who did what, when and why."""

    stamp_s: StampS
    action: EmergencyStopAction
    epoch: int = Field(ge=0)
    by: str = Field(default="", max_length=100)
    reason: str = Field(default="", max_length=500)


class BaseStopState(StrEnum):
    """The base's own stop, beside the bridge's latch."""

    UNKNOWN = "unknown"
    """Not asked for, and nothing tells whether the wheels are enabled."""
    RELEASED = "released"
    """The wheels are enabled."""
    ASKED = "asked"
    """Asked for; the wheels have not said so yet."""
    ENGAGED = "engaged"
    """Asked for, and the wheels say that they are disabled."""
    UNCONFIRMED = "unconfirmed"
    """Asked for as often as it may be; the wheels did not say so."""
    MISSING = "missing"
    """Wanted, and the base offers no such service now."""
    HELD = "held"
    """The wheels are disabled, though this bridge does not want it: somebody stopped the robot at the robot."""


class NavigationState(StrEnum):
    INACTIVE = "inactive"
    """Nav2 is not there, or its lifecycle is not active."""
    IDLE = "idle"
    """Ready for a goal."""
    NAVIGATING = "navigating"
    """A goal is being driven to."""


class RobotState(Message):
    """One look at every sensor, at one moment. What is stale is named in `stale`, and its value is none."""

    stamp_s: StampS
    pose: Pose2D | None = Field(default=None, description="base_link in map; none while not localised")
    odometry: Pose2D | None = Field(default=None, description="base_link in odom")
    twist: Twist2D = Field(default=Twist2D(), description="measured by odometry")
    commanded: Twist2D = Field(default=Twist2D(), description="what was last sent to the base")
    commanded_by: str = Field(default="none", description="source of the winning lease")
    battery: Battery | None = None
    docked: bool | None = None
    dock_visible: bool | None = Field(default=None, description="the base sees its dock")
    dock: Pose2D | None = Field(default=None, description="base_link in map while docked, as set or last seen there")
    map_id: MapId | None = Field(
        default=None, description="which home the map is of; coordinates of one mean nothing in another"
    )
    navigation: NavigationState = NavigationState.INACTIVE
    goal_id: str | None = None
    emergency_stop: EmergencyStop
    base_stop: BaseStopState = BaseStopState.UNKNOWN
    hazards: tuple[str, ...] = Field(default=(), description="active bumper, cliff, wheel-drop names")
    sensors: dict[str, SensorStatus] = Field(
        default_factory=dict,
        description="by name: scan, odom, rgb, rgb_info, depth, depth_info, pose, map, battery, dock, hazards",
    )
    stale: tuple[str, ...] = Field(default=(), description="the sensors that are not valid now")


class Priority(IntEnum):
    """Lower wins (requirement C1). EMERGENCY and SAFETY cannot be requested over HTTP."""

    EMERGENCY = 0
    SAFETY = 1
    NAVIGATION = 2
    EXPLORATION = 3
    MANUAL = 4


class VelocityRequest(Message):
    """A lease on the wheels: valid for `duration_s`, then it is as if it had never been asked for."""

    twist: Twist2D
    source: str = Field(min_length=1, max_length=40)
    priority: Priority = Priority.MANUAL
    duration_s: float = Field(default=0.3, gt=0.0, le=2.0, description="s")
    epoch: int = Field(ge=0, description="of the emergency stop, from GET /emergency-stop")
    allow_reverse: bool = False
    stamp_s: float | None = Field(
        default=None, description="when it was decided; refused when stale or from the future"
    )
    session_id: str | None = Field(default=None, description="ends with this session, see WS /session")


class VelocityReply(Message):
    accepted: bool
    sent: Twist2D = Field(description="what reaches the base now, after arbitration, limits and safety")
    refusal: Refusal | None = Field(default=None, description="why it was not accepted")
    causes: tuple[SafetyCause | LimitCause, ...] = Field(default=(), description="why `sent` differs from the request")
    reason: str = Field(default="", description="refusal or causes in words, for a person")
    source: str = Field(default="none", description="who has the wheels now")


class GoalStatus(StrEnum):
    """Nav2's words, plus the bridge's own deadline."""

    PENDING = "PENDING"
    EXECUTING = "EXECUTING"
    SUCCEEDED = "SUCCEEDED"
    CANCELED = "CANCELED"
    ABORTED = "ABORTED"
    REJECTED = "REJECTED"
    TIMED_OUT = "TIMED_OUT"


class CandidatePose(Message):
    """A pose that would do. Of those that Nav2 finds a path to the lowest rank wins, and in it the cheapest."""

    pose: Pose2D
    cost_m: float = Field(default=0.0, ge=0.0, le=1000.0, description="counts beside the length of its path")
    rank: int = Field(default=0, ge=0, le=1000)


GOAL_ANSWER_S = 20.0
"""Whoever sends a goal waits so long for word that Nav2 has taken it, or why not."""


class GoalRequest(Message):
    """Drive to the best of the candidates, or to the nearest pose round the first that Nav2 finds a path to."""

    candidates: tuple[CandidatePose, ...] = Field(min_length=1, max_length=200)
    epoch: int = Field(ge=0)
    timeout_s: float = Field(default=120.0, gt=0.0, le=3600.0)
    clear_costmaps: bool = True
    ring_radius_m: float | None = Field(
        default=None,
        ge=0.0,
        le=3.0,
        description="how far from the first candidate it may end; 0 = at a candidate, none = the setting",
    )
    look_at: Point3D | None = Field(default=None, description="a place in map that poses on the ring face")
    session_id: str | None = Field(default=None, description="the goal is cancelled when this session ends")


class Goal(Message):
    id: str
    pose: Pose2D = Field(description="where it is driven to: a candidate, or a pose on the ring round the first")
    wanted: Pose2D | None = Field(default=None, description="the first candidate")
    candidate: int | None = Field(default=None, description="which was taken, from 0; none = none of them")
    status: GoalStatus
    attempt: int = Field(default=1, ge=1, description="2 and more: Nav2 gave up under way and was asked again")
    cause: GoalCause | None = Field(default=None, description="what ended it; none while it goes on, and on arrival")
    error_code: int = Field(default=0, description="Nav2's; 0 = none")
    error_name: str = ""
    error_msg: str = Field(default="", description="the cause in words, for a person: Nav2's own where it has any")
    distance_remaining_m: float | None = None
    stamp_s: StampS


class PathRequest(Message):
    """Is there a path to `goal`, or to the nearest pose on a ring round it? Nothing moves."""

    goal: Pose2D
    start: Pose2D | None = Field(default=None, description="none = where the robot is")
    ring_radius_m: float = Field(default=0.0, ge=0.0, le=3.0, description="0 = only to this very pose")
    look_at: Point3D | None = Field(default=None, description="a place in map that poses on the ring face")


class PathReply(Message):
    reachable: bool
    goal: Pose2D | None = Field(default=None, description="the pose that can be reached")
    length_m: float | None = None
    tried: int = Field(default=1, ge=0, description="poses that Nav2 was asked for a path to")
    error_code: int = Field(default=0, description="Nav2's ComputePathToPose code for the pose asked for; 0 = none")
    error_name: str = ""
    poses: tuple[Pose2D, ...] = ()


class BoxQuery(Message):
    """A box in the colour frame taken at `stamp_s`; the newest depth image is used where it is none."""

    bbox_xyxy: BboxXyxy
    image_width_px: ImageSidePx
    image_height_px: ImageSidePx
    stamp_s: float | None = None


class DepthReply(Message):
    distance_m: float | None = Field(
        description="to the near mode inside the box, along the optical axis; none = not measured"
    )
    spread_m: float | None = None
    samples: int = Field(default=0, ge=0)
    holes: float | None = Field(
        default=None, ge=0.0, le=1.0, description="share of the box's depth pixels that measured nothing"
    )
    age_s: float | None = None
    reason: str = ""


MAP_CELLS_MAX = 4096 * 4096


class KnownMap(Message):
    """A home that the robot has a map of, or had: known again by what stands in it, however the map is written down."""

    id: MapId
    was: tuple[MapId, ...] = Field(default=(), description="maps that a person has since said are of this home")
    first_seen_s: StampS
    last_seen_s: StampS


class SameHomeRequest(Message):
    """The map of now is of the home `id`: see `GET /maps`."""

    id: MapId


class Map(Message):
    """Occupancy grid, row 0 at the origin (ROS OccupancyGrid order); `geometry.grids` reads it."""

    width: int = Field(ge=1, le=MAP_CELLS_MAX)
    height: int = Field(ge=1, le=MAP_CELLS_MAX)
    resolution_m: float = Field(gt=0.0, le=1.0)
    origin: Pose2D = Field(description="of the corner of the first cell in map; may be turned")
    home: KnownMap | None = Field(default=None, description="which home it is of; none where nobody has looked")
    data_base64: str = Field(
        description="width*height int8 cells, zlib-compressed, base64: -1 unknown, 0 free .. 100 occupied"
    )

    @model_validator(mode="after")
    def _is_not_too_large(self) -> "Map":
        if self.width * self.height > MAP_CELLS_MAX:
            raise ValueError(f"a map has no more than {MAP_CELLS_MAX} cells")
        return self
