"""The simulated robot's arm as the bench drives it: trajectories and the jaw, each to its end, in simulated time."""

import math
from collections.abc import Callable
from functools import cache
from typing import Final

from contracts.arm import ArmEnd
from grasping.hands import SO101_HAND
from grasping.kinematics import ArmDescription, ArmKinematics, ArmMount
from grasping.planning import Joints
from grasping.reachability import ReachabilityMap
from grasping.timing import timed
from sim.world import World
from sim.world.arm.controller import Outcome, Tolerances
from sim.world.arm.fitting import DECK_HALF_M, DECK_Z_M, FOOT_X_M
from sim.world.arm.models import SO101
from sim.world.arm.trajectory import Knot, Trajectory
from sim.world.robot import BODY_RADIUS_M

SPEED_RAD_S: Final = 0.8
TICK_S: Final = 0.05
EFFORT_NM: Final = 1.65
"""Half of what the jaw has, as robot_bridge's setting has it."""
LOADED_RAD: Final = 0.15
"""So far the joints may hang from their goal under a load that nobody told the controller."""
SHELL_TOP_M: Final = 0.092
ENDS: Final[dict[Outcome, ArmEnd]] = {
    Outcome.SUCCEEDED: ArmEnd.COMPLETED,
    Outcome.HELD: ArmEnd.STOPPED,
    Outcome.PATH_TOLERANCE: ArmEnd.OFF_PATH,
    Outcome.GOAL_TOLERANCE: ArmEnd.NOT_REACHED,
    Outcome.STALLED: ArmEnd.STALLED,
}


@cache
def kinematics() -> ArmKinematics:
    mount = ArmMount(FOOT_X_M, DECK_Z_M, BODY_RADIUS_M, SHELL_TOP_M, (DECK_HALF_M[0], DECK_HALF_M[1]))
    return ArmKinematics(ArmDescription(SO101.file(), SO101.joints, SO101.gripper, SO101_HAND), mount)


@cache
def reachability() -> ReachabilityMap:
    return kinematics().reachability()


class DrivenArm:
    """`each_tick` is called all the time, so that somebody may look on, or press the stop."""

    def __init__(self, world: World, each_tick: Callable[[], None] = lambda: None) -> None:
        if world.arm is None:
            raise ValueError("the world has no arm: WorldOptions(arm=...)")
        self.world, self.arm, self.each_tick = world, world.arm, each_tick

    @property
    def joints(self) -> Joints:
        return tuple(each.position for each in self.arm.readings())[:-1]

    @property
    def jaw_rad(self) -> float:
        return self.arm.readings()[-1].position

    def wait(self, seconds: float) -> None:
        for _ in range(math.ceil(seconds / TICK_S)):
            self.world.advance(TICK_S)
            self.each_tick()

    def follow(self, path: tuple[Joints, ...], speed_rad_s: float = SPEED_RAD_S) -> ArmEnd:
        """From where it is sent now through the postures; at rest at both ends."""
        knots = timed((self.arm.trajectory.wanted, *path), speed_rad_s)
        trajectory = Trajectory(SO101.joints, tuple(Knot(time_s, joints) for time_s, joints in knots))
        self.arm.follow(trajectory, Tolerances(goal_rad=(LOADED_RAD,) * len(SO101.joints)))
        while self.arm.trajectory.outcome is Outcome.RUNNING:
            self.wait(TICK_S)
        return ENDS[self.arm.trajectory.outcome]

    def grip(self, angle_rad: float) -> ArmEnd:
        self.arm.grip(angle_rad, EFFORT_NM)
        while self.arm.gripper.outcome is Outcome.RUNNING:
            self.wait(TICK_S)
        return ENDS[self.arm.gripper.outcome]

    def hold(self) -> None:
        """The emergency stop, as the bridge's cancel of all goals ends it."""
        self.arm.hold_arm()
        self.arm.hold_gripper()
