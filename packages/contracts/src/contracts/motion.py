"""How motion ends: types for programs, each with one sentence for people."""

from enum import StrEnum

from pydantic import Field

from contracts.base import Message


class Hazard(StrEnum):
    """Create 3's hazards, by its own names."""

    BACKUP_LIMIT = "BACKUP_LIMIT"
    BUMP = "BUMP"
    CLIFF = "CLIFF"
    STALL = "STALL"
    WHEEL_DROP = "WHEEL_DROP"
    OBJECT_PROXIMITY = "OBJECT_PROXIMITY"


class MotionEnd(StrEnum):
    """Every way a rotation or a drive can end. What a mission makes of each stands in `coordinator.core.reactions`."""

    COMPLETED = "completed"
    """The angle or the distance asked for is reached."""
    BLOCKED = "blocked"
    """The laser sees an obstacle in the way."""
    HAZARD = "hazard"
    """The base feels a bump, a cliff, a stalled wheel or its backup limit; `hazards` names which."""
    LIFTED = "lifted"
    """A wheel hangs in the air."""
    BLIND = "blind"
    """The laser says nothing about the way."""
    NO_SCAN = "no_scan"
    """There is no laser scan, or it is too old to act on."""
    NO_ODOMETRY = "no_odometry"
    """There is no odometry, or it is too old to act on."""
    TIMED_OUT = "timed_out"
    """Its own time was up."""
    HELD_BACK = "held_back"
    """Nothing of it reached the wheels, and neither the laser nor the base says why."""
    PREEMPTED = "preempted"
    """Another source has the wheels, or a navigation goal took over."""
    BASE_BUSY = "base_busy"
    """The base drives itself: it docks or undocks."""
    STOPPED = "stopped"
    """The emergency stop."""
    RESET = "reset"
    """The emergency stop was reset: what was asked for before is over."""
    SESSION_ENDED = "session_ended"
    """The session it belonged to has ended."""
    CLIENT_LEFT = "client_left"
    """The connection it was asked for on has closed."""
    CANCELED = "canceled"
    """Somebody asked for its end."""
    SHUT_DOWN = "shut_down"
    """robot_bridge is shutting down."""

    @property
    def completed(self) -> bool:
        return self is MotionEnd.COMPLETED

    @property
    def says_something_is_ahead(self) -> bool:
        """True when something stands in the way: the robot is as near as it can get.

        A cliff is not: the floor ends there, and what lies beyond was not reached. A bump is not either: what was
        touched may be anything, at any side, and the laser did not see it.
        """
        return self is MotionEnd.BLOCKED

    @property
    def sentence(self) -> str:
        return _MOTION_ENDS[self]


class BaseEnd(StrEnum):
    """How it ended what the base does by itself: docking and undocking."""

    COMPLETED = "completed"
    """It stands on its dock, or is off it."""
    ALREADY_THERE = "already_there"
    """It was docked before it was asked."""
    TIMED_OUT = "timed_out"
    """Its time was up."""
    STOPPED = "stopped"
    """The emergency stop."""
    CANCELED = "canceled"
    """Somebody asked for its end."""
    SESSION_ENDED = "session_ended"
    """The session it belonged to has ended."""
    NOT_BEFORE_DOCK = "not_before_dock"
    """It did not get in front of the dock."""
    DOCK_NOT_SEEN = "dock_not_seen"
    """The base does not see the dock: it gave up, or was not asked."""
    GAVE_UP = "gave_up"
    """The base gave up."""

    @property
    def completed(self) -> bool:
        return self in {BaseEnd.COMPLETED, BaseEnd.ALREADY_THERE}

    @property
    def sentence(self) -> str:
        return _BASE_ENDS[self]


class RotateRequest(Message):
    angle_rad: float = Field(ge=-12.6, le=12.6, description="relative, counter-clockwise positive")
    speed_rad_s: float = Field(default=1.0, gt=0.0, le=4.0, description="the bridge refuses more than the base can")
    timeout_s: float = Field(default=20.0, gt=0.0, le=60.0)
    epoch: int = Field(ge=0)
    session_id: str | None = None


