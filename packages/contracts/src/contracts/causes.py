"""What holds motion back and why it is refused: types for programs, each with one sentence for people."""

from enum import StrEnum

from contracts.motion import MotionEnd


class SafetyCause(StrEnum):
    """What the safety filter holds a velocity back for, the gravest first."""

    BASE_STOPPED = "base_stopped"
    """The base has disabled its wheels, as after a stop pressed at the robot: nothing moves."""
    STRANGER = "stranger"
    """Somebody else tells the base to move: nothing of ours mixes with it."""
    WHEEL_DROP = "wheel_drop"
    """A wheel hangs in the air: nothing moves."""
    NO_SCAN = "no_scan"
    """No laser scan, or a very old one: nothing moves."""
    OLD_SCAN = "old_scan"
    """The laser scan is too old to translate by."""
    NOT_UNDERSTOOD = "scan_not_understood"
    """What the laser sends cannot be understood: nothing is known of the way."""
    BLIND = "blind"
    """Something could stand within the stop distance on the way, where no beam of the laser says anything."""
    NO_ODOMETRY = "no_odometry"
    """No odometry, or too old a one, to translate by."""
    HAZARD = "hazard"
    """The base feels what this motion would make worse."""
    OBSTACLE = "obstacle"
    """Something stands within the stop distance on the way."""
    SLOWED = "slowed"
    """Something stands within the slow distance on the way: slower, not stopped."""

    @property
    def ends_as(self) -> MotionEnd | None:
        """How a motion ends that it keeps from moving; none where it only slows it."""
        return _ENDS_AS.get(self)


class LimitCause(StrEnum):
    """What the arbiter changes a velocity for; none of it keeps a motion from going on."""

    SPEED = "speed_limit"
    """Faster than the robot may."""
    ACCELERATION = "acceleration_limit"
    """Speeding up quicker than the robot may."""
    NO_REVERSE = "no_reverse"
    """Backwards, which the request does not allow."""
    HANDOVER = "handover"
    """A pause after the source that had the wheels before."""

    @property
    def sentence(self) -> str:
        return _LIMITS[self]


class Refusal(StrEnum):
    """Why robot_bridge did not begin what was asked for: `Problem.code`, or `VelocityReply.refusal`."""

    NOT_FINITE = "not_finite"
    """A velocity that is no number."""
    BAD_DURATION = "bad_duration"
    """A lease that would not end, or last longer than a lease may."""
    STALE = "stale"
    """Decided too long ago."""
    FROM_THE_FUTURE = "from_the_future"
    """Stamped later than now."""
    OUT_OF_ORDER = "out_of_order"
    """Decided before the last one of the same source."""
    OLD_EPOCH = "old_epoch"
    """From before the last emergency stop (or from no epoch there ever was)."""
    STOPPED = "stopped"
    """The emergency stop is latched."""
    RESERVED = "reserved"
    """EMERGENCY and SAFETY belong to the bridge, and so do the names of its own sources."""
    TOO_MANY = "too_many_leases"
    """More sources at once than a robot can have."""
    BASE_BUSY = "base_busy"
    """The base drives itself (docking or undocking)."""
    MALFORMED = "malformed"
    """Not a request at all."""
    NO_TICK = "no_tick"
    """The loop that sends velocities does not run."""
    SESSION_OVER = "session_over"
    """Its session is unknown or has ended."""
    MOTION_UNDER_WAY = "motion_under_way"
    """A rotation or a drive has to end first."""
    GOAL_UNDER_WAY = "goal_under_way"
    """A navigation goal has to end first."""
    GOAL_OVER = "goal_over"
    """The navigation goal that a recovery is part of has ended."""
    DOCKING_UNDER_WAY = "docking_under_way"
    """It docks or undocks already."""
    NO_REVERSE = "no_reverse"
    """Backwards, which the request does not allow."""
    TOO_FAST = "too_fast"
    """Faster than the base can."""
    CLIENT_LEFT = "client_left"
    """The connection it was asked for on has closed."""
    NO_DOCK_STATUS = "no_dock_status"
    """The base does not tell whether it is docked."""
    NOT_DOCKED = "not_docked"
    """There is no dock to leave."""
    DOCK_UNKNOWN = "dock_unknown"
    """Nobody knows where the dock is, and the base does not see it."""
    DOCK_OUT_OF_REACH = "dock_out_of_reach"
    """The base does not see the dock, and the robot cannot navigate to it now."""
    NO_MAP = "no_map"
    """No map has been received yet."""
    OUTSIDE_MAP = "outside_map"
    """The pose is not on the map."""
    NO_NAV2 = "no_nav2"
    """Nav2 is not there, or not active."""
    CELEBRATED = "celebrated"
    """It has just done so."""


