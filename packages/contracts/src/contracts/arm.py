"""What robot_bridge says about an arm on the robot, and what the arm can be asked to do. Joints that turn, in rad."""

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from contracts.base import NO_CONTROL_CHARACTERS, Message

JOINTS_MAX = 16
POINTS_MAX = 500
TRAJECTORY_S_MAX = 120.0
POINT_APART_S_MIN = 0.001
"""Between two points, and before the first one."""
ANGLE_RAD_MAX = 1000.0
SPEED_RAD_S_MAX = 50.0
"""Of what can be asked for: no arm is near it. What a joint may do is less, and its own."""

JointName = Annotated[str, Field(min_length=1, max_length=64, pattern=NO_CONTROL_CHARACTERS)]
Angle = Annotated[float, Field(ge=-ANGLE_RAD_MAX, le=ANGLE_RAD_MAX)]
Angles = Annotated[tuple[Angle, ...], Field(min_length=1, max_length=JOINTS_MAX)]
AngularSpeed = Annotated[float, Field(ge=-SPEED_RAD_S_MAX, le=SPEED_RAD_S_MAX)]


class ArmPart(StrEnum):
    ARM = "arm"
    """Its joints, from the foot to the wrist."""
    GRIPPER = "gripper"
    """Its jaw."""


class ArmEnd(StrEnum):
    """Every way a motion of the arm or its gripper can end."""

    COMPLETED = "completed"
    """It is where it was sent."""
    STALLED = "stalled"
    """The jaw moves no further: it holds something, or is blocked."""
    REJECTED = "rejected"
    """The controller did not take it."""
    OFF_PATH = "off_path"
    """A joint was kept off its path, and the controller gave up."""
    NOT_REACHED = "not_reached"
    """A joint did not arrive, and the controller gave up."""
    ABORTED = "aborted"
    """The controller gave up, or another client's goal took over; it says no more."""
    TIMED_OUT = "timed_out"
    """The controller had not ended it in time."""
    STOPPED = "stopped"
    """The emergency stop."""
    CANCELED = "canceled"
    """Somebody asked for its end."""
    SESSION_ENDED = "session_ended"
    """The session it belonged to has ended."""
    SHUT_DOWN = "shut_down"
    """robot_bridge is shutting down."""

    @property
    def completed(self) -> bool:
        return self is ArmEnd.COMPLETED

    @property
    def sentence(self) -> str:
        return _ENDS[self]


class ArmRefusal(StrEnum):
    """Why robot_bridge did not begin a motion of the arm: `Problem.code`, beside those of `causes.Refusal`."""

    NO_ARM = "no_arm"
    """This robot has none (`ROBOT_BRIDGE_ARM`)."""
    NO_JOINT_STATES = "no_joint_states"
    """Where the joints are is not known, or was too long ago."""
    WRONG_JOINTS = "wrong_joints"
    """It does not name each of the arm's joints once."""
    BAD_POINT = "bad_point"
    """A point has not one value for each joint."""
    BAD_TIMES = "bad_times"
    """The points' times do not rise, by 1 ms at least."""
    ENDS_MOVING = "ends_moving"
    """A joint would have a velocity at the last point; a trajectory ends at rest."""
    OUT_OF_LIMITS = "out_of_limits"
    """A joint would leave its range, at a point or between two."""
    JOINT_TOO_FAST = "joint_too_fast"
    """A joint would be faster than it may."""
    ARM_MOTION_UNDER_WAY = "arm_motion_under_way"
    """That part of the arm is moving already."""
    JOINT_MOVES = "joint_moves"
    """A joint moves, or whether it does is not known; a trajectory is checked from rest."""
    CANCEL_OWED = "cancel_owed"
    """Its controller has not answered yet that its goals are cancelled: after a stop, or since it is in reach."""


class TrajectoryPoint(Message):
    time_s: float = Field(
        ge=POINT_APART_S_MIN, le=TRAJECTORY_S_MAX, description="since the start; 1 ms at least after the point before"
    )
    positions_rad: Angles
    velocities_rad_s: tuple[AngularSpeed, ...] = Field(
        default=(), max_length=JOINTS_MAX, description="at this point; () = a straight line in joint space"
    )


class ArmTrajectoryRequest(Message):
    """From where the joints are now through the points; ends at rest at the last one (velocities 0 or left out)."""

    joints: tuple[JointName, ...] = Field(min_length=1, max_length=JOINTS_MAX, description="each of the arm's once")
    points: tuple[TrajectoryPoint, ...] = Field(min_length=1, max_length=POINTS_MAX)
    epoch: int = Field(ge=0)
    session_id: str | None = Field(default=None, max_length=64)


class GripperRequest(Message):
    opening: float = Field(ge=0.0, le=1.0, description="share of the jaw's way: 0 closed, 1 open")
    effort_share: float = Field(default=1.0, gt=0.0, le=1.0, description="of the most that the jaw may press with")
    epoch: int = Field(ge=0)
    session_id: str | None = Field(default=None, max_length=64)


class ArmHomeRequest(Message):
    speed_share: float = Field(default=0.5, gt=0.0, le=1.0, description="of the joints' top speed")
    epoch: int = Field(ge=0)
    session_id: str | None = Field(default=None, max_length=64)


class ArmReply(Message):
    end: ArmEnd
    text: str = Field(default="", max_length=500, description="the end in words, for a person")


class GripperReply(Message):
    end: ArmEnd
    opening: float | None = Field(default=None, description="where the jaw is now; none where it is not known")
    text: str = Field(default="", max_length=500, description="the end in words, for a person")


class ArmStopReply(Message):
    """What was under way and has been ended."""

    ended: tuple[ArmPart, ...] = ()


class ArmJoint(Message):
    """A joint, what it may do, and where it is; the readings are none where they are not known."""

    name: JointName
    lower_rad: float
    upper_rad: float
    speed_rad_s_max: float = Field(gt=0.0)
    position_rad: float | None = None
    velocity_rad_s: float | None = None
    effort_nm: float | None = None


class ArmState(Message):
    """`GET /arm`. A robot without an arm says `fitted: false`, and nothing else."""

    fitted: bool
    model: str = Field(default="", max_length=64)
    joints: tuple[ArmJoint, ...] = ()
    opening: float | None = Field(
        default=None, description="of the jaw: 0 closed, 1 open; none where it has not been told lately"
    )
    age_s: float | None = Field(default=None, ge=0.0, description="since the joints last told; none if they never have")
    moving: bool | None = Field(default=None, description="faster than a trembling; none where it is not known")
    under_way: tuple[ArmPart, ...] = ()


_ENDS: dict[ArmEnd, str] = {
    ArmEnd.COMPLETED: "",
    ArmEnd.STALLED: "the jaw moves no further: it holds something, or is blocked",
    ArmEnd.REJECTED: "the arm's controller rejected it",
    ArmEnd.OFF_PATH: "a joint was kept off its path",
    ArmEnd.NOT_REACHED: "a joint did not arrive",
    ArmEnd.ABORTED: "the arm's controller gave it up, or another client's goal took over",
    ArmEnd.TIMED_OUT: "the arm's controller did not end it in time",
    ArmEnd.STOPPED: "the emergency stop",
    ArmEnd.CANCELED: "cancelled",
    ArmEnd.SESSION_ENDED: "the session ended",
    ArmEnd.SHUT_DOWN: "robot_bridge is shutting down",
}