class DriveRequest(Message):
    distance_m: float = Field(ge=-2.0, le=2.0, description="along base_link x; negative needs allow_reverse")
    speed_m_s: float = Field(default=0.15, gt=0.0, le=2.0, description="the bridge refuses more than the base can")
    timeout_s: float = Field(default=20.0, gt=0.0, le=60.0)
    allow_reverse: bool = False
    epoch: int = Field(ge=0)
    session_id: str | None = None


class RotateReply(Message):
    end: MotionEnd
    turned_rad: float = Field(description="by odometry, counter-clockwise positive")
    hazards: tuple[Hazard, ...] = Field(default=(), description="those that ended it")
    text: str = Field(default="", max_length=300, description="the end in words, for a person")


class DriveReply(Message):
    end: MotionEnd
    driven_m: float = Field(description="by odometry, forward positive")
    hazards: tuple[Hazard, ...] = Field(default=(), description="those that ended it")
    text: str = Field(default="", max_length=300, description="the end in words, for a person")


class EndedMotion(Message):
    """`DELETE /motion`: what was under way, and how far it had come; both none where nothing was."""

    turned_rad: float | None = None
    driven_m: float | None = None


class BaseReply(Message):
    end: BaseEnd
    text: str = Field(default="", max_length=500, description="the end in words, for a person")


class MotionGains(Message):
    """How closed-loop turning and driving are tuned; a change acts on the motion under way."""

    heading_kp: float = Field(ge=0.0, le=20.0, description="rad/s per rad")
    heading_ki: float = Field(ge=0.0, le=20.0, description="rad/s per rad s")
    heading_kd: float = Field(ge=0.0, le=20.0, description="rad/s per rad/s")
    drive_kp: float = Field(ge=0.0, le=20.0, description="m/s per m")
    drive_ki: float = Field(ge=0.0, le=20.0, description="m/s per m s")
    drive_kd: float = Field(ge=0.0, le=20.0, description="m/s per m/s")
    turn_tolerance_rad: float = Field(gt=0.0, le=0.2, description="a turn is done this near to its angle")
    drive_tolerance_m: float = Field(gt=0.0, le=0.1, description="a drive is done this near to its distance")
    turn_rad_s_min: float = Field(ge=0.0, le=0.5, description="slower than this the base does not turn")
    drive_m_s_min: float = Field(ge=0.0, le=0.1, description="slower than this the base does not drive")
    blocked_s_max: float = Field(gt=0.0, le=10.0, description="given up when nothing reaches the base for so long")


_MOTION_ENDS: dict[MotionEnd, str] = {
    MotionEnd.COMPLETED: "",
    MotionEnd.BLOCKED: "an obstacle is in the way",
    MotionEnd.HAZARD: "the base reports a hazard",
    MotionEnd.LIFTED: "a wheel hangs in the air",
    MotionEnd.BLIND: "the laser is blind that way",
    MotionEnd.NO_SCAN: "no fresh laser scan",
    MotionEnd.NO_ODOMETRY: "no odometry",
    MotionEnd.TIMED_OUT: "it took too long",
    MotionEnd.HELD_BACK: "the wheels did not move",
    MotionEnd.PREEMPTED: "another controller drives the robot",
    MotionEnd.BASE_BUSY: "the base is docking or undocking",
    MotionEnd.STOPPED: "the emergency stop",
    MotionEnd.RESET: "the emergency stop was reset",
    MotionEnd.SESSION_ENDED: "the session ended",
    MotionEnd.CLIENT_LEFT: "the requester disconnected",
    MotionEnd.CANCELED: "cancelled",
    MotionEnd.SHUT_DOWN: "robot_bridge is shutting down",
}

_BASE_ENDS: dict[BaseEnd, str] = {
    BaseEnd.COMPLETED: "",
    BaseEnd.ALREADY_THERE: "it is docked already",
    BaseEnd.TIMED_OUT: "it took too long",
    BaseEnd.STOPPED: "the emergency stop",
    BaseEnd.CANCELED: "cancelled",
    BaseEnd.SESSION_ENDED: "the session ended",
    BaseEnd.NOT_BEFORE_DOCK: "it did not get in front of the dock",
    BaseEnd.DOCK_NOT_SEEN: "the base does not see the dock",
    BaseEnd.GAVE_UP: "the base gave up",
}