class GoalCause(StrEnum):
    """What ended a navigation goal that did not succeed. `NAV2` has Nav2's own error code beside it."""

    NAV2 = "nav2"
    """Nav2 gave up, or cancelled it; `error_code` says why."""
    NAV2_SILENT = "nav2_silent"
    """Nav2 aborted it and gave no code: an everyday end on a busy computer."""
    HELD = "held"
    """Nav2 gave up because the safety filter let nothing of what it wanted to drive pass."""
    FOREIGN_GOAL = "foreign_goal"
    """Another client of Nav2 sent a goal, which ended this one."""
    REJECTED = "rejected"
    """Nav2 did not take it."""
    UNREACHABLE = "unreachable"
    """The planner found no path to it, nor to a pose round it."""
    NAV2_GONE = "nav2_gone"
    """Nav2 is not there any more, or does not answer."""
    TIMED_OUT = "timed_out"
    """Its own time was up."""
    STOPPED = "stopped"
    """The emergency stop."""
    SESSION_ENDED = "session_ended"
    """The session it belonged to has ended."""
    CLIENT_LEFT = "client_left"
    """Whoever asked for it has gone."""
    PREEMPTED = "preempted"
    """Another goal took over."""
    CANCELED = "canceled"
    """Somebody asked for its end."""
    DOCKING_ENDED = "docking_ended"
    """The docking that needed it was given up."""
    SHUT_DOWN = "shut_down"
    """robot_bridge is shutting down."""

    @property
    def sentence(self) -> str:
        return _GOAL_CAUSES[self]


_ENDS_AS: dict[SafetyCause, MotionEnd] = {
    SafetyCause.BASE_STOPPED: MotionEnd.STOPPED,
    SafetyCause.STRANGER: MotionEnd.PREEMPTED,
    SafetyCause.WHEEL_DROP: MotionEnd.LIFTED,
    SafetyCause.NO_SCAN: MotionEnd.NO_SCAN,
    SafetyCause.OLD_SCAN: MotionEnd.NO_SCAN,
    SafetyCause.NOT_UNDERSTOOD: MotionEnd.NO_SCAN,
    SafetyCause.BLIND: MotionEnd.BLIND,
    SafetyCause.NO_ODOMETRY: MotionEnd.NO_ODOMETRY,
    SafetyCause.HAZARD: MotionEnd.HAZARD,
    SafetyCause.OBSTACLE: MotionEnd.BLOCKED,
}

_LIMITS: dict[LimitCause, str] = {
    LimitCause.SPEED: "speed limit",
    LimitCause.ACCELERATION: "acceleration limit",
    LimitCause.NO_REVERSE: "reverse is not allowed",
    LimitCause.HANDOVER: "a pause after the last source",
}

_GOAL_CAUSES: dict[GoalCause, str] = {
    GoalCause.NAV2: "Nav2 gave it up and said no reason",
    GoalCause.NAV2_SILENT: "Nav2 gave no reason; its tree may have waited too long for a server",
    GoalCause.HELD: "the safety filter held the robot",
    GoalCause.FOREIGN_GOAL: "another client of Nav2 sent a goal",
    GoalCause.REJECTED: "Nav2 rejected the goal",
    GoalCause.UNREACHABLE: "there is no path to it",
    GoalCause.NAV2_GONE: "Nav2 is gone",
    GoalCause.TIMED_OUT: "the goal's time is up",
    GoalCause.STOPPED: "the emergency stop",
    GoalCause.SESSION_ENDED: "the session ended",
    GoalCause.CLIENT_LEFT: "whoever asked for it has gone",
    GoalCause.PREEMPTED: "another goal took over",
    GoalCause.CANCELED: "somebody asked for its end",
    GoalCause.DOCKING_ENDED: "docking ended",
    GoalCause.SHUT_DOWN: "robot_bridge is shutting down",
}
