"""The SO-101 on the simulated robot, as `grasping` describes it."""

from functools import cache
from pathlib import Path

from grasping.hands import SO101_HAND
from grasping.kinematics import ArmDescription, ArmKinematics, ArmMount
from grasping.reachability import ReachabilityMap
from sim.world.arm.fitting import DECK_HALF_M, DECK_Z_M, FOOT_X_M
from sim.world.arm.models import SO101
from sim.world.robot import BODY_RADIUS_M

MOUNT = ArmMount(FOOT_X_M, DECK_Z_M, BODY_RADIUS_M, 0.092, (DECK_HALF_M[0], DECK_HALF_M[1]))


def description(mjcf: Path | None = None) -> ArmDescription:
    return ArmDescription(mjcf or SO101.file(), SO101.joints, SO101.gripper, SO101_HAND)


@cache
def kinematics() -> ArmKinematics:
    """One for all tests of a process: it is posed anew by each question."""
    return ArmKinematics(description(), MOUNT)


@cache
def reachability() -> ReachabilityMap:
    return kinematics().reachability()
