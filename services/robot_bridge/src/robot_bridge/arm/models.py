"""Which arms the bridge knows, as data: joints, their ranges and speeds, where home is. Pure.

A new arm is a row here; names are those of its joint_states. Ranges are the arm's own, as its description has them.
"""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Of a joint that turns: rad and rad/s."""

    name: str
    lower_rad: float
    upper_rad: float
    speed_rad_s_max: float


@dataclass(frozen=True, slots=True)
class Jaw:
    """The gripper's joint: its position when closed and open, and the most it may press with, in the units of its
    GripperCommand (a jaw that turns: rad and Nm)."""

    joint: str
    closed: float
    opened: float
    effort_max: float

    def position(self, opening: float) -> float:
        """Of a share of the way: 0 closed, 1 open."""
        return self.closed + opening * (self.opened - self.closed)

    def opening(self, position: float) -> float:
        """The share of the way that a position is, within 0 and 1."""
        return min(1.0, max(0.0, (position - self.closed) / (self.opened - self.closed)))


@dataclass(frozen=True, slots=True)
class ArmModel:
    name: str
    joints: tuple[JointLimits, ...]
    home_rad: tuple[float, ...]
    """Folded: within the robot's footprint, out of its camera's and its laser's view."""
    jaw: Jaw

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joints)


SO101: Final = ArmModel(
    name="so101",
    joints=(
        JointLimits("shoulder_pan", -1.91, 1.91, 2.0),
        JointLimits("shoulder_lift", -1.74, 1.74, 2.0),
        JointLimits("elbow_flex", -1.69, 1.69, 2.0),
        JointLimits("wrist_flex", -1.65, 1.65, 2.0),
        JointLimits("wrist_roll", -2.74, 2.84, 2.0),
    ),
    home_rad=(0.0, -1.7, 1.3, -1.5, 0.0),
    jaw=Jaw("gripper", closed=-0.17, opened=1.74, effort_max=3.3),
)
"""SO-101 with its calibration of 2025 (the middle of each range is 0). Its servos reach 4.7 rad/s without a load."""

MODELS: Final = {SO101.name: SO101}
"""By the name that the setting `arm` gives."""
