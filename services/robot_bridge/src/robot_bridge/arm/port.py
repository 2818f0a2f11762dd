"""What the bridge needs of an arm: a real one over ROS 2, or a fake one in tests."""

from typing import Protocol

from contracts.arm import ArmEnd, ArmPart, TrajectoryPoint
from mesh.latest_value import LatestValue
from robot_bridge.arm.joint_states import JointStates
from robot_bridge.arm.models import ArmModel


class ArmGoal(Protocol):
    """A goal that one of the arm's controllers has taken."""

    async def end(self) -> ArmEnd:
        """Waits for the end, however long it takes."""
        ...


class RobotArm(Protocol):
    """Raises `UnavailableError` where the controller that it needs is away."""

    @property
    def model(self) -> ArmModel: ...

    @property
    def joints(self) -> LatestValue[JointStates]: ...

    def missing(self) -> str:
        """What of it is not there, in words; '' where all of it is."""
        ...

    async def follow(self, points: tuple[TrajectoryPoint, ...]) -> ArmGoal | None:
        """Sends a trajectory, joints in the model's order; none when the controller rejects it."""
        ...

    async def grip(self, position: float, effort_max: float) -> ArmGoal | None:
        """Sends the jaw somewhere, in the units of its GripperCommand; none when the controller rejects it."""
        ...

    def cancel(self, part: ArmPart) -> None:
        """Every goal of that part's controller, whoever sent it: its joints stay where they are. Waits for nothing,
        and is owed until the controller has answered, however long that takes."""
        ...

    def owes_cancel(self, part: ArmPart) -> bool:
        """Whether that part's controller has yet to answer a `cancel`, or what it does is not known; no goal is to be
        sent to it then."""
        ...
